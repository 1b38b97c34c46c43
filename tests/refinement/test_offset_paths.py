"""Paths below a surface, against scipy's shortest paths along the edges of the mesh moved inwards."""

import numpy as np
import pytest
from helpers import joined, moved
from scipy.sparse.csgraph import dijkstra

from lbskel import Mesh
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.offset_paths import paths_below_surface
from lbskel.shapes import sphere, tube


@pytest.fixture
def ring():
    """Nine tenths of a ring of radius 1 and width 0.2, and points on its axis."""
    t = np.linspace(0, 1.9 * np.pi, 120)
    axis = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    return tube(axis, 0.1), axis


def expected_path(mesh, start, end, depth):
    entry, inward, thickness = Surface(mesh).inner_offset(np.arange(len(mesh.vertices)))
    V = entry + np.minimum(thickness / 2, depth)[:, None] * inward
    lengths = np.linalg.norm(V[mesh.edges[:, 0]] - V[mesh.edges[:, 1]], axis=1)
    first, last = (np.linalg.norm(V - point, axis=1).argmin() for point in (start, end))
    graph = weighted_graph(mesh.edges, lengths, len(V))
    distances, previous = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    path = [last]
    while path[-1] != first:
        path.append(previous[path[-1]])
    return V[path[::-1]], distances[last]


@pytest.mark.parametrize("depth", [0.01, 0.05, 1.0])
def test_paths_are_the_shortest_along_the_offset_edges(ring, depth):
    mesh, axis = ring
    starts, ends = axis[[2, 5, 60]] + [0.03, 0.02, 0.01], axis[[117, 40, 61]] + [0.0, 0.01, 0.04]
    found = paths_below_surface(starts, ends, np.full(3, depth), Surface(mesh))
    for path, start, end in zip(found, starts, ends, strict=True):
        expected, length = expected_path(mesh, start, end, depth)
        assert np.array_equal(path[[0, -1]], expected[[0, -1]])
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(length, rel=1e-12)
    assert len(found[0]) > 60  # all around, though its ends are a tenth of the ring apart


def test_vertices_that_no_face_uses_are_passed_over():
    """One lies where the path begins."""
    ball, ends = sphere(2), [[[0.9, 0, 0]], [[0, 0.9, 0]]]
    strewn = Mesh(np.concatenate([ends[0], ball.vertices]), ball.faces + 1)
    one, other = (paths_below_surface(*np.array(ends), np.array([0.1]), Surface(mesh))[0] for mesh in (ball, strewn))
    assert other == pytest.approx(one, abs=1e-5)  # rays start a millionth of the diameter bound below the surface


def test_where_there_is_no_path_the_end_is_left():
    """Between two spheres."""
    two = joined(sphere(1), moved(sphere(1), 5.0))
    [path] = paths_below_surface(np.zeros((1, 3)), np.array([[5.0, 0, 0]]), np.array([0.1]), Surface(two))
    assert path.shape == (1, 3)
    assert np.linalg.norm(path[0] - [5, 0, 0]) < 1
