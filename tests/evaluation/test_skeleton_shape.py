"""Measures of a skeleton itself."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.evaluation.skeleton_shape import length_fraction, n_spurs, rms_curvature

PATH = Skeleton(np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]]), np.array([[0, 1], [1, 2]]), np.ones(3))


def test_the_fraction_of_the_length_counts_half_of_each_edge_for_either_end():
    assert length_fraction(PATH, np.array([False, True, False])) == pytest.approx(0.5)
    assert length_fraction(PATH, np.array([False, False, True])) == pytest.approx(1 / 3)


def test_a_straight_path_does_not_bend():
    assert rms_curvature(PATH) == 0


def test_a_branch_within_its_junction_is_a_spur():
    nodes = np.array([[0.0, 0, 0], [5, 0, 0], [-5, 0, 0], [0, 0.5, 0]])
    skeleton = Skeleton(nodes, np.array([[0, 1], [0, 2], [0, 3]]), np.array([1.0, 1, 1, 0.5]))
    assert n_spurs(skeleton) == 1
