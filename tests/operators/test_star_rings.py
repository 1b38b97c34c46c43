"""Stars in order: the same triangles as the vectorized ones, rings that follow each other."""

import numpy as np
import pytest

from lbskel import MeshError, PointCloud
from lbskel.operators.points import cloud_stars
from lbskel.operators.star_rings import stars_in_order
from lbskel.shapes import make, sphere


def test_the_triangles_are_those_of_the_local_delaunay_operator():
    cloud = PointCloud(make("limbs", n_vertices=1500).mesh.vertices)
    found = {(row[0], *sorted(row[1:])) for row in stars_in_order(cloud).faces.tolist()}
    expected = {(row[0], *sorted(row[1:])) for row in cloud_stars(cloud).tolist()}
    assert len(found ^ expected) <= 0.001 * len(expected)  # of points on a circle either diagonal is right


def test_triangles_follow_each_other_around_their_center():
    F = stars_in_order(PointCloud(sphere(2).vertices)).faces
    same = F[1:, 0] == F[:-1, 0]
    assert (F[1:][same, 1] == F[:-1][same, 2]).all()


@pytest.mark.parametrize("points", [np.eye(3)[:2], np.arange(30)[:, None] * [1.0, 2, 3]])
def test_points_without_a_star_are_refused(points):
    with pytest.raises(MeshError, match="no point has a star"):
        stars_in_order(PointCloud(points))


def test_coincident_points_do_no_harm():
    points = sphere(2).vertices
    assert len(np.unique(stars_in_order(PointCloud(np.concatenate([points, points[:3]]))).faces[:, 0])) >= len(points)
