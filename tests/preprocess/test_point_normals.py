"""Normals of points of closed surfaces, against those of the surface."""

import numpy as np
import pytest

from lbskel.geometry.normals import normalized
from lbskel.preprocess import point_normals
from lbskel.preprocess.point_neighborhoods import Neighborhoods
from lbskel.preprocess.point_normals import oriented
from lbskel.shapes import sphere, torus


def test_normals_of_a_sphere_point_outwards():
    points = sphere(4).vertices
    cloud = oriented(Neighborhoods(points + [3, 0, 0]))
    assert (cloud.normals * points).sum(axis=1).min() > 0.99
    assert cloud.areas.sum() == pytest.approx(4 * np.pi, rel=0.1)  # disks to the 16th neighbor, at steps of a grid
    assert cloud.spacings == pytest.approx(np.sqrt(cloud.areas))


def test_noise_turns_no_normal_around():
    mesh = torus(1.0, 0.3)
    axis = mesh.vertices * [1, 1, 0]
    outward = mesh.vertices - axis / np.linalg.norm(axis, axis=1, keepdims=True)
    noise = np.random.default_rng(3).normal(size=mesh.vertices.shape) * 0.02
    cloud = oriented(Neighborhoods(mesh.vertices + noise))
    cosines = (cloud.normals * outward).sum(axis=1) / 0.3
    assert cosines.min() > 0
    assert cosines.mean() > 0.95


def test_each_of_two_bodies_points_outwards():
    points = sphere(3).vertices
    cloud = oriented(Neighborhoods(np.concatenate([points, points + [0, 0, 9]])))
    assert (cloud.normals.reshape(2, -1, 3) * points).sum(axis=2).min() > 0.95


def test_a_part_that_is_inside_out_is_turned(monkeypatch):
    spindle = sphere(4).vertices * [1, 1, 6]
    outward = normalized(spindle / [1, 1, 36])
    with_signs = point_normals._with_signs

    def inside_out_above(points, normals, *rest):
        return with_signs(points, normals, *rest) * np.where(points[:, 2:] > 2, -1.0, 1.0)

    monkeypatch.setattr(point_normals, "_with_signs", inside_out_above)
    assert (oriented(Neighborhoods(spindle)).normals * outward).sum(axis=1).min() > 0.9
