"""Tubes: the feet of points on round cones."""

import numpy as np
import pytest

from lbskel.refinement.tubes import Tubes, feet_on_tubes, nearest_balls_by_power
from lbskel.shapes import make


def test_the_foot_on_a_cone_is_where_the_sphere_touches_it():
    """Its radius falls from 1 to 0.5 over a length of 1: normals lead back by 30 degrees."""
    tubes = Tubes(np.array([[0, 1]]), np.array([[0.0, 0, 0], [0, 0, 1]]), np.array([1.0, 0.5]))
    place, radius = 0.3, 0.85
    point = np.array([[radius * np.cos(np.pi / 6), 0, place + radius * np.sin(np.pi / 6)]])
    feet = feet_on_tubes(tubes, point, np.array([[0]]))
    assert (feet.shares[0], feet.radii[0]) == pytest.approx((place, radius), abs=1e-12)
    assert feet.distances[0] == pytest.approx(0, abs=1e-12)


def test_the_nearest_cone_is_that_of_all_cones():
    shape = make("tree", n_vertices=2000)
    truth, points = shape.truth, shape.mesh.vertices
    tubes = Tubes(truth.edges, truth.nodes, truth.radii)
    feet = feet_on_tubes(tubes, points, nearest_balls_by_power(tubes, points))
    everywhere = feet_on_tubes(tubes, points, np.tile(np.arange(len(truth.nodes)), (len(points), 1)))
    # on the surface of the union of the cones, the nearest cone is at a distance of nearly nothing
    assert np.abs(everywhere.distances).max() < 0.05
    assert np.mean(np.abs(feet.distances - everywhere.distances) > 1e-12) < 0.001
    middle = feet.normals * (feet.radii + feet.distances)[:, None]
    i, j = truth.edges[feet.edges].T
    foot = (1 - feet.shares)[:, None] * truth.nodes[i] + feet.shares[:, None] * truth.nodes[j]
    assert foot + middle == pytest.approx(points, abs=1e-12)


def test_the_balls_of_least_power_are_those_of_all_balls_large_and_small():
    """A soma is 50 times as thick as its neurite: both are found, though a search tree of their own holds the large."""
    random = np.random.default_rng(0)
    centers, radii = random.uniform(-1, 1, (60, 3)), np.append(np.full(58, 0.01), [0.5, 0.3])
    tubes = Tubes(np.array([np.arange(59), np.arange(1, 60)]).T, centers, radii)
    points = random.uniform(-1, 1, (500, 3))
    powers = ((points[:, None] - centers) ** 2).sum(axis=2) - radii**2
    found = np.take_along_axis(powers, nearest_balls_by_power(tubes, points), axis=1)
    assert found == pytest.approx(np.sort(powers, axis=1)[:, : found.shape[1]], abs=1e-12)


def test_balls_of_one_radius_have_no_heights_whatever_the_radius():
    """The square of a number is rounded differently in an array, for one radius in a thousand."""
    centers = np.array([[0.0, 0, 0], [0, 0, 1]])
    for radius in np.random.default_rng(0).uniform(0.001, 1, 4000):
        tubes = Tubes(np.array([[0, 1]]), centers, np.full(2, radius))
        assert nearest_balls_by_power(tubes, centers[1:]).tolist() == [[1, 0]]


def test_a_ball_inside_the_next_has_feet_on_the_other_and_overflows_nowhere():
    tubes = Tubes(np.array([[0, 1]]), np.array([[0.0, 0, 0], [0, 0, 1e-200]]), np.array([1.0, 0.5]))
    feet = feet_on_tubes(tubes, np.array([[2.0, 0, 0]]), np.array([[0]]))
    assert (feet.shares[0], feet.radii[0], feet.distances[0]) == (0, 1, 1)
