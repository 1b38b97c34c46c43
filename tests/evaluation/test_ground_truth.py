"""Comparison with a truth: zero for the same, right for a known shift, one-sided where one is longer."""

import numpy as np
import pytest

from lbskel import Skeleton, ground_truth_distances
from lbskel.skeleton.edge_sampling import sample_edges


def line(z0, z1, x=0.0, radius=0.5):
    return Skeleton(np.array([[x, 0, z0], [x, 0, z1]]), [[0, 1]], np.full(2, radius))


def test_the_same_skeleton_is_at_no_distance():
    # samples are a twenty-thousandth of the length apart, so the nearest is within half of that
    comparison = ground_truth_distances(line(0, 2), line(0, 2))
    assert comparison.accuracy < 2 / 20_000 / 0.5
    assert comparison.coverage < 2 / 20_000 / 0.5
    assert comparison.is_topology_right
    assert (comparison.n_tips, comparison.n_true_tips) == (2, 2)


def test_a_shift_is_measured_in_radii():
    comparison = ground_truth_distances(line(0, 2, x=0.1), line(0, 2))
    for value in (comparison.accuracy, comparison.accuracy_95, comparison.coverage, comparison.coverage_95):
        assert value == pytest.approx(0.1 / 0.5, rel=1e-3)


def test_what_is_missing_counts_for_coverage_alone():
    comparison = ground_truth_distances(line(0, 1), line(0, 2))
    assert comparison.accuracy < 1e-3
    # half the axis is missing, its distances run evenly from 0 to 1: a mean of 1/4 over the whole, in radii of 1/2
    assert comparison.coverage == pytest.approx(0.25 / 0.5, rel=0.01)
    assert comparison.coverage_95 == pytest.approx(0.9 / 0.5, rel=0.01)


def test_another_topology_is_seen():
    ring = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    loop = Skeleton(ring, [[0, 1], [1, 2], [0, 2]], np.full(3, 0.1))
    open_loop = Skeleton(ring, [[0, 1], [1, 2]], np.full(3, 0.1))
    assert not ground_truth_distances(open_loop, loop).is_topology_right


def test_samples_lie_on_the_edges_no_further_apart_than_asked():
    points, radii = sample_edges(line(0, 1, radius=0.3), 0.3)
    assert np.allclose(np.diff(points[:, 2]), 0.25)
    assert np.allclose(radii, 0.3)
    alone = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.ones(1))
    assert len(sample_edges(alone, 0.1)[0]) == 1
