"""Labels of least energy: the best of all labelings of small graphs, and what cannot be changed."""

import itertools

import numpy as np
import pytest
from scipy.sparse import csr_array

from lbskel.applications.boundary_cut import expand_labels


def expanded(labels, costs, pairs, weights):
    """Labels by costs of which those that are infinite are not stored, and those of zero are."""
    face, label = np.isfinite(costs).nonzero()
    begins = np.append(0, np.cumsum(np.bincount(face, minlength=len(costs))))
    return expand_labels(labels, csr_array((costs[face, label], label, begins), shape=costs.shape), pairs, weights)


def energy(labels, costs, pairs, weights):
    labels = np.asarray(labels)
    return costs[np.arange(len(labels)), labels].sum() + weights[labels[pairs[:, 0]] != labels[pairs[:, 1]]].sum()


@pytest.mark.parametrize("seed", range(20))
def test_two_labels_are_cut_at_the_least_energy(seed):
    """With two labels one move is a minimum cut: the least of all 2^8 energies, up to the rounding of capacities."""
    rng = np.random.default_rng(seed)
    costs, pairs = rng.random((8, 2)), np.array(list(itertools.combinations(range(8), 2)))
    weights = rng.random(len(pairs)) * (rng.random(len(pairs)) < 0.4) * 0.5
    found = expanded(costs.argmin(axis=1), costs, pairs, weights)
    least = min(energy(each, costs, pairs, weights) for each in itertools.product((0, 1), repeat=8))
    assert energy(found, costs, pairs, weights) == pytest.approx(least, abs=1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_more_labels_are_within_the_bound_of_the_paper_and_no_single_change_is_better(seed):
    """Boykov, Veksler, Zabih 2001, theorem 6.1: at most twice the least energy."""
    rng = np.random.default_rng(seed)
    costs, pairs = rng.random((6, 3)), np.array(list(itertools.combinations(range(6), 2)))
    weights = rng.random(len(pairs)) * 0.4
    first = costs.argmin(axis=1)
    found = expanded(first, costs, pairs, weights)
    value = energy(found, costs, pairs, weights)
    least = min(energy(each, costs, pairs, weights) for each in itertools.product(range(3), repeat=6))
    assert least - 1e-6 <= value <= min(2 * least, energy(first, costs, pairs, weights)) + 1e-6
    for face, label in itertools.product(range(6), range(3)):
        changed = found.copy()
        changed[face] = label
        assert energy(changed, costs, pairs, weights) >= value - 1e-6


def test_a_label_of_infinite_cost_is_never_taken():
    costs = np.array([[0.0, np.inf], [0.1, np.inf], [9.0, 0.0]])
    pairs = np.array([[0, 1], [1, 2]])
    assert expanded(np.array([0, 0, 1]), costs, pairs, np.array([5.0, 5.0])).tolist() == [0, 0, 1]


def test_without_any_cost_nothing_changes():
    labels = np.array([1, 0])
    assert expanded(labels, np.zeros((2, 2)), np.array([[0, 1]]), np.zeros(1)).tolist() == [1, 0]
    assert expanded(labels, np.ones((2, 2)), np.empty((0, 2), np.int64), np.empty(0)).tolist() == [1, 0]
