"""Mirrors: reflection in a plane, and the principal axes of a surface, whatever its triangles are."""

import numpy as np
import pytest
from helpers import box_mesh
from scipy.spatial.transform import Rotation

from lbskel.geometry.mirrors import Mirror, mirror_between, mirrors_at_centroid, principal_axes


def test_a_mirror_image_is_as_high_on_the_other_side():
    mirror = Mirror(np.array([1.0, 0, 0]), np.array([0.6, 0.8, 0]))
    points = np.random.default_rng(0).normal(size=(20, 3))
    images = mirror.mirrored(points)
    assert mirror.heights(images) == pytest.approx(-mirror.heights(points))
    assert np.cross(images - points, mirror.normal) == pytest.approx(np.zeros((20, 3)))
    assert mirror.mirrored(images) == pytest.approx(points)


def test_the_axes_of_a_box_do_not_depend_on_its_triangles():
    turn = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix()
    box = box_mesh([3, 2, 1])
    box = box.with_vertices(box.vertices @ turn.T + 7)  # its diagonals are not symmetric
    assert np.abs(principal_axes(box) @ turn) == pytest.approx(np.eye(3)[::-1], abs=1e-9)


def test_mirrors_pass_through_the_centroid_and_look_to_the_positive_side():
    box = box_mesh([3, 2, 1])
    first, second = mirrors_at_centroid(box, [[-1, 0, 0], [0.6, -0.8, 0]])
    assert first.normal.tolist() == [1, 0, 0]
    assert second.normal.tolist() == [-0.6, 0.8, 0]
    assert first.point == pytest.approx(box.centroid)


def test_the_mirror_between_points_and_their_images_is_found_whatever_has_no_weight():
    rng = np.random.default_rng(0)
    mirror = Mirror(np.array([1.0, 2, 3]), np.array([0.6, 0.0, 0.8]))
    points = rng.normal(size=(20, 3))
    images = mirror.mirrored(points)
    images[:5] += 1
    found = mirror_between(points, images, np.repeat([0.0, 1.0, 2.0], [5, 10, 5]))
    assert found.normal == pytest.approx(mirror.normal)
    assert found.heights(mirror.point[None]) == pytest.approx(0, abs=1e-12)


def test_the_axes_of_a_mesh_in_tiny_units_are_the_same():
    box = box_mesh([1, 2, 3])
    tiny = box.with_vertices(1e-90 * box.vertices)
    assert np.abs(principal_axes(tiny)) == pytest.approx(np.abs(principal_axes(box)), abs=1e-12)
