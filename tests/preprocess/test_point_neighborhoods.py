"""Nearest points against all distances."""

import numpy as np

from lbskel.preprocess.point_neighborhoods import N_TOGETHER, Neighborhoods

POINTS = np.random.default_rng(2).normal(size=(60, 3))
ORDER = np.argsort(np.linalg.norm(POINTS[:, None] - POINTS, axis=2), axis=1)


def test_the_nearest_are_those_of_all_distances():
    cloud = Neighborhoods(POINTS)
    for k in (7, N_TOGETHER + 9):
        distances, neighbors = cloud.nearest(k)
        np.testing.assert_array_equal(neighbors, ORDER[:, :k])
        expected = np.linalg.norm(POINTS[:, None] - POINTS[neighbors], axis=2)
        np.testing.assert_allclose(distances, expected, atol=1e-15)  # of rounding


def test_wide_neighborhoods_are_found_for_some_points_and_kept():
    cloud = Neighborhoods(POINTS)
    for rows in ([3, 40], [], [40, 5, 3]):
        np.testing.assert_array_equal(cloud.wide(np.array(rows, dtype=np.int64)), ORDER[rows, : cloud.n_wide])


def test_few_points_have_as_many_neighbors_as_there_are():
    assert Neighborhoods(POINTS[:3]).nearest(7)[1].shape == (3, 3)
    assert Neighborhoods(POINTS[:1]).nearest(7)[1].tolist() == [[0]]
    assert Neighborhoods(POINTS[:3]).wide(np.array([1])).shape == (1, 3)
