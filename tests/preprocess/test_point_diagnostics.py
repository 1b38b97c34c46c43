"""The report on a cloud: counts, and what will be done."""

import json

import numpy as np
import pytest

from lbskel import PointCloud
from lbskel.preprocess.point_diagnostics import check_points
from lbskel.shapes import sphere

SPHERE = sphere(4).vertices


def test_a_good_cloud_has_no_findings():
    report = check_points(PointCloud(SPHERE))
    assert report.is_advised
    assert report.findings == ()
    assert report.kept == len(SPHERE)
    assert json.loads(json.dumps(report.as_dict()))["points"] == len(SPHERE)
    assert "Nothing that prevents a skeleton" in str(report)


def test_the_size_of_a_cloud_is_that_of_its_mesh():
    stretched = np.concatenate([SPHERE, SPHERE[:50]]) * [1, 1, 3] + 7
    report = check_points(PointCloud(stretched))
    assert report.diameter_bound == pytest.approx(6, rel=1e-3)  # 50 copies do not move the mean
    assert "the diameter bound is 6" in str(report)


def test_duplicates_and_outliers_are_counted():
    report = check_points(PointCloud(np.concatenate([SPHERE, SPHERE[:4], [[5.0, 5, 5]]])))
    assert (report.duplicates, report.outliers, report.kept) == (4, 1, len(SPHERE))
    assert len(report.findings) == 2
    assert "4 duplicate points are merged" in str(report)


def test_points_in_a_plane_have_no_skeleton():
    report = check_points(PointCloud(SPHERE * [1, 1, 0]))
    assert not report.is_advised
    assert "in a plane" in report.findings[0]


def test_one_point_is_no_cloud_for_a_skeleton():
    assert not check_points(PointCloud([[0, 0, 0]])).is_advised


def test_uneven_clouds_are_told():
    parts = [SPHERE, SPHERE[:100] * 40 + 99]
    assert any("varies by a factor" in finding for finding in check_points(PointCloud(np.concatenate(parts))).findings)
