"""Measures of a skeleton itself."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.evaluation.skeleton_shape import (
    MIN_KNOWN,
    mean_and_worst_branch,
    median_of_known,
    n_spurs,
    negative_fraction,
    rms_curvature,
)

PATH = Skeleton(np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]]), np.array([[0, 1], [1, 2]]), np.ones(3))


def test_values_are_linear_along_edges():
    assert negative_fraction(PATH, np.array([1.0, -1, 1])) == pytest.approx(0.5)
    assert negative_fraction(PATH, np.array([1.0, 1, -3])) == pytest.approx(0.5)
    assert negative_fraction(PATH, np.array([-1.0, -1, 0])) == 1
    assert negative_fraction(PATH, np.zeros(3)) == 0


def test_without_length_nodes_are_counted():
    assert negative_fraction(Skeleton(PATH.nodes, [], np.ones(3)), np.array([1.0, -1, 1])) == pytest.approx(1 / 3)


def test_a_branch_needs_known_values_for_a_median_of_its_own():
    n = MIN_KNOWN
    path = np.stack([np.arange(2 * n), np.zeros(2 * n), np.zeros(2 * n)], axis=1)
    parts = [np.stack([np.arange(a, b - 1), np.arange(a + 1, b)], axis=1) for a, b in ((0, n), (n, 2 * n))]
    skeleton = Skeleton(path, np.concatenate(parts), np.ones(2 * n))
    values = np.concatenate([np.zeros(n), np.arange(n)])
    assert mean_and_worst_branch(skeleton, values) == (values.mean(), np.median(np.arange(n)))
    values[-1] = np.nan  # one too few
    assert mean_and_worst_branch(skeleton, values) == (np.nanmean(values), 0.0)
    assert mean_and_worst_branch(skeleton, np.full(2 * n, np.nan)) == (None, None)


def test_a_median_of_few_nodes_is_not_that_of_a_branch():
    known = np.full(MIN_KNOWN, 2.0)
    assert median_of_known(np.append(known, np.full(MIN_KNOWN, np.nan))) == 2
    assert median_of_known(np.append(known, np.full(MIN_KNOWN + 1, np.nan))) is None  # less than half of the nodes


def test_a_straight_path_does_not_bend():
    assert rms_curvature(PATH) == 0


def test_a_branch_within_its_junction_is_a_spur():
    nodes = np.array([[0.0, 0, 0], [5, 0, 0], [-5, 0, 0], [0, 0.5, 0]])
    skeleton = Skeleton(nodes, np.array([[0, 1], [0, 2], [0, 3]]), np.array([1.0, 1, 1, 0.5]))
    assert n_spurs(skeleton) == 1
    assert n_spurs(replace(skeleton, anchors=[3])) == 0  # the caller asked for it
