"""Quadratic energies with prescribed values: against dense solutions, hard and soft."""

import numpy as np
import pytest
from scipy.sparse import csc_array

from lbskel import MeshError, SolveError, laplacian
from lbskel.applications.constrained_systems import (
    ConstrainedSystem,
    checked_indices,
    factorize_square,
)


def test_hard_constraints_are_eliminated(ring):
    S = laplacian(ring).stiffness
    rows = np.array([5, 3, 40])
    rng = np.random.default_rng(0)
    values, B = rng.standard_normal((3, 2)), rng.standard_normal((128, 2))
    X = ConstrainedSystem(S, rows).solve(values, B)
    assert (X[rows] == values).all()
    free = np.setdiff1d(np.arange(128), rows)
    assert np.abs((S @ X - B)[free]).max() < 1e-12 * abs(S).max() * np.abs(X).max()


def test_soft_constraints_minimize_the_sum_of_both_energies(ring):
    S = laplacian(ring).stiffness
    rows, held, weight = np.array([5, 3, 40]), np.array([7, 8]), 2.5
    values = np.random.default_rng(0).standard_normal((3, 1))
    X = ConstrainedSystem(S, rows, weight=weight, held=held).solve(values)
    W = np.zeros((128, 128))
    W[rows, rows] = weight
    right = np.zeros((128, 1))
    right[rows] = weight * values
    free = np.setdiff1d(np.arange(128), held)
    expected = np.linalg.solve((S.toarray() + W)[np.ix_(free, free)], right[free])
    assert (X[held] == 0).all()
    assert X[free] == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_a_system_without_free_rows_returns_the_values(tetrahedron):
    values = np.arange(12.0).reshape(4, 3)
    system = ConstrainedSystem(laplacian(tetrahedron).stiffness, np.arange(4))
    assert (system.solve(values) == values).all()


def test_any_regular_matrix_is_factorized_and_a_singular_one_is_named():
    indefinite, skew = csc_array([[1.0, 0.0], [0.0, -1.0]]), csc_array([[1.0, 3.0], [-1.0, 1.0]])
    assert factorize_square(indefinite).solve(np.array([2.0, 3.0])) == pytest.approx([2, -3])
    assert factorize_square(skew).solve(np.array([7.0, 1.0])) == pytest.approx([1, 2])
    with pytest.raises(SolveError):
        factorize_square(csc_array([[1.0, -1.0], [-1.0, 1.0]])).solve(np.array([1.0, 0.0]))


@pytest.mark.parametrize(
    ("indices", "message"),
    [
        ([0, 9], "9 are no"),
        ([-1], "-1 are no"),
        ([2, 2], "twice"),
        ([0.5], "float64"),
        ([True, False], "a mask of all 9 vertices, not bool"),
        ([[1], [2, 3]], "anchors must be a list"),
    ],
)
def test_wrong_indices_are_named(indices, message):
    with pytest.raises(MeshError, match=message):
        checked_indices(indices, 9, "anchors")
    assert checked_indices([], 9, "anchors").shape == (0,)


def test_indices_may_be_given_twice_where_they_need_not_be_distinct():
    assert checked_indices([5, 2, 5], 9, "sources", distinct=False).tolist() == [5, 2, 5]


def test_a_mask_stands_for_its_vertices():
    assert checked_indices(np.arange(9) % 4 == 1, 9, "anchors").tolist() == [1, 5]
