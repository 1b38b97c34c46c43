"""The camera, the depth buffer and the shading that pictures are made of."""

from __future__ import annotations

import numpy as np
import pytest

from lbskel import Mesh, PointCloud, Skeleton
from lbskel.visualization import camera, shading
from lbskel.visualization import rasterizer as raster


def box(sides, center=(0, 0, 0)):
    """A closed box of those side lengths around a center."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Mesh(corners * sides + center, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])


def sphere(n=40):
    """A unit sphere of n rows and 2 n columns, closed at the poles by repeated points."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)], axis=-1)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n - 1), np.arange(2 * n - 1), indexing="ij"))
    a = i * 2 * n + j
    quads = np.stack([a, a + 1, a + 2 * n + 1, a + 2 * n], axis=1)
    return points.reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def covered_by_hand(triangle, size):
    """The pixels whose center lies strictly inside, by three cross products."""
    x, y = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    sides = [
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)
    ]
    return np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)


def test_thinnest_axis_looks_at_the_viewer_and_y_is_up():
    view = camera.principal_view(box([3, 2, 1]))
    np.testing.assert_allclose(view.axes, np.eye(3), atol=1e-12)  # an exact answer, less rounding


def test_view_is_right_handed_and_turns_with_the_shape():
    angle = 0.6
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    shape = box([3, 2, 0.5])
    view = camera.principal_view(Mesh(shape.vertices @ turn.T, shape.faces))
    assert np.linalg.det(view.axes) == pytest.approx(1)
    # The preference for the caller's axes, 0.002 of the variance, turns the view by less than that.
    np.testing.assert_allclose(np.abs(view.axes @ turn[:, 2]), [0, 0, 1], atol=2e-3)


def test_view_does_not_depend_on_how_the_surface_is_cut():
    shape = box([3, 2, 1])
    V, F = shape.vertices, shape.faces
    middle = V[F[:4]].mean(axis=1)  # four faces cut into three each: their weight must stay what it was
    cut = [[a, b, 8 + i] for i, face in enumerate(F[:4]) for a, b in zip(face, np.roll(face, -1), strict=True)]
    refined = Mesh(np.concatenate([V, middle]), np.concatenate([cut, F[4:]]))
    expected = camera.principal_view(shape)
    np.testing.assert_allclose(camera.principal_view(refined).axes, expected.axes, atol=1e-12)  # rounding


def test_a_shape_stands_on_the_axis_on_which_it_does_not_fall_over():
    # Seen along x: a pole on a plate, longer in z, with a spike on which it would have to stand if y were up.
    parts = [box([0.1, 0.1, 2]), box([0.1, 0.7, 0.1], [0, -0.05, -0.95]), box([0.1, 0.8, 0.1], [0, -0.4, 0.95])]
    gallows = Mesh(
        np.concatenate([p.vertices for p in parts]), np.concatenate([parts[0].faces + 8 * i for i in range(3)])
    )
    # The direction of view is x but for what the numbers of PCA round to, so up is z exactly.
    np.testing.assert_allclose(camera.principal_view(gallows).axes[1], [0, 0, 1], atol=1e-12)


def test_view_of_point_clouds_and_skeletons():
    points = box([3, 2, 1]).vertices
    edges = [[i, j] for i in range(8) for j in range(i + 1, 8) if i ^ j in (1, 2, 4)]
    for shape in (PointCloud(points), Skeleton(points, edges, np.ones(8))):
        np.testing.assert_allclose(camera.principal_view(shape).axes, np.eye(3), atol=1e-12)  # rounding


@pytest.mark.parametrize("seed", range(20))
def test_spans_cover_the_pixels_whose_centers_are_inside(seed):
    triangle = np.random.default_rng(seed).uniform(0, 40, (3, 3))
    item, depth = raster.nearest_triangles(triangle[None], 40, 40)
    inside = covered_by_hand(triangle[:, :2], 40)
    assert inside.sum() > 10
    np.testing.assert_array_equal(item >= 0, inside)
    y, x = np.nonzero(inside)
    weights = np.linalg.solve(
        np.concatenate([triangle[:, :2].T, np.ones((1, 3))]), np.stack([x + 0.5, y + 0.5, np.ones(len(x))])
    )
    # Depth is kept in 2^30 levels and returned in single precision, 6e-8 of 40.
    np.testing.assert_allclose(depth[inside], triangle[:, 2] @ weights, atol=1e-5)


