"""Nearest points, and points in disks, against all distances."""

import numpy as np
import pytest

rng = np.random.default_rng(2)
POINTS, QUERIES = rng.normal(size=(90, 3)), rng.normal(size=(20, 3)) * 2
GRID = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def _nearest(points, queries, k):
    """Distances and numbers by sorting all, those of equal distance by their numbers."""
    every = np.sqrt(((queries[:, None] - points) ** 2).sum(axis=2))
    order = np.argsort(every, axis=1, kind="stable")[:, :k]
    return np.take_along_axis(every, order, axis=1), order


@pytest.mark.parametrize("k", [1, 7, 90])
def test_the_nearest_are_those_of_all_distances(kernel, k):
    tree = kernel.PointTree(POINTS)
    for queries, found in ((QUERIES, tree.nearest(QUERIES, k)), (POINTS, tree.neighbors(k))):
        distances, numbers = _nearest(POINTS, queries, k)
        np.testing.assert_array_equal(found[1], numbers)
        np.testing.assert_allclose(found[0], distances, rtol=1e-15)  # of rounding


@pytest.mark.parametrize("scale", [1.0, 1e-162, 1e75])  # squares of the second are 0 for some neighbors
def test_equal_distances_come_in_the_order_of_the_numbers(kernel, scale):
    points = np.repeat(GRID[rng.permutation(len(GRID))], 2, axis=0) * scale
    numbers = kernel.PointTree(points).neighbors(20)[1]
    np.testing.assert_array_equal(numbers, np.argsort(_squares(points), axis=1, kind="stable")[:, :20])


def _squares(points):
    with np.errstate(under="ignore"):
        return ((points[:, None] - points) ** 2).sum(axis=2)


def test_there_are_as_many_neighbors_as_points(kernel):
    for n in range(1, 10):
        assert np.sort(kernel.PointTree(POINTS[:n]).nearest(QUERIES, 20)[1]).tolist() == [list(range(n))] * 20
    assert kernel.PointTree(POINTS).nearest(np.empty((0, 3)), 2)[1].shape == (0, 2)


def test_points_in_disks_are_in_the_ball_and_near_the_plane(kernel):
    radii, widths = rng.uniform(0.5, 3, 20), rng.uniform(0.2, 4, 20)
    axes = QUERIES / np.linalg.norm(QUERIES, axis=1, keepdims=True)
    numbers, counts = kernel.PointTree(POINTS).in_disks(QUERIES, radii, axes, widths)
    offsets = POINTS - QUERIES[:, None]
    along = np.abs((offsets * axes[:, None]).sum(axis=2))
    is_in = ((offsets**2).sum(axis=2) <= radii[:, None] ** 2) & (along <= widths[:, None])
    assert counts.tolist() == is_in.sum(axis=1).tolist()
    found = np.split(numbers, np.cumsum(counts)[:-1])
    assert [np.sort(each).tolist() for each in found] == [np.flatnonzero(row).tolist() for row in is_in]
    with pytest.raises(ValueError, match="for each center"):
        kernel.PointTree(POINTS).in_disks(QUERIES, radii[1:], axes, widths)


def test_compiled_or_not_is_the_same(assert_same):
    ones = np.ones(len(QUERIES))
    assert_same(lambda kernel: kernel.PointTree(POINTS).nearest(QUERIES, 5))
    assert_same(lambda kernel: kernel.PointTree(POINTS).neighbors(5))
    assert_same(lambda kernel: kernel.PointTree(POINTS).in_disks(QUERIES, 2 * ones, QUERIES, ones))
