"""Stars in order: the same triangles as the vectorized ones, rings that follow each other."""

import numpy as np
import pytest

from lbskel import MeshError, PointCloud
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.local_delaunay import delaunay_stars
from lbskel.operators.star_rings import stars_in_order
from lbskel.shapes import make, sphere


def test_the_triangles_are_those_of_the_vectorized_stars():
    points = make("limbs", n_vertices=1500).mesh.vertices
    jitter = np.random.default_rng(0).normal(size=points.shape)  # of four points on a circle either diagonal is right
    points = points + 1e-6 * jitter
    cloud, n_neighbors = PointCloud(points), round(0.012 * len(points))
    found = {(row[0], *sorted(row[1:])) for row in stars_in_order(cloud).faces.tolist()}
    expected = {(row[0], *sorted(row[1:])) for row in delaunay_stars(unit_scale(points)[0], n_neighbors).tolist()}
    assert len(found ^ expected) <= 0.001 * len(expected)


def test_triangles_follow_each_other_around_their_center():
    F = stars_in_order(PointCloud(sphere(2).vertices)).faces
    same = F[1:, 0] == F[:-1, 0]
    assert (F[1:][same, 1] == F[:-1][same, 2]).all()


@pytest.mark.parametrize("points", [np.eye(3)[:2], np.arange(30)[:, None] * [1.0, 2, 3]])
def test_points_without_a_star_are_refused(points):
    with pytest.raises(MeshError, match="no point has a star"):
        stars_in_order(PointCloud(points))


def test_copies_of_a_point_have_its_star():
    points = sphere(2).vertices
    copied = [7, 7, 3]
    F = stars_in_order(PointCloud(np.concatenate([points, points[copied]]))).faces
    of_distinct = stars_in_order(PointCloud(points)).faces
    n = len(points)
    assert (F[F[:, 0] < n] == of_distinct).all()
    for i, original in enumerate(copied):
        assert (F[F[:, 0] == n + i][:, 1:] == of_distinct[of_distinct[:, 0] == original][:, 1:]).all()
