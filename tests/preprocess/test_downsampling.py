"""Thinning of clouds: even, with the map of all points."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lbskel import PointCloud, UnknownChoice
from lbskel.preprocess import downsampling
from lbskel.preprocess.downsampling import DOWNSAMPLINGS, downsample, downsample_as
from lbskel.shapes import sphere

UNEVEN = PointCloud(np.concatenate([sphere(4).vertices, sphere(5).vertices[sphere(5).vertices[:, 2] > 0.5]]))


@pytest.mark.parametrize("how", ["voxel:cell=0.2", "farthest:points=300"])
def test_the_density_becomes_even_and_every_point_has_one_near_it(how):
    thin = downsample_as(UNEVEN, how)
    assert len(thin.points) < len(UNEVEN.points) / 4
    assert np.linalg.norm(thin.points[thin.vertex_map.indices] - UNEVEN.points, axis=1).max() < 0.2 * np.sqrt(3)
    nearest = cKDTree(thin.points).query(thin.points, k=2)[0][:, 1]
    upper = thin.points[:, 2] > 0.5
    assert np.median(nearest[upper]) == pytest.approx(np.median(nearest[~upper]), rel=0.2)
    assert f"from {len(UNEVEN.points):,} to {len(thin.points)} points" in thin.notes[0]
    assert thin.report == {"points": len(UNEVEN.points), "kept": len(thin.points)}


def test_farthest_points_are_points_of_the_cloud():
    thin = downsample(UNEVEN, n_points=50)
    assert len(thin.points) == 50
    assert cKDTree(UNEVEN.points).query(thin.points)[0].max() == 0


def test_farthest_points_are_distinct():
    cloud = PointCloud(np.concatenate([np.zeros((10, 3)), np.eye(3), np.eye(3)]))
    assert downsample(cloud, n_points=3).points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    thin = downsample(cloud, n_points=8)
    assert thin.points.tolist() == [[0, 0, 0], *np.eye(3).tolist()]
    assert thin.vertex_map.indices.tolist() == [0] * 10 + [1, 2, 3, 1, 2, 3]


def test_all_points_are_returned_without_a_search(monkeypatch):
    monkeypatch.delattr(downsampling, "_farthest")
    points = sphere(4).vertices
    assert np.array_equal(downsample(PointCloud(points), n_points=10**6).points, points)


@pytest.mark.parametrize("n_points", [0.5, 2.5, np.inf])
def test_a_number_of_points_is_whole(n_points):
    with pytest.raises(UnknownChoice, match=f"whole, not {n_points}"):
        downsample(UNEVEN, n_points=n_points)


@pytest.mark.parametrize(
    "text",
    [
        "voxel",
        "voxel:points=3",
        "farthest:points=-1",
        "farthest:points=x",
        "farthest:points=inf",
        "farthest:points=9.5",
        "poisson:cell=1",
    ],
)
def test_what_is_no_way_to_thin_is_refused(text):
    with pytest.raises(UnknownChoice, match="voxel" if "voxel" in text or "poisson" in text else "farthest"):
        downsample_as(UNEVEN, text)
    assert set(DOWNSAMPLINGS) == {"voxel", "farthest"}


def test_cells_that_cannot_be_numbered_are_refused():
    with pytest.raises(UnknownChoice, match="smaller than a millionth"):
        downsample(UNEVEN, cell=1e-9 * np.ptp(UNEVEN.points))


@pytest.mark.parametrize("options", [{}, {"cell": 1.0, "n_points": 3}, {"cell": 0.0}])
def test_exactly_one_number_is_given(options):
    with pytest.raises(UnknownChoice, match="more than 0"):
        downsample(UNEVEN, **options)
