"""Half-edges in pairs, faces breadth first, and the branches of graphs, against walks in plain Python."""

from itertools import pairwise

import numpy as np
import pytest

from lbskel.geometry.mesh import Mesh
from lbskel.shapes import torus
from lbskel.skeleton.skeleton import Skeleton


def test_half_edges_pair_where_an_edge_has_two_faces(kernel):
    mesh = Mesh(np.random.default_rng(0).random((5, 3)), [[0, 1, 2], [1, 0, 3], [2, 1, 4], [1, 2, 0]])
    twins = kernel.pair_half_edges(mesh.edge_of_half_edge, mesh.faces_per_edge)
    paired = np.flatnonzero(twins >= 0)
    assert np.array_equal(twins[twins[paired]], paired)
    assert np.array_equal(np.sort(mesh.half_edges[paired]), np.sort(mesh.half_edges[twins[paired]]))
    assert np.array_equal(np.unique(mesh.edge_of_half_edge[paired]), np.flatnonzero(mesh.faces_per_edge == 2))


def test_faces_are_entered_from_those_entered_before(kernel):
    mesh = torus(1.0, 0.3, 9, 6)
    m = len(mesh.faces)
    twins = kernel.pair_half_edges(mesh.edge_of_half_edge, mesh.faces_per_edge)
    entered = kernel.breadth_first_faces(twins, np.array([m + 4]))
    assert entered[0] == m + 4
    assert np.array_equal(np.sort(entered % m), np.arange(m))
    place = np.argsort(entered % m)
    from_place = place[twins[entered[1:]] % m]  # of the face across, which comes before, and in the same order
    assert (from_place < np.arange(1, m)).all()
    assert (np.diff(from_place) >= 0).all()


def test_faces_of_several_parts_are_entered_in_turn(kernel):
    twins = np.full(9, -1)  # three triangles apart from each other
    assert kernel.breadth_first_faces(twins, np.array([5, 0])).tolist() == [5, 0]


def walked(kernel, edges, n):
    skeleton = Skeleton(np.zeros((n, 3)), edges, np.ones(n))
    nodes, begins = kernel.walk_branches(*skeleton.adjacency)
    return [nodes[begin:end].tolist() for begin, end in pairwise(begins)]


@pytest.mark.parametrize(
    ("edges", "branches"),
    [
        ([[0, 1], [1, 2], [1, 3], [3, 4]], [[0, 1], [1, 2], [1, 3, 4]]),
        ([[0, 1], [1, 2], [0, 2]], [[0, 1, 2, 0]]),
        ([[0, 1], [1, 2], [2, 3], [1, 3], [4, 5], [5, 6], [4, 6]], [[0, 1], [1, 2, 3, 1], [4, 5, 6, 4]]),
        ([[0, 2], [1, 2], [0, 3], [1, 3], [0, 1]], [[0, 1], [0, 2, 1], [0, 3, 1]]),
        (np.empty((0, 2), dtype=int), []),
    ],
    ids=["fork", "loop", "loop on a stalk and one alone", "three between two", "no edge"],
)
def test_branches_go_from_junction_to_junction(kernel, edges, branches):
    assert walked(kernel, edges, 7) == branches


def test_branches_have_every_edge_once(kernel):
    random = np.random.default_rng(1)
    for n_edges in (5, 20, 60):
        edges = np.unique(np.sort(random.integers(0, 30, (n_edges, 2)), axis=1), axis=0)
        edges = edges[edges[:, 0] < edges[:, 1]]
        paths = walked(kernel, edges, 30)
        along = [pair for path in paths for pair in pairwise(path)]
        assert sorted(tuple(sorted(pair)) for pair in along) == sorted(map(tuple, edges.tolist()))
        degrees = np.bincount(edges.ravel(), minlength=30)
        assert all((degrees[path[1:-1]] == 2).all() for path in paths)
        assert all((degrees[[path[0], path[-1]]] != 2).all() or path[0] == path[-1] for path in paths)


def test_sums_begin_anew_on_each_path(kernel):
    sums = kernel.sums_along_paths(np.array([9.0, 1, 2, 9, 3, 9]), np.array([0, 3, 5, 6]))
    assert sums.tolist() == [0, 1, 3, 0, 3, 0]
