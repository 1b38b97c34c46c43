"""Graphs of surfaces: paths on them are about as long as on the surface, however it is triangulated."""

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from lbskel import Mesh
from lbskel.geometry.graphs import edge_length_graph, shortest_edges
from lbskel.geometry.surface_graph import surface_graph
from lbskel.shapes import sphere


def distances_from(mesh, vertex):
    graph = surface_graph(mesh)
    pairs = np.concatenate([graph.edges, graph.diagonals])
    lengths = np.concatenate([graph.lengths, graph.diagonal_lengths])
    return dijkstra(shortest_edges(pairs, lengths, len(mesh.vertices)), indices=vertex)


def test_paths_across_a_fan_are_straight():
    angles = 2 * np.pi * np.arange(40) / 40
    rim = np.stack([4 * np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    fan = Mesh(rim, np.stack([np.zeros(38, dtype=int), np.arange(1, 39), np.arange(2, 40)], axis=1))
    # from one corner of the middle of the plate to the opposite one: along the fan's edges, around by its first vertex
    straight = np.linalg.norm(rim[10] - rim[30])
    assert dijkstra(edge_length_graph(fan), directed=False, indices=10)[30] > 4 * straight
    assert distances_from(fan, 10)[30] == pytest.approx(straight, rel=1e-9)
    # elsewhere a path leads along the rim, since there is no vertex within
    true = np.delete(np.linalg.norm(rim - rim[10], axis=1), 10)
    assert (np.delete(distances_from(fan, 10), 10) / true).mean() == pytest.approx(1.048, abs=0.001)
    assert (np.delete(dijkstra(edge_length_graph(fan), directed=False, indices=10), 10) / true).mean() > 1.5


def test_the_diagonal_of_two_triangles_is_that_of_them_unfolded():
    square = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 1, 0]]  # two halves of a square, at a right angle to each other
    graph = surface_graph(Mesh(np.array(square, dtype=float)[[0, 1, 2, 3]], [[0, 1, 2], [1, 0, 3]]))
    assert len(graph.edges) == 5
    assert [set(pair) for pair in graph.diagonals.tolist()] == [{2, 3}]
    # across the edge from 0 to 1, to one half a unit sideways and up, to the other half a unit down
    assert graph.diagonal_lengths == pytest.approx([np.hypot(1, 2)])


def test_a_pair_of_triangles_with_a_reflex_corner_has_no_diagonal():
    arrow = [[0, 0, 0], [0, 2, 0], [-1, -1, 0], [1, -1, 0.0]]
    graph = surface_graph(Mesh(arrow, [[0, 1, 2], [0, 3, 1]]))
    assert len(graph.edges) == 5
    assert len(graph.diagonals) == 0


def test_faces_that_cannot_be_glued_keep_their_edges():
    book = Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0.0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    graph = surface_graph(book)
    assert np.array_equal(graph.edges, book.edges)
    assert graph.lengths == pytest.approx(book.edge_lengths)
    assert len(graph.diagonals) == 0


def test_an_edge_without_length_is_an_edge():
    graph = surface_graph(Mesh([[0, 0, 0], [0, 0, 0], [3, 4, 0], [0, 4, 0.0]], [[0, 1, 2], [1, 0, 3]]))
    assert len(graph.edges) == 5
    assert (graph.lengths > 0).all()
    assert sorted(graph.lengths) == pytest.approx([0, 4, 4, 5, 5], abs=1e-9)


def test_distances_on_a_sphere():
    ball = sphere(4)
    cosines = np.clip(ball.vertices @ ball.vertices[0], -1, 1)
    found, true = distances_from(ball, 0), np.arccos(cosines)
    # on equilateral triangles a path is at most 1 / cos(15 degrees), 3.5 %, longer, as edges and diagonals are 30
    # degrees apart, and 15.5 % along edges alone; the edges of a sphere's triangles differ by 18 %
    assert (found[1:] / true[1:]).max() < 1.05
    assert (found[1:] / true[1:]).mean() < 1.02
    assert (found >= 0.999 * true).all()  # chords are a little shorter than arcs
    along_edges = dijkstra(edge_length_graph(ball), directed=False, indices=0)
    assert (along_edges[1:] / true[1:]).max() > 1.2
