"""Skeletons made fit for tubes: radii, distances of nodes, hidden twigs, axes that come near."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.shapes.tubes import CLEARANCE, MAX_SLOPE, MAX_SPACING, MIN_RADIUS, tubular


def path(points, radii):
    k = np.arange(len(points) - 1)
    return Skeleton(points, np.stack([k, k + 1], axis=1), radii)


def line(n, spacing, radii):
    return path(np.arange(n)[:, None] * [spacing, 0, 0], np.broadcast_to(radii, n))


def test_radii_that_are_missing_or_tiny_are_raised():
    radii = np.full(9, 1.0)
    radii[[2, 4, 6]] = np.nan, 0.0, 1e-6
    assert tubular(line(9, 1.0, radii)).radii.min() == MIN_RADIUS


def test_nodes_are_neither_crowded_nor_far_apart():
    crowded, sparse = tubular(line(41, 0.1, 1.0)), tubular(line(3, 8.0, 1.0))
    for skeleton, length in ((crowded, 4.0), (sparse, 16.0)):
        assert skeleton.length == pytest.approx(length)
        assert skeleton.edge_lengths.max() <= MAX_SPACING
        assert skeleton.edge_lengths.min() >= 1.0


def test_radii_do_not_change_faster_than_the_slope():
    radii = np.ones(31)
    radii[15] = 9.0  # the nodes inside of its ball are dropped; at 10 follow some of radius 1
    fitted = tubular(line(31, 2.0, radii))
    change = np.abs(np.diff(fitted.radii[fitted.edges], axis=1)).ravel()
    assert (change <= MAX_SLOPE * fitted.edge_lengths + 1e-12).all()
    assert fitted.radii.max() == pytest.approx(1 + MAX_SLOPE * 10)
    assert fitted.radii.min() == 1
    assert fitted.length == pytest.approx(60)


def test_twigs_inside_of_their_junction_are_removed():
    nodes = [[-5, 0, 0], [0, 0, 0], [5, 0, 0], [0, 1.2, 0], [1, 4, 0]]
    edges = [[0, 1], [1, 2], [1, 3], [1, 4]]
    fitted = tubular(Skeleton(nodes, edges, [1.0, 1.0, 1.0, 0.25, 0.5]))
    # of 1.2 + 0.25 and 4.1 + 0.5 radii one is below 1.5
    assert len(fitted.tips) == 3
    assert fitted.nodes[:, 1].max() == 4


def test_axes_that_come_near_get_thinner_there_and_only_there():
    """A hairpin: 1.6 apart over a path of 21.6, with radii of 1 that would overlap."""
    x = np.arange(11.0)
    there, back = np.stack([x, 0 * x, 0 * x], axis=1), np.stack([x[::-1], 0 * x + 1.6, 0 * x], axis=1)
    tail = np.stack([0 * x[1:], 1.6 + 0 * x[1:], 2 * x[1:]], axis=1)
    fitted = tubular(path(np.concatenate([there, back, tail]), np.ones(32)))
    i, j = fitted.nodes[:, 1] < 0.1, fitted.nodes[:, 1] > 1.5
    pairs = np.linalg.norm(fitted.nodes[i][:, None] - fitted.nodes[j], axis=2)
    sums = fitted.radii[i][:, None] + fitted.radii[j]
    away = fitted.nodes[i][:, None, 0] < 6  # from the bend, where the path is short
    assert (pairs >= CLEARANCE * sums - 1e-9)[np.broadcast_to(away, pairs.shape)].all()
    assert fitted.radii.max() == 1
    assert len(fitted.tips) == 2


def test_of_two_coincident_branches_the_shorter_is_removed():
    x = np.arange(1, 13)[:, None] * [1.0, 0, 0]
    long, short = x, x[:8] + [0, 0.01, 0]
    nodes = np.concatenate([[[0, 0, 0], [0, -9, 0]], long, short])
    edges = [[0, 1], [0, 2], *([k, k + 1] for k in range(2, 13)), [0, 14], *([k, k + 1] for k in range(14, 21))]
    fitted = tubular(Skeleton(nodes, edges, np.full(len(nodes), 0.5)))
    assert (len(fitted.tips), fitted.nodes[:, 0].max()) == (2, 12)
