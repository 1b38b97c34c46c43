"""Closest points, on shapes whose answers are closed forms."""

import itertools

import numpy as np
import pytest

from lbskel.geometry.bvh import build_aabb_tree

ONE = np.array([[0, 1, 2]])
TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]])


def closest(kernel, V, F, points):
    tree = build_aabb_tree(V, F)
    return kernel.nearest_points(tree.corners, tree.bounds, np.array(points, dtype=np.float64))


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((1, 1, 5), (1, 1, 0)),  # above the inside
        ((1, 1, -5), (1, 1, 0)),
        ((2, -7, 1), (2, 0, 0)),  # beyond an edge
        ((-2, 1, 1), (0, 1, 0)),
        ((2 + 3, 1.5 + 4, 2), (2, 1.5, 0)),  # beyond the longest edge, along its normal (3, 4)
        ((-1, -2, 3), (0, 0, 0)),  # beyond a corner
        ((9, -1, 0), (4, 0, 0)),
        ((-1, 9, 2), (0, 3, 0)),
        ((1, 1, 0), (1, 1, 0)),  # on the triangle
    ],
)
def test_the_closest_point_of_a_triangle(kernel, point, expected):
    for corners in itertools.permutations(range(3)):
        distance, nearest, _ = closest(kernel, TRIANGLE[list(corners)], ONE, [point])
        assert nearest[0] == pytest.approx(expected, abs=1e-14)
        assert distance[0] == pytest.approx(np.linalg.norm(np.subtract(point, expected)), abs=1e-14)


@pytest.mark.parametrize("ends", [((0, 0, 0), (2, 0, 0)), ((1, 0, 0), (1, 0, 0))])
def test_the_closest_point_of_a_triangle_without_area(kernel, ends):
    V = np.array([ends[0], ends[1], np.mean(ends, axis=0)], dtype=np.float64)
    distance, nearest, _ = closest(kernel, V, ONE, [[1, 3, 4], [-2, 0, 0]])
    assert nearest[:, 0].tolist() == [1, ends[0][0]]
    assert distance.tolist() == [5, ends[0][0] + 2]


def test_the_closest_points_of_a_square_are_the_points_clamped(kernel, square):
    points = np.random.default_rng(0).normal(size=(300, 3)) + [0.5, 0.5, 0]
    points[7] = points[6]  # the bound of the query before is then the distance itself
    distance, nearest, _ = closest(kernel, *square, points)
    expected = np.clip(points, 0, [1, 1, 0])
    assert nearest == pytest.approx(expected, abs=1e-14)
    assert distance == pytest.approx(np.linalg.norm(points - expected, axis=1), rel=1e-14)


def test_the_closest_point_of_the_query_before_is_a_bound_that_may_be_zero(kernel, square):
    """A point above the square, and then its closest point."""
    distance, nearest, _ = closest(kernel, *square, [[0.3, 0.6, 1], [0.3, 0.6, 0], [0.3, 0.6, 0], [0.3, 0.6, -2]])
    assert distance.tolist() == [1, 0, 0, 2]
    assert np.array_equal(nearest, [[0.3, 0.6, 0]] * 4)


def test_points_that_are_not_finite_do_not_disturb_others(kernel, limbs):
    points = np.tile([0.1, 0.2, 0.3], (6, 1))
    points[[1, 3, 4], 0] = np.nan, np.inf, np.inf
    with np.errstate(invalid="ignore"):
        distance, nearest, _ = closest(kernel, limbs.vertices, limbs.faces, points)
    assert np.isfinite(distance).tolist() == [True, False, True, False, False, True]
    assert np.array_equal(nearest[0], nearest[2])
    assert np.array_equal(nearest[0], nearest[5])


def test_compiled_or_not_is_the_same(assert_same, limbs):
    points = np.random.default_rng(0).normal(size=(40, 3))
    assert_same(lambda kernel: closest(kernel, limbs.vertices, limbs.faces, points))
