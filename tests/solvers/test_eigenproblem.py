"""Eigenpairs of sparse matrices whose spectrum is known in closed form, and the count of eigenvalues by inertia."""

from math import comb

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import block_array, block_diag, csc_array, diags_array, eye_array, kron

from lbskel.errors import SolveError, UnknownChoice
from lbskel.solvers import eigenproblem
from lbskel.solvers.eigenproblem import MAX_DENSE_SIZE, count_below, smallest_eigenpairs

ROUNDING = 1e-11  # error of eigenvalues below 4 of matrices with a few hundred rows


def cycle_laplacian(n):
    """The Laplacian of a cycle of n nodes: eigenvalues 2 - 2 cos(2 pi j / n), all but the first (and last) double."""
    S = diags_array([np.full(n, 2.0), -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1]).tolil()
    S[0, n - 1] = S[n - 1, 0] = -1.0
    return csc_array(S)


def cycle_eigenvalues(n):
    """The eigenvalues of :func:`cycle_laplacian`, ascending."""
    return np.sort(2 - 2 * np.cos(2 * np.pi * np.arange(n) / n))


def masses(values):
    """The diagonal matrix of some masses."""
    return csc_array(diags_array(np.asarray(values, dtype=np.float64)))


@pytest.mark.parametrize("n", [MAX_DENSE_SIZE // 2, 3 * MAX_DENSE_SIZE])
@pytest.mark.parametrize("k", [1, 2, 9, 20])
def test_eigenpairs_of_a_cycle_are_those_of_its_closed_form(n, k):
    mass = 0.25
    S, M = cycle_laplacian(n), masses(np.full(n, mass))
    values, X = smallest_eigenpairs(S, M, k)
    assert values.shape == (k,)
    assert np.abs(values - cycle_eigenvalues(n)[:k] / mass).max() < ROUNDING
    assert np.abs(X.T @ (M @ X) - np.eye(k)).max() < ROUNDING
    assert np.abs(S @ X - (M @ X) * values).max() < ROUNDING
    assert (X[np.abs(X).argmax(axis=0), np.arange(k)] > 0).all()


def test_lanczos_agrees_with_the_dense_solution_for_uneven_masses_that_are_not_diagonal():
    n, k = 3 * MAX_DENSE_SIZE, 10
    random = np.random.default_rng(0)
    S = cycle_laplacian(n)
    M = (masses(random.uniform(0.5, 2.0, n)) + 0.1 * csc_array(abs(S))).tocsc()
    values, X = smallest_eigenpairs(S, M, k)
    assert np.abs(values - eigh(S.toarray(), M.toarray(), eigvals_only=True)[:k]).max() < ROUNDING
    assert np.abs(X.T @ (M @ X) - np.eye(k)).max() < ROUNDING


@pytest.mark.parametrize("k", [10, 25, 38, 44, 55])
def test_every_eigenvector_of_a_multiple_eigenvalue_is_found(k):
    """The graph of the 9-cube has the eigenvalue 2 j with multiplicity (9 over j); one run of Lanczos misses some."""
    edge = csc_array([[1.0, -1.0], [-1.0, 1.0]])
    S = edge
    for _ in range(8):
        S = csc_array(kron(S, eye_array(2)) + kron(eye_array(S.shape[0]), edge))
    mass = 0.25
    M = masses(np.full(512, mass))
    values, X = smallest_eigenpairs(S, M, k)
    assert np.abs(values - np.repeat(2 * np.arange(10), [comb(9, j) for j in range(10)])[:k] / mass).max() < 1e-10
    assert np.abs(X.T @ (M @ X) - np.eye(k)).max() < 1e-10
    assert np.abs(S @ X - (M @ X) * values).max() < 1e-10


def test_components_are_solved_separately_whatever_the_order_of_their_rows():
    sizes = (150, 40, 7)
    S = csc_array(block_diag([cycle_laplacian(n) for n in sizes]))
    order = np.random.default_rng(1).permutation(sum(sizes))
    shuffled = S[order][:, order].tocsc()
    k = 12
    values, X = smallest_eigenpairs(shuffled, masses(np.ones(len(order))), k)
    expected = np.sort(np.concatenate([cycle_eigenvalues(n) for n in sizes]))[:k]
    assert np.abs(values - expected).max() < ROUNDING
    assert np.abs(shuffled @ X - X * values).max() < ROUNDING
    component = np.repeat(np.arange(3), sizes)[order]
    for vector in X.T:  # no eigenvector extends over two components
        assert len(np.unique(component[vector != 0])) == 1


def test_a_component_without_mass_has_no_eigenpairs():
    S = csc_array(block_diag([cycle_laplacian(5), cycle_laplacian(4)]))
    values, X = smallest_eigenpairs(S, masses([1.0] * 5 + [0.0] * 4), 20)
    assert np.abs(values - cycle_eigenvalues(5)).max() < ROUNDING
    assert X.shape == (9, 5)
    assert (X[5:] == 0).all()


def test_rows_without_mass_have_the_mean_value_of_their_neighbors():
    n, k = 3 * MAX_DENSE_SIZE, 8
    S, mass = cycle_laplacian(n), np.ones(n)
    mass[::3] = 0
    values, X = smallest_eigenpairs(S, masses(mass), k)
    assert np.abs(X[::3] - ((np.roll(X, 1, axis=0) + np.roll(X, -1, axis=0)) / 2)[::3]).max() < ROUNDING
    # Without these rows: a cycle of 200 nodes whose weights alternate between 1 and 1/2.
    inner, outer = mass > 0, mass == 0
    D = S.toarray()
    reduced = D[np.ix_(inner, inner)] - D[np.ix_(inner, outer)] @ D[np.ix_(outer, inner)] / 2
    assert np.abs(values - np.linalg.eigvalsh(reduced)[:k]).max() < ROUNDING


@pytest.mark.parametrize("mass", [0.0, 1e-18, 1e-14])
@pytest.mark.parametrize("n", [MAX_DENSE_SIZE // 2, 3 * MAX_DENSE_SIZE])
def test_a_row_with_hardly_any_mass_changes_no_eigenvalue(n, mass):
    """The middle of an edge of a cycle: two springs of weight 2 in a row are one of weight 1."""
    S = cycle_laplacian(n).tolil()
    S.resize(n + 1, n + 1)
    S[0, 1] = S[1, 0] = 0
    S[0, n] = S[n, 0] = S[1, n] = S[n, 1] = -2
    S[0, 0], S[1, 1], S[n, n] = 3, 3, 4
    values, X = smallest_eigenpairs(csc_array(S), masses([1.0] * n + [mass]), 6)
    assert np.abs(values - cycle_eigenvalues(n)[:6]).max() < ROUNDING
    assert np.abs(X[n] - (X[0] + X[1]) / 2).max() < ROUNDING


def test_rows_without_mass_have_no_eigenpairs_of_their_own():
    mass = np.ones(20)
    mass[::4] = 0
    values, X = smallest_eigenpairs(cycle_laplacian(20), masses(mass), 20)
    assert len(values) == X.shape[1] == 15
    assert np.abs(X.T @ (mass[:, None] * X) - np.eye(15)).max() < ROUNDING


def test_most_rows_may_be_without_mass():
    """The mass that makes them definite must not set the shift, which took 13 of 16 digits from the eigenvalues."""
    n, n_more = 2 * MAX_DENSE_SIZE, 5 * MAX_DENSE_SIZE  # a cycle, and more rows that each hang on one of its nodes
    ties = csc_array((np.ones(n_more), (np.arange(n_more), np.arange(n_more) % n)), shape=(n_more, n))
    S = block_array([[cycle_laplacian(n) + ties.T @ ties, -ties.T], [-ties, eye_array(n_more)]]).tocsc()
    values, X = smallest_eigenpairs(S, masses(np.repeat([1.0, 0.0], [n, n_more])), 8)
    assert np.abs(values - cycle_eigenvalues(n)[:8]).max() < ROUNDING
    assert np.abs(X[n:] - ties @ X[:n]).max() < 1e-6


def test_a_component_of_one_row_has_the_eigenvalue_zero():
    values, X = smallest_eigenpairs(csc_array(np.diag([0.0, 2.0])), masses([4.0, 1.0]), 2)
    assert np.abs(values - [0, 2]).max() < ROUNDING
    assert np.abs(X - [[0.5, 0], [0, 1]]).max() < ROUNDING


@pytest.mark.parametrize("k", [0, -1, 2.5, "3", True])
def test_the_number_of_eigenpairs_must_be_a_positive_integer(k):
    with pytest.raises(UnknownChoice, match="number of eigenpairs must be a whole number from 1 on"):
        smallest_eigenpairs(cycle_laplacian(5), masses(np.ones(5)), k)


def test_solvers_agree_and_runs_give_the_same_bytes():
    S, M = cycle_laplacian(200), masses(np.linspace(1, 2, 200))
    first, second = smallest_eigenpairs(S, M, 8), smallest_eigenpairs(S, M, 8)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))
    assert np.abs(first[0] - smallest_eigenpairs(S, M, 8, solver="superlu")[0]).max() < ROUNDING


@pytest.mark.parametrize("n", [MAX_DENSE_SIZE // 2, 2 * MAX_DENSE_SIZE])
def test_an_indefinite_matrix_is_refused(n):
    with pytest.raises(SolveError, match="not positive definite"):
        smallest_eigenpairs((-cycle_laplacian(n)).tocsc(), masses(np.ones(n)), 3)


@pytest.mark.parametrize("mass", [0.5, 1.0, 2.0])
def test_count_below_counts_the_eigenvalues_of_the_pair_of_matrices(mass):
    n = 61
    S, M, values = cycle_laplacian(n), masses(np.full(n, mass)), cycle_eigenvalues(n) / mass
    for bound in (-1.0, 1e-6, 0.3, 1.7, 3.0, 100.0):  # at 3.0 and mass 1 a leading minor is exactly singular
        assert count_below(S, M, bound) == (values < bound).sum()


def test_eigenvalues_that_stay_missing_are_an_error(monkeypatch):
    monkeypatch.setattr(eigenproblem, "count_below", lambda *_, **__: 10**6)
    S = cycle_laplacian(3 * MAX_DENSE_SIZE)
    with pytest.raises(SolveError, match="has missed eigenvalues in 10 runs"):
        smallest_eigenpairs(S, masses(np.ones(S.shape[0])), 4)