def test_triangles_that_share_edges_neither_overlap_nor_leave_gaps():
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.arange(0.0, 65, 8), np.arange(0.0, 65, 8)), axis=-1)
    grid[1:-1, 1:-1] += rng.uniform(-2, 2, grid[1:-1, 1:-1].shape)
    a = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + 10], 1), np.stack([a, a + 10, a + 9], 1)])
    points = np.concatenate([grid.reshape(-1, 2), np.zeros((81, 1))], axis=1)
    masks = [raster.nearest_triangles(points[face][None], 64, 64)[0] == 0 for face in faces]
    np.testing.assert_array_equal(np.sum(masks, axis=0), 1)


def test_the_nearer_of_two_crossing_triangles_is_seen_at_each_pixel():
    left_near = np.array([[0, 0, 10], [40, 0, -10], [0, 80, 10]], dtype=float)
    right_near = left_near * [1, 1, -1]
    item, _ = raster.nearest_triangles(np.stack([left_near, right_near]), 40, 40)
    assert (item[0, :19] == 0).all()
    assert (item[0, 21:38] == 1).all()


def test_many_rows_are_cut_in_parts_with_the_same_result(monkeypatch):
    points, faces = sphere()
    triangles = points[faces] * 50 + 60
    item, depth = raster.nearest_triangles(triangles, 120, 120)
    monkeypatch.setattr(raster, "ROWS_AT_A_TIME", 500)
    again = raster.nearest_triangles(triangles, 120, 120)
    np.testing.assert_array_equal(again[0], item)
    np.testing.assert_array_equal(again[1], depth)


def test_triangle_without_area_is_drawn_as_a_line():
    line = np.array([[[5, 5.2, 0], [35, 5.2, 0], [20, 5.2, 0]]])
    item, _ = raster.nearest_triangles(line, 40, 20)
    assert (item[:, 6:34] == 0).any(axis=0).all()
    assert not (item[8:] == 0).any()


def test_what_lies_outside_the_image_is_left_out():
    triangle = np.array([[[-50, -50, 0], [150, -50, 0], [-50, 150, 0]]], dtype=float)
    assert (raster.nearest_triangles(triangle, 20, 20)[0] == 0).all()
    assert (raster.nearest_triangles(triangle + 500, 20, 20)[0] == -1).all()


def test_sphere_is_round_smooth_and_lit_from_the_upper_left():
    points, faces = sphere()
    radius = 60
    image = shading.shade_mesh(points * radius + [75, 75, 0], faces, 150, 150)
    # 40 rows of flat faces cover 0.2 % less than the disc; the line around it adds up to half a pixel, 1.7 %.
    assert image[..., 3].sum() == pytest.approx(np.pi * radius**2, rel=0.02)
    assert len(np.unique(image[..., 3])) > 2  # partly covered pixels
    brightness = image[..., :3].mean(axis=2)
    assert brightness[75 - 30, 75 - 30] > brightness[75 + 30, 75 + 30] + 0.1
    inner = brightness[60:90, 60:90]
    # Normals are interpolated: no pixel differs from the next by a tenth of what a face of 4.5 degrees would.
    assert np.abs(np.diff(inner, axis=1)).max() < 0.01


def test_reversed_faces_look_the_same():
    points, faces = sphere(12)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]  # no face is seen exactly edge-on
    points = points @ turn * 30 + [40.3, 40.2, 0]
    ours, theirs = (shading.shade_mesh(points, F, 80, 80) for F in (faces, faces[:, ::-1]))
    # The corners come in another order, so the interpolation rounds differently in single precision.
    np.testing.assert_allclose(ours, theirs, atol=1e-4)


def test_crease_is_not_smoothed():
    roof = np.array([[0, 0, 0], [30, 0, 30], [60, 0, 0], [0, 60, 0], [30, 60, 30], [60, 60, 0]], dtype=float)
    faces = np.array([[0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2]])
    image = shading.shade_mesh(roof, faces, 60, 60)
    left, right = image[20:40, 5:25, :3], image[20:40, 35:55, :3]
    assert np.ptp(left, axis=(0, 1)).max() < 1e-5  # one normal, so one color, in single precision
    assert (left.mean(axis=(0, 1)) - right.mean(axis=(0, 1))).min() > 0.05


def test_points_are_balls_and_far_ones_are_paler():
    points = np.array([[20, 20, 0], [60, 20, -50]], dtype=float)
    image = shading.shade_points(points, 6, 80, 40)
    near, far = image[20, 20, :3], image[20, 60, :3]
    assert image[..., 3].sum() == pytest.approx(2 * np.pi * 6**2, rel=0.1)  # discs of samples half a pixel apart
    assert far.min() > near.max()
