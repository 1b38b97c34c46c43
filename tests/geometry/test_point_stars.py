"""Stars of points: their rings, and what they have of a mesh."""

import numpy as np

from lbskel.geometry.point_stars import PointStars, distinct_points, ring_edges, surface_variation
from lbskel.shapes import torus

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
CLOSED = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]


def test_a_closed_ring_ends_with_the_point_that_it_begins_with():
    stars = PointStars(POINTS, CLOSED)
    assert stars.ring_edges.tolist() == [[0, 1], [0, 2], [0, 3], [0, 4], [0, 1]]
    assert not stars.is_closed
    assert repr(stars) == "PointStars(5 points, 4 triangles)"


def test_an_open_ring_has_each_point_once():
    stars = PointStars(POINTS, [*CLOSED[:2], [1, 0, 2]])
    assert stars.ring_edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 0], [1, 2]]


def test_moved_points_keep_their_stars():
    moved = PointStars(POINTS, CLOSED).with_vertices(POINTS * 2)
    assert isinstance(moved, PointStars)
    assert moved.vertices[1, 0] == 2


def test_the_rings_of_a_mesh_are_its_edges_in_both_directions():
    mesh = torus(1.0, 0.3, 8, 6)
    pairs = ring_edges(mesh)
    assert len(pairs) == 2 * len(mesh.edges)
    assert np.bincount(pairs[:, 0]).tolist() == np.bincount(mesh.edges.ravel()).tolist()


def test_distinct_points_are_the_first_of_each_place_in_their_order():
    points = np.array([[2.0, 0, 0], [0, 1, 0], [2, 0, 0], [0, 0, -0.0], [0, 1, 0], [0, 0, 0.0], [2, 0, 1e-16]])
    first, place = distinct_points(points)
    assert first.tolist() == [0, 1, 3, 6]
    assert place.tolist() == [0, 1, 0, 2, 1, 2, 3]


def test_a_flat_neighborhood_has_no_variation_and_one_that_fills_space_a_third():
    corners = np.array(np.meshgrid([0.0, 1], [0.0, 1], [0.0, 1])).reshape(3, -1).T
    flat = np.flatnonzero(corners[:, 2] == 0)
    assert surface_variation(corners, flat[None]).tolist() == [0]
    assert np.allclose(surface_variation(corners, np.arange(8)[None]), 1 / 3)
