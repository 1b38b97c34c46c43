"""The depth buffer: coverage, visibility and depth of triangles and balls."""

from __future__ import annotations

import numpy as np
import pytest

from lbskel.shapes import sphere
from lbskel.visualization import rasterizer


def pixels_inside(triangle, size):
    """Mask of the pixels whose center is strictly inside, by three cross products."""
    x, y = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    sides = [
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)
    ]
    return np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)


@pytest.mark.parametrize("seed", range(20))
def test_spans_cover_the_pixels_whose_centers_are_inside(seed):
    triangle = np.random.default_rng(seed).uniform(0, 40, (3, 3))
    item, depth = rasterizer.rasterize_triangles(triangle[None], 40, 40)
    inside = pixels_inside(triangle[:, :2], 40)
    assert inside.sum() > 10
    np.testing.assert_array_equal(item >= 0, inside)
    y, x = np.nonzero(inside)
    weights = np.linalg.solve(
        np.concatenate([triangle[:, :2].T, np.ones((1, 3))]), np.stack([x + 0.5, y + 0.5, np.ones(len(x))])
    )
    # Depth has 2^30 levels and is returned in single precision, 6e-8 of 40.
    np.testing.assert_allclose(depth[inside], triangle[:, 2] @ weights, atol=1e-5)


def test_triangles_that_share_edges_neither_overlap_nor_leave_gaps():
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.arange(0.0, 65, 8), np.arange(0.0, 65, 8)), axis=-1)
    grid[1:-1, 1:-1] += rng.uniform(-2, 2, grid[1:-1, 1:-1].shape)
    a = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + 10], 1), np.stack([a, a + 10, a + 9], 1)])
    points = np.concatenate([grid.reshape(-1, 2), np.zeros((81, 1))], axis=1)
    masks = [rasterizer.rasterize_triangles(points[face][None], 64, 64)[0] == 0 for face in faces]
    np.testing.assert_array_equal(np.sum(masks, axis=0), 1)


def test_the_nearer_of_two_crossing_triangles_is_seen_at_each_pixel():
    left_near = np.array([[0, 0, 10], [40, 0, -10], [0, 80, 10]], dtype=float)
    right_near = left_near * [1, 1, -1]
    item, _ = rasterizer.rasterize_triangles(np.stack([left_near, right_near]), 40, 40)
    assert (item[0, :19] == 0).all()
    assert (item[0, 21:38] == 1).all()


def test_chunks_do_not_change_the_result(monkeypatch):
    mesh = sphere(4)
    triangles = mesh.vertices[mesh.faces] * 50 + 60
    item, depth = rasterizer.rasterize_triangles(triangles, 120, 120)
    monkeypatch.setattr(rasterizer, "MAX_ROWS_PER_CHUNK", 500)
    again = rasterizer.rasterize_triangles(triangles, 120, 120)
    np.testing.assert_array_equal(again[0], item)
    np.testing.assert_array_equal(again[1], depth)


def test_a_triangle_without_area_is_drawn_as_a_line():
    line = np.array([[[5, 5.2, 0], [35, 5.2, 0], [20, 5.2, 0]]])
    item, _ = rasterizer.rasterize_triangles(line, 40, 20)
    assert (item[:, 6:34] == 0).any(axis=0).all()
    assert not (item[8:] == 0).any()


def test_fragments_outside_the_image_are_dropped():
    triangle = np.array([[[-50, -50, 0], [150, -50, 0], [-50, 150, 0]]], dtype=float)
    assert (rasterizer.rasterize_triangles(triangle, 20, 20)[0] == 0).all()
    assert (rasterizer.rasterize_triangles(triangle + 500, 20, 20)[0] == -1).all()


def test_thin_triangles_have_the_depth_along_their_longest_side():
    sliver = np.array([[[5, 10, 0], [35, 10, 30], [20, 10.2, 15]]], dtype=float)
    item, depth = rasterizer.rasterize_triangles(sliver, 40, 20)
    rows, columns = np.nonzero(item == 0)
    assert columns.min() <= 5
    assert columns.max() >= 34
    np.testing.assert_allclose(depth[rows, columns], columns + 0.5 - 5, atol=1.6)  # a line of two pixels' width


def test_background_has_no_item_and_infinite_distance():
    item, depth = rasterizer.rasterize_triangles(np.array([[[2, 2, 5], [8, 2, 5], [2, 8, 5]]], dtype=float), 20, 20)
    assert ((item == -1) == (depth == -np.inf)).all()
    np.testing.assert_allclose(depth[item == 0], 5)


def test_balls_hide_each_other_by_the_depth_of_their_surfaces():
    centers = np.array([[20.5, 20.5, 0], [26.5, 20.5, 1]])
    item, depth = rasterizer.rasterize_balls(centers, 8, 50, 40)
    assert item[20, 20] == 0  # depth 8 of the first ball, 1 + sqrt(28) of the second
    assert item[20, 26] == 1
    np.testing.assert_allclose([depth[20, 14], depth[20, 26]], [np.sqrt(64 - 36), 9], rtol=1e-6)
    lens = 2 * 64 * np.arccos(6 / 16) - 6 / 2 * np.sqrt(256 - 36)  # overlap of two discs of radius 8 at distance 6
    assert (item >= 0).sum() == pytest.approx(2 * np.pi * 64 - lens, rel=0.05)


def test_balls_outside_the_image_are_dropped():
    outside = np.array([[-3.5, 10, 0], [23.5, 10, 0], [10, -3.5, 0], [10, 23.5, 0]])
    item, _ = rasterizer.rasterize_balls(outside, 2, 20, 20)
    assert (item == -1).all()
