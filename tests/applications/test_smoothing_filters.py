"""Filters of positions: the transfer function, and what is held."""

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval
from numpy.polynomial.polynomial import polyval

from lbskel import laplacian
from lbskel.applications.neighbor_means import NeighborMeans, edge_keys
from lbskel.applications.smoothing_filters import (
    CUTOFF,
    DEGREE,
    FILTER,
    average,
    average_of_neighbors,
    filter_coefficients,
)

EIGENVALUES = np.linspace(0, 2, 50)


def test_the_expansion_converges_to_the_gaussian():
    found = chebval(1 - EIGENVALUES, filter_coefficients(CUTOFF, 30))
    assert found == pytest.approx(np.exp(-((EIGENVALUES / CUTOFF) ** 2)), abs=1e-6)  # what is left out of degree 30


def test_powers_are_the_expansion_and_amplify_nothing():
    expected = chebval(1 - EIGENVALUES, filter_coefficients(CUTOFF, DEGREE))
    assert polyval(1 - EIGENVALUES, FILTER) == pytest.approx(expected, abs=1e-14)
    assert np.abs(expected).max() <= 1 + 1e-12
    assert FILTER.sum() == pytest.approx(1, abs=1e-14)  # of what is constant


def test_both_averages_are_the_same_and_keep_what_is_held(ring):
    X, held = ring.vertices, np.array([0, 7])
    by_edges = average_of_neighbors(NeighborMeans(len(X), edge_keys(ring)), held)(X)
    assert by_edges == pytest.approx(average(laplacian(ring, operator="graph"), held)(X), abs=1e-14)
    assert np.array_equal(by_edges[held], X[held])
    assert not np.array_equal(average_of_neighbors(NeighborMeans(len(X), edge_keys(ring)), held[:0])(X)[held], X[held])
