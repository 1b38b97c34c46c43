"""Shading of surfaces and point clouds: light, smooth normals, creases, outlines and coverage."""

from __future__ import annotations

import numpy as np
import pytest

from lbskel.visualization import shading


def sphere(n=40):
    """A unit sphere of n rows and 2 n columns, closed at the poles by repeated points."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)], axis=-1)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n - 1), np.arange(2 * n - 1), indexing="ij"))
    a = i * 2 * n + j
    quads = np.stack([a, a + 1, a + 2 * n + 1, a + 2 * n], axis=1)
    return points.reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def test_sphere_is_round_smooth_and_lit_from_the_upper_left():
    points, faces = sphere()
    radius = 60
    image = shading.shade_mesh(points * radius + [75, 75, 0], faces, 150, 150)
    # 40 rows of flat faces cover 0.2 % less than the disc; the outline adds up to half a pixel, 1.7 %.
    assert image[..., 3].sum() == pytest.approx(np.pi * radius**2, rel=0.02)
    assert len(np.unique(image[..., 3])) > 2  # some pixels are partly covered
    brightness = image[..., :3].mean(axis=2)
    assert brightness[75 - 30, 75 - 30] > brightness[75 + 30, 75 + 30] + 0.1
    inner = brightness[60:90, 60:90]
    # Normals are interpolated: neighboring pixels differ by less than a tenth of what flat faces of 4.5 degrees would.
    assert np.abs(np.diff(inner, axis=1)).max() < 0.01


def test_reversed_faces_look_the_same():
    points, faces = sphere(12)
    rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]  # no face is seen exactly edge-on
    points = points @ rotation * 30 + [40.3, 40.2, 0]
    image, reversed_image = (shading.shade_mesh(points, F, 80, 80) for F in (faces, faces[:, ::-1]))
    # The corners are in another order, so the interpolation rounds differently in single precision.
    np.testing.assert_allclose(image, reversed_image, atol=1e-4)


def test_crease_is_not_smoothed():
    roof = np.array([[0, 0, 0], [30, 0, 30], [60, 0, 0], [0, 60, 0], [30, 60, 30], [60, 60, 0]], dtype=float)
    faces = np.array([[0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2]])
    image = shading.shade_mesh(roof, faces, 60, 60)
    left, right = image[20:40, 5:25, :3], image[20:40, 35:55, :3]
    assert np.ptp(left, axis=(0, 1)).max() < 1e-5  # one normal gives one color, in single precision
    assert (left.mean(axis=(0, 1)) - right.mean(axis=(0, 1))).min() > 0.05


def test_points_are_balls_and_far_ones_are_paler():
    points = np.array([[20, 20, 0], [60, 20, -50]], dtype=float)
    image = shading.shade_points(points, 6, 80, 40)
    near, far = image[20, 20, :3], image[20, 60, :3]
    assert image[..., 3].sum() == pytest.approx(2 * np.pi * 6**2, rel=0.1)  # discs sampled at half a pixel
    assert far.min() > near.max()


def test_a_face_towards_the_light_is_brighter_than_one_away_from_it():
    """Tilted planes: rows grow downwards, so depth that grows with the row faces up."""
    square = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], dtype=float)
    brightness = {}
    for name, slope in (("up", [0, 1]), ("down", [0, -1]), ("left", [1, 0]), ("right", [-1, 0])):
        points = np.column_stack([square, square @ slope])
        brightness[name] = shading.shade_mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), 40, 40)[20, 20, :3].mean()
    assert brightness["up"] > brightness["down"] + 0.1
    assert brightness["left"] > brightness["right"] + 0.1


def test_a_field_is_interpolated_linearly_over_a_triangle():
    triangle = np.array([[0, 0, 0], [60, 0, 0], [0, 60, 0]], dtype=float)
    field = np.array([0.0, 1.0, 0.0])

    def gray(values):
        return np.repeat(np.asarray(values, dtype=np.float32)[:, None], 3, axis=1)

    image = shading.shade_mesh(triangle, np.array([[0, 1, 2]]), 60, 60, field=field, colormap=gray)
    expected = (np.arange(10, 40) + 0.5) / 60  # one normal, so the brightness is one factor and one highlight
    slope, offset = np.polyfit(expected, image[8, 10:40, 0], 1)
    assert slope == pytest.approx(1.0, abs=0.3)
    np.testing.assert_allclose(image[8, 10:40, 0], offset + slope * expected, atol=1e-4)


def test_an_outline_is_drawn_behind_a_discontinuity_of_the_depth_but_not_on_a_slope():
    far = np.array([[0, 0, 0], [80, 0, 0], [80, 80, 0], [0, 80, 0]], dtype=float)
    near = np.array([[20, 20, 40], [60, 20, 40], [60, 60, 40], [20, 60, 40]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    image = shading.shade_mesh(np.concatenate([far, near]), faces, 80, 80)[..., :3].mean(axis=2)
    plain = image[40, 40]
    assert image[40, 19] < 0.8 * plain  # behind the edge of the near square
    np.testing.assert_allclose([image[40, 10], image[40, 21]], plain, atol=1e-4)  # one normal, one color
    slope = far * [1, 1, 0] + [0, 0, 1] * far[:, :1] * 0.5
    smooth = shading.shade_mesh(slope, faces[:2], 80, 80)[5:75, 5:75, :3]
    assert np.ptp(smooth, axis=(0, 1)).max() < 1e-4


def test_partly_covered_pixels_have_partial_opacity():
    rectangle = np.array([[10, 10, 0], [20.5, 10, 0], [20.5, 20, 0], [10, 20, 0]], dtype=float)
    alpha = shading.shade_mesh(rectangle, np.array([[0, 1, 2], [0, 2, 3]]), 40, 40)[..., 3]
    assert (alpha[10:20, 10:20] == 1).all()
    np.testing.assert_array_equal(alpha[10:20, 20], 0.5)
    assert alpha.sum() == pytest.approx(105)
