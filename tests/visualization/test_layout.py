"""The layout of pictures: sizes, positions of panels, and the map from projected coordinates to pixels."""

from __future__ import annotations

import numpy as np
import pytest

from lbskel import FormatError
from lbskel.visualization.layout import FONT_SIZE_RANGE, LONGER_SIDE, MAX_ASPECT_RATIO, Frame, Layout, arrange


def test_a_frame_maps_its_center_to_the_middle_of_the_drawing():
    frame = Frame(200, 100, 10.0, np.array([3.0, -1.0]))
    points = np.array([[3.0, -1.0, 0.0], [4.0, 1.0, 2.0]])
    np.testing.assert_allclose(frame.pixels(points), [[100, 50, 0], [110, 70, 20]])
    np.testing.assert_allclose(frame.image_coordinates(points), [[100, 50, 0], [110, 30, 20]])


@pytest.mark.parametrize("extent", [[4.0, 1.0], [1.0, 4.0], [2.0, 2.0]])
def test_a_frame_fits_the_shape_into_the_drawing_with_a_margin(extent):
    layout = arrange(np.array(extent), [(0, 0)], (400, 300))
    low = np.array([5.0, -7.0])
    frame = layout.frame(low, low + extent)
    corners = frame.pixels(np.array([[*low, 0.0], [*(low + extent), 0.0]]))[:, :2]
    margin = layout.font_size
    assert (corners >= margin - 1e-9).all()
    assert (corners <= np.array([400, 300]) - margin + 1e-9).all()
    assert np.isclose(corners[0], margin).any()  # one side is filled
    np.testing.assert_allclose(corners.mean(axis=0), [200, 150])


def test_a_point_has_scale_one():
    frame = arrange(np.zeros(2), [(0, 0)], (400, 300)).frame(np.ones(2), np.ones(2))
    assert frame.scale == 1.0
    np.testing.assert_allclose(frame.pixels(np.array([[1.0, 1.0, 0.0]])), [[200, 150, 0]])


def test_panels_are_numbered_row_by_row_and_do_not_overlap():
    layout = Layout(600, 500, 3, 10.0, (20, 30), (40, 50))
    assert layout.drawing == (200, (500 - 20 - 30 - 40 - 50) // 2)
    assert [layout.corner(i) for i in range(3)] == [(0, 300), (200, 300), (400, 300)]  # 500 - title 20 - height 180
    assert layout.corner(3) == (0, 50)  # above its text of 50 pixels


def test_default_sizes_follow_the_shape():
    single = arrange(np.array([3.0, 2.0]), [(0, 0)], None)
    assert (single.width, single.height) == (LONGER_SIDE[True], LONGER_SIDE[True] * 2 // 3)
    pair = arrange(np.array([3.0, 2.0]), [(0, 0)] * 2, None)
    assert pair.drawing[0] == LONGER_SIDE[False]
    long = arrange(np.array([100.0, 1.0]), [(0, 0)], None)
    assert long.drawing == (LONGER_SIDE[True], LONGER_SIDE[True] / MAX_ASPECT_RATIO)


@pytest.mark.parametrize(("extent", "size", "columns"), [([4, 1], None, 2), ([1, 4], None, 4), ([1, 1], (900, 100), 4)])
def test_the_number_of_columns_gives_the_aspect_ratio_wanted(extent, size, columns):
    assert arrange(np.array(extent, dtype=float), [(0, 0)] * 4, size).columns == columns


def test_each_row_reserves_the_height_of_its_longest_text():
    layout = arrange(np.ones(2), [(1, 2), (3, 0), (0, 4), (0, 1)], (400, 400))
    assert layout.columns == 2
    assert layout.above == (round(3 * layout.font_size), 0)
    assert layout.below == (round(2 * layout.font_size), round(4 * layout.font_size))
    height = sum(layout.above) + sum(layout.below) + 2 * layout.drawing[1]
    assert 400 - 1 <= height <= 400


def test_the_font_size_is_bounded():
    low, high = FONT_SIZE_RANGE
    assert arrange(np.ones(2), [(0, 0)], (100, 100)).font_size == low
    assert arrange(np.ones(2), [(0, 0)], (5000, 5000)).font_size == high


def test_a_picture_too_small_for_its_panels_is_refused():
    with pytest.raises(FormatError, match="4 panels cannot fit into 30 x 30 pixels"):
        arrange(np.ones(2), [(0, 0)] * 4, (30, 30))
    with pytest.raises(FormatError, match="1 panel cannot fit into 200 x 40 pixels"):
        arrange(np.ones(2), [(2, 3)], (200, 40))  # the text leaves no height for the drawing
    with pytest.raises(FormatError, match="1 panel cannot fit into 100 x 0 pixels"):
        arrange(np.ones(2), [(0, 0)], (100, 0))
