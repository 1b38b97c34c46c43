"""Level segments against the level sets of a plane, and areas above them."""

import numpy as np
import pytest

from lbskel.geometry.level_segments import level_segments
from lbskel.geometry.normals import triangle_normals, vector_lengths
from lbskel.shapes import sphere


@pytest.mark.parametrize("level", [-0.33, 0.21, 0.87])
def test_segments_lie_in_the_plane_and_bound_the_cap_of_a_sphere(level):
    ball = sphere(4)
    heights = ball.vertices[:, 2] - level
    is_above = heights[ball.faces] > 0
    whole = is_above.all(axis=1)
    is_cut = is_above.any(axis=1) & ~whole
    corners = ball.faces[is_cut].T
    segments = level_segments(ball.vertices, corners, heights[corners])
    for points in (segments.starts, segments.stops):
        assert points[:, 2] == pytest.approx(level, abs=1e-12)
    length = vector_lengths(segments.stops - segments.starts).sum()
    assert length == pytest.approx(2 * np.pi * np.sqrt(1 - level**2), rel=0.01)  # of a polygon in the circle
    area = ball.face_areas[whole].sum() + (segments.shares_above * ball.face_areas[is_cut]).sum()
    assert area == pytest.approx(2 * np.pi * (1 - level), rel=0.01)


def test_shares_are_those_of_the_triangle_or_the_quadrilateral_above():
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]])
    rotations = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1]]).T
    for heights, shares in (([1.0, -3.0, -1.0], 1 / 8), ([-1.0, 3.0, 1.0], 7 / 8), ([0.0, 3.0, 1.0], 1.0)):
        segments = level_segments(vertices, rotations, np.array(heights)[rotations])
        assert segments.shares_above == pytest.approx([shares] * 3)
    segments = level_segments(vertices, rotations, np.array([1.0, -3.0, -1.0])[rotations])
    lengths = vector_lengths(segments.stops - segments.starts)
    assert lengths == pytest.approx([np.hypot(1, 1.5)] * 3)
    small = triangle_normals(vertices[:1], segments.starts[:1], segments.stops[:1])
    assert vector_lengths(small)[0] / 2 == pytest.approx(6 / 8)
