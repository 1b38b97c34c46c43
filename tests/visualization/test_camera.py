"""The direction of view: principal axes, the up direction, and projection."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import box_mesh

from lbskel import Mesh, MeshError, PointCloud, Skeleton
from lbskel.shapes import flat_grid
from lbskel.visualization import camera


def test_thinnest_axis_looks_at_the_viewer_and_y_is_up():
    view = camera.principal_view(box_mesh([3, 2, 1]))
    np.testing.assert_allclose(view.axes, np.eye(3), atol=1e-12)  # rounding


def test_view_is_right_handed_and_rotates_with_the_shape():
    angle = 0.6
    rotation = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    shape = box_mesh([3, 2, 0.5])
    view = camera.principal_view(Mesh(shape.vertices @ rotation.T, shape.faces))
    assert np.linalg.det(view.axes) == pytest.approx(1)
    # The bias towards the caller's axes, 0.002 of the variance, rotates the view by less than that.
    np.testing.assert_allclose(np.abs(view.axes @ rotation[:, 2]), [0, 0, 1], atol=2e-3)


def test_view_does_not_depend_on_the_triangulation():
    shape = box_mesh([3, 2, 1])
    V, F = shape.vertices, shape.faces
    middle = V[F[:4]].mean(axis=1)  # four faces are divided into three each; the moment must not change
    divided = [[a, b, 8 + i] for i, face in enumerate(F[:4]) for a, b in zip(face, np.roll(face, -1), strict=True)]
    refined = Mesh(np.concatenate([V, middle]), np.concatenate([divided, F[4:]]))
    expected = camera.principal_view(shape)
    np.testing.assert_allclose(camera.principal_view(refined).axes, expected.axes, atol=1e-12)  # rounding


def test_up_is_the_axis_on_which_the_shape_is_stable():
    # Seen along x: a pole on a plate, longer in z, with a spike that it would stand on if y were up.
    parts = [
        box_mesh([0.1, 0.1, 2]),
        box_mesh([0.1, 0.7, 0.1], [0, -0.05, -0.95]),
        box_mesh([0.1, 0.8, 0.1], [0, -0.4, 0.95]),
    ]
    gallows = Mesh(
        np.concatenate([p.vertices for p in parts]), np.concatenate([parts[0].faces + 8 * i for i in range(3)])
    )
    # The direction of view is x up to rounding in the eigenvectors, so up is z.
    np.testing.assert_allclose(camera.principal_view(gallows).axes[1], [0, 0, 1], atol=1e-12)


def test_view_of_point_clouds_and_skeletons():
    points = box_mesh([3, 2, 1]).vertices
    edges = [[i, j] for i in range(8) for j in range(i + 1, 8) if i ^ j in (1, 2, 4)]
    for shape in (PointCloud(points), Skeleton(points, edges, np.ones(8))):
        np.testing.assert_allclose(camera.principal_view(shape).axes, np.eye(3), atol=1e-12)  # rounding


def test_up_is_the_second_principal_axis_if_neither_y_nor_z_is_in_the_image_plane():
    """Seen along the diagonal (0, 1, 1), y and z are both 45 degrees out of the image plane."""
    s = np.sqrt(0.5)
    turn = np.array([[1, 0, 0], [0, s, s], [0, -s, s]])
    shape = box_mesh([3, 2, 0.5])
    axes = camera.principal_view(Mesh(shape.vertices @ turn.T, shape.faces)).axes
    # right: the longest axis, x; up: the second, its larger component positive
    np.testing.assert_allclose(np.abs(axes[0]), [1, 0, 0], atol=2e-3)
    np.testing.assert_allclose(np.abs(axes[1]), [0, s, s], atol=2e-3)
    assert axes[1][1] > 0


def test_projection_measures_from_the_center_along_right_up_and_viewer():
    view = camera.View(np.array([1.0, 2.0, 3.0]), np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    np.testing.assert_allclose(view.project(np.array([[2.0, 4.0, 6.0]])), [[2, 3, 1]])


def test_the_viewer_is_on_the_positive_side():
    shape = box_mesh([3, 2, 0.5])
    for angle in (0.6, -0.6, np.pi - 0.6, np.pi + 0.6):
        thin = np.array([np.sin(angle), 0, np.cos(angle)])
        turn = np.stack([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], thin], axis=1)
        to_viewer = camera.principal_view(Mesh(shape.vertices @ turn.T, shape.faces)).axes[2]
        np.testing.assert_allclose(to_viewer, thin * np.sign(thin[2]), atol=2e-3)


def test_long_edges_of_a_skeleton_count_more_than_many_nodes():
    """The second moment of the edges: a finely sampled short bar does not outweigh two long ones."""
    x = np.linspace(-0.5, 0.5, 200)
    nodes = np.concatenate([np.stack([0 * x, 0 * x, x], axis=1), [[-2, 0, 0], [2, 0, 0], [0, -2, 0], [0, 2, 0]]])
    edges = np.concatenate([np.stack([np.arange(199), np.arange(1, 200)], axis=1), [[200, 201], [202, 203]]])
    np.testing.assert_allclose(
        camera.principal_view(Skeleton(nodes, edges, np.ones(204))).axes[2], [0, 0, 1], atol=1e-9
    )


def test_an_empty_skeleton_is_seen_along_z():
    view = camera.principal_view(Skeleton(np.empty((0, 3)), np.empty((0, 2)), []))
    np.testing.assert_array_equal(view.axes, np.eye(3))


def test_a_small_fine_part_does_not_outweigh_a_large_coarse_one():
    """A plate of two triangles in the plane z = 0, and across it a unit square of 722 triangles in the plane x = 0."""
    square = flat_grid(20, 20)
    plate = np.array([[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]])
    V = np.concatenate([plate, square.vertices[:, [2, 0, 1]] - [0, 0.5, 0.5]])
    view = camera.principal_view(Mesh(V, np.concatenate([[[0, 1, 2], [0, 2, 3]], square.faces + 4])))
    np.testing.assert_allclose(view.axes[2], [0, 0, 1], atol=1e-9)


def test_the_moment_of_an_edge_is_that_of_its_line():
    """A bar of length 2 along x has the moment 2^3 / 12, less than that of 8 units of length at z = 0.35 and -0.35."""
    d = np.sqrt(1 / 8)
    nodes = [[-1, 0, 0], [1, 0, 0], [0, -2, d], [0, 2, d], [0, -2, -d], [0, 2, -d]]
    view = camera.principal_view(Skeleton(nodes, [[0, 1], [2, 3], [4, 5]], np.ones(6)))
    np.testing.assert_allclose(view.axes[2], [1, 0, 0], atol=1e-9)


def test_coordinates_that_cannot_be_shown_are_refused():
    with pytest.raises(MeshError, match="cannot be shown"):
        camera.principal_view(Mesh(np.eye(3) * 1e300, [[0, 1, 2]]))
