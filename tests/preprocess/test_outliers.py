"""Outliers of clouds: alone, in groups of their own, and what is none."""

import numpy as np
import pytest

from lbskel.preprocess.outliers import find_outliers
from lbskel.shapes import sphere

SPHERE = sphere(4).vertices  # 2,562 points
LIMIT = 3.0


def _scattered(n, seed, low=1.6, side=2.0):
    """Points in a cube beside the sphere, which is empty otherwise."""
    return np.random.default_rng(seed).uniform(low, low + side, (n, 3))


@pytest.mark.parametrize("n", [1, 12, 40, 100, 250])
def test_scattered_points_beside_a_surface_are_outliers_however_many(n):
    found = find_outliers(np.concatenate([SPHERE, _scattered(n, n)]), LIMIT)
    assert found[len(SPHERE) :].all()
    assert not found[: len(SPHERE)].any()


def test_a_sparse_surface_beside_a_dense_one_is_kept():
    sparse = sphere(2).vertices + [3.0, 0, 0]  # 162 points, four times as far apart
    found = find_outliers(np.concatenate([SPHERE, sparse]), LIMIT)
    assert not found[: len(SPHERE)].any()
    assert found[len(SPHERE) :].mean() < 0.1


def test_noise_makes_no_outliers():
    rng = np.random.default_rng(0)
    assert not find_outliers(SPHERE * (1 + 0.05 * rng.normal(size=(len(SPHERE), 1))), LIMIT).any()


def test_few_points_are_no_outliers():
    assert not find_outliers(SPHERE[:5], LIMIT).any()
