"""Outliers of clouds: alone, in groups of their own, and what is none."""

import numpy as np
import pytest

from lbskel.preprocess.outliers import find_outliers
from lbskel.preprocess.point_neighborhoods import Neighborhoods
from lbskel.shapes import sphere

SPHERE = sphere(4).vertices  # 2,562 points
LIMIT = 3.0


def _outliers(points):
    is_outlier, kept = find_outliers(Neighborhoods(points), LIMIT)
    np.testing.assert_array_equal(kept.points, points[~is_outlier])
    return is_outlier


def _scattered(n, seed, low=1.6, side=2.0):
    """Points in a cube beside the sphere, which is empty otherwise."""
    return np.random.default_rng(seed).uniform(low, low + side, (n, 3))


@pytest.mark.parametrize("n", [1, 12, 40, 100, 250])
def test_scattered_points_beside_a_surface_are_outliers_however_many(n):
    found = _outliers(np.concatenate([SPHERE, _scattered(n, n)]))
    assert found[len(SPHERE) :].all()
    assert not found[: len(SPHERE)].any()


def test_a_sparse_surface_beside_a_dense_one_is_kept():
    sparse = sphere(2).vertices + [3.0, 0, 0]  # 162 points, four times as far apart
    found = _outliers(np.concatenate([SPHERE, sparse]))
    assert not found[: len(SPHERE)].any()
    assert found[len(SPHERE) :].mean() < 0.1


def test_noise_makes_no_outliers():
    rng = np.random.default_rng(0)
    assert not _outliers(SPHERE * (1 + 0.05 * rng.normal(size=(len(SPHERE), 1)))).any()


@pytest.mark.parametrize("between", [1e-9, 1e-3])
def test_two_scans_of_a_surface_have_no_outliers(between):
    """Of 16,000 points, each a deviation from its copy, that are 0.04 apart, some would be outliers without."""
    rng = np.random.default_rng(0)
    once = rng.normal(size=(8000, 3))
    once /= np.linalg.norm(once, axis=1, keepdims=True)
    twice = np.concatenate([once, once + between * rng.normal(size=once.shape)])
    assert not _outliers(twice).any()
    assert _outliers(np.concatenate([twice, [[3.0, 0, 0]]]))[-1]


def test_few_points_are_no_outliers():
    assert not _outliers(SPHERE[:5]).any()
