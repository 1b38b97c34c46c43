"""Growth of limbs that stand out of the skeleton's balls; what it shares with extrema is in test_missing_branches."""

import numpy as np
import pytest

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.limb_growth import _centered, _not_covered
from lbskel.shapes import sphere


def test_of_two_limbs_whose_ends_lie_on_one_axis_the_first_gets_a_branch():
    ends = np.array([[0.0, 0, 5], [0.3, 0, 3], [9, 0, 0]])
    axes = [np.array([[0.0, 0, z] for z in range(1, 5)]), np.array([[0.1, 0, 2.0]]), np.array([[8.0, 0, 0]])]
    assert _not_covered(ends, axes, [np.full(len(axis), 0.5) for axis in axes]) == [0, 2]
    assert _not_covered(ends, axes, [np.full(len(axis), 0.2) for axis in axes]) == [0, 1, 2]


def test_points_of_an_axis_inside_the_body_are_dropped():
    ball = sphere(3)
    drawn = ball.with_vertices(ball.vertices * np.where(ball.vertices[:, 2:] > 0.9, [1, 1, 4], 1))
    axis = np.array([[0.05, 0, z] for z in (0.0, 0.3, 1.5, 2.5, 3.5)])
    [points], [widths] = _centered([axis], np.array([0.4]), Surface(drawn))
    assert points == pytest.approx(np.array([[0, 0, z] for z in (1.5, 2.5, 3.5)]), abs=0.02)  # the triangles are coarse
    assert (widths < 0.5).all()
