"""Nearest points against all distances."""

import numpy as np

from lbskel.geometry.neighborhoods import Neighborhoods

POINTS = np.random.default_rng(2).normal(size=(60, 3))


def test_the_nearest_are_those_of_all_distances():
    distances, neighbors = Neighborhoods(POINTS).nearest(7)
    every = np.linalg.norm(POINTS[:, None] - POINTS, axis=2)
    np.testing.assert_array_equal(neighbors, np.argsort(every, axis=1)[:, :7])
    np.testing.assert_allclose(distances, np.sort(every, axis=1)[:, :7], atol=1e-15)  # of rounding


def test_few_points_have_as_many_neighbors_as_there_are():
    assert Neighborhoods(POINTS[:3]).nearest(7)[1].shape == (3, 3)
    assert Neighborhoods(POINTS[:1]).nearest(7)[1].tolist() == [[0]]
