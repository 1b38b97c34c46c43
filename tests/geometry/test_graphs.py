"""Graphs for scipy.sparse.csgraph."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel import Mesh
from lbskel.geometry.graphs import (
    connected_labels,
    edge_length_graph,
    positive_edge_lengths,
    shortest_edges,
    shortest_paths,
    weighted_graph,
)
from lbskel.shapes import flat_grid


def test_indices_are_those_that_every_scipy_takes():
    edges = np.array([[0, 2], [1, 2]], dtype=np.int64)
    graph = weighted_graph(edges, np.array([3.0, 4.0]), 4)
    assert graph.indices.dtype == graph.indptr.dtype == np.int32
    assert graph.toarray().tolist() == [[0, 0, 3, 0], [0, 0, 4, 0], [0, 0, 0, 0], [0, 0, 0, 0]]


def test_nodes_that_edges_of_any_direction_connect_have_one_label():
    repeated = np.repeat([[2, 0], [2, 3]], 256, axis=0)
    assert connected_labels(repeated, 5).tolist() == [0, 1, 0, 0, 2]
    assert connected_labels(np.empty((0, 2), dtype=np.int64), 2).tolist() == [0, 1]


def test_an_edge_without_length_is_an_edge():
    mesh = Mesh([[0, 0, 0], [0, 0, 0], [3, 4, 0.0]], [[0, 1, 2]])
    graph = edge_length_graph(mesh)
    assert graph.data.min() > 0  # a sum drops entries of 0
    assert sorted(graph.data) == pytest.approx([0, 0, 5, 5, 5, 5], abs=1e-8)  # lengths are multiples of 2^-27


@pytest.mark.parametrize("unit", [1.0, 1e-30, 1e30])
def test_equal_edges_and_sums_of_them_are_equal_in_any_unit_and_pose(unit):
    grid = flat_grid(20, 20)
    turned = grid.with_vertices(unit * grid.vertices @ Rotation.from_euler("xyz", [0.3, 1.0, 2.0]).as_matrix())
    starts, ends = grid.vertices[grid.edges].transpose(1, 0, 2)
    is_side = (starts == ends).sum(axis=1) == 2  # not across a square
    lengths = positive_edge_lengths(turned)
    assert is_side.sum() == 2 * 20 * 19
    assert len(np.unique(lengths[is_side])) == 1
    assert sum(lengths[is_side].tolist()) == is_side.sum() * lengths[is_side][0]


def test_a_mesh_at_one_point_has_edges_too():
    assert (positive_edge_lengths(Mesh(np.zeros((3, 3)), [[0, 1, 2]])) > 0).all()


def test_the_shortest_of_parallel_edges_counts_and_loops_do_not():
    edges = np.array([[0, 1], [1, 0], [2, 2], [1, 2]])
    graph = shortest_edges(edges, np.array([3.0, 2.0, 1.0, 5.0]), 4)
    assert graph.toarray().tolist() == [[0, 2, 0, 0], [2, 0, 5, 0], [0, 5, 0, 0], [0, 0, 0, 0]]


def test_paths_follow_edges_in_their_direction():
    graph = weighted_graph(np.array([[0, 1], [1, 2], [0, 2]]), np.array([1.0, 2.0, 5.0]), 3)
    assert shortest_paths(graph).distances(np.array([0, 2])).tolist() == [[0, 1, 3], [np.inf, np.inf, 0]]
