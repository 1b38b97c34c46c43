"""Graphs for scipy.sparse.csgraph."""

import numpy as np

from lbskel.geometry.graphs import weighted_graph


def test_indices_are_those_that_every_scipy_takes():
    edges = np.array([[0, 2], [1, 2]], dtype=np.int64)
    graph = weighted_graph(edges, np.array([3.0, 4.0]), 4)
    assert graph.indices.dtype == graph.indptr.dtype == np.int32
    assert graph.toarray().tolist() == [[0, 0, 3, 0], [0, 0, 4, 0], [0, 0, 0, 0], [0, 0, 0, 0]]
