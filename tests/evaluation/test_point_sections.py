"""Sections of a cloud: what is among the points, and how far it is from their middle."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel._kernels.point_tree import PointTree
from lbskel.evaluation.point_sections import inside_fraction, section_errors, spread
from lbskel.shapes import cylinder

POINTS = cylinder(0.5, 8.0, 48, 97).vertices  # an open pipe along z, from -4 to 4
TREE = PointTree(POINTS)


def _line(start, end, n):
    nodes = np.linspace(start, end, n)
    edges = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    return Skeleton(nodes, edges, TREE.nearest(nodes)[0][:, 0])


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.2])
def test_the_error_is_the_distance_from_the_middle_in_radii(shift):
    is_among, errors = section_errors(_line([shift, 0, -3], [shift, 0, 3], 31), POINTS, TREE)
    assert is_among.all()
    assert errors[1:-1] == pytest.approx(2 * shift, abs=0.02)  # the outline has 24 corners


def test_a_line_beside_the_pipe_is_not_among_its_points():
    is_among, errors = section_errors(_line([1.5, 0, -3], [1.5, 0, 3], 31), POINTS, TREE)
    assert not is_among.any()
    assert np.isnan(errors).all()


def test_without_a_section_the_bounding_box_decides():
    is_among, _ = section_errors(Skeleton([[0, 0, 0], [9, 0, 0]], [], np.ones(2)), POINTS, TREE)
    assert is_among.tolist() == [True, False]


@pytest.mark.parametrize("n", [2, 3, 100])
def test_the_length_inside_does_not_depend_on_the_nodes(n):
    """A line from the middle of the pipe through its open end, of which half is inside."""
    assert inside_fraction(_line([0, 0, 0], [0, 0, 8], n), POINTS, TREE) == pytest.approx(0.5, abs=0.07)


def test_a_skeleton_without_length_has_no_fraction():
    assert inside_fraction(Skeleton([[0, 0, 0]], [], np.ones(1)), POINTS, TREE) is None


def test_points_are_spread_along_the_direction_of_their_extent():
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    chosen = spread(POINTS @ turn.T, 97)
    heights = np.sort(POINTS[chosen, 2])
    assert len(chosen) == 97
    assert np.diff(heights).max() < 0.2  # twice the distance between the rings
    assert (spread(POINTS, len(POINTS)) == np.arange(len(POINTS))).all()
