"""The graph that is left of a contracted mesh."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from lbskel import collapse, contract


def test_nodes_are_vertices_of_the_contracted_mesh_and_every_vertex_has_one(ring):
    contraction = contract(ring)
    graph = collapse(contraction)
    assert np.array_equal(graph.nodes, contraction.coarse.vertices[graph.kept])
    assert graph.node_of_vertex.shape == (len(ring.vertices),)
    assert set(graph.node_of_vertex) == set(range(len(graph.nodes)))
    assert graph.edges.max() < len(graph.nodes)
    with pytest.raises(FrozenInstanceError):
        graph.nodes = graph.nodes
