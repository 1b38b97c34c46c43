"""Thick-restart Lanczos iteration on matrices whose eigenvalues are known."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csc_array, diags_array

from lbskel.errors import SolveError
from lbskel.solvers import lanczos
from lbskel.solvers.lanczos import MIN_SURPLUS, ThickRestartLanczos

ROUNDING = 1e-11  # a thousand times the tolerance of the iteration, for values of about 1


def pencil(n):
    """A diagonal matrix of mass, a symmetric matrix A, and the function of M q that applies M^-1 A."""
    random = np.random.default_rng(2)
    masses = random.uniform(0.5, 2.0, n)
    A = random.standard_normal((n, n))
    A = A + A.T
    return csc_array(diags_array(masses)), A, lambda b: A @ (b / masses) / masses


@pytest.mark.parametrize("k", [1, 7, MIN_SURPLUS + 10])
def test_the_largest_eigenpairs_are_those_of_the_dense_problem(k):
    n = 150
    M, A, apply = pencil(n)
    values, X = ThickRestartLanczos(apply, M, k, np.random.default_rng(0)).run()
    expected = eigh(A, M.toarray(), eigvals_only=True)[::-1][:k]
    assert np.abs(values - expected).max() < ROUNDING * expected[0]
    assert np.abs(X.T @ (M @ X) - np.eye(k)).max() < ROUNDING
    assert np.abs(A @ X - (M @ X) * values).max() < ROUNDING * expected[0]


def test_a_further_direction_finds_a_second_vector_of_a_multiple_eigenvalue():
    """Of a projection, one start finds one vector of each of the two eigenvalues."""
    n = 60
    rank = np.arange(n) < 5
    lanczos = ThickRestartLanczos(
        lambda b: np.where(rank, b, 0.5 * b), csc_array(np.eye(n)), 4, np.random.default_rng(0)
    )
    first, _ = lanczos.run()
    lanczos.add_direction()
    second, X = lanczos.run()
    assert np.abs(second - 1.0).max() < ROUNDING
    assert np.abs(X[~rank]).max() < ROUNDING
    assert np.abs(X.T @ X - np.eye(4)).max() < ROUNDING
    assert first[0] == pytest.approx(1.0, abs=ROUNDING)


class StartsOf:
    """A source of given starting vectors."""

    def __init__(self, *starts):
        self.starts = list(starts)

    def uniform(self, low, high, n):
        return self.starts.pop(0)


def test_a_further_direction_is_followed_though_the_pairs_found_before_have_converged():
    """With nine pairs the first step after the start makes ten vectors, at which convergence is tested."""
    values = np.concatenate([np.arange(10.0, 3.0, -1.0), [3.0, 3.0], np.linspace(0.001, 0.5, 191)])
    n, k = len(values), 9
    start, further = np.random.default_rng(0).uniform(-1, 1, (2, n))
    start[k - 1] = 0.0  # so that one vector of the double eigenvalue is never met
    lanczos = ThickRestartLanczos(lambda b: values * b, csc_array(np.eye(n)), k, StartsOf(start, further))
    assert lanczos.run()[0][-1] < 1.0
    lanczos.add_direction()
    assert np.abs(lanczos.run()[0] - values[:k]).max() < ROUNDING * values[0]


def test_further_directions_are_followed_until_a_vector_that_comes_up_slowly_is_found():
    """The missing value, 3, is 0.03 % above the next: ten steps from a new start stay below both."""
    values = np.concatenate([np.arange(10.0, 3.0, -1.0), [3.0, 3.0], np.linspace(0.001, 2.999, 191)])
    k = 9
    starts = np.random.default_rng(0).uniform(-1, 1, (4, len(values)))
    starts[0, k - 1] = 0.0
    lanczos = ThickRestartLanczos(lambda b: values * b, csc_array(np.eye(len(values))), k, StartsOf(*starts))
    assert lanczos.run()[0][-1] == pytest.approx(2.999)
    for _ in range(3):  # with ten steps for each, 15 do not suffice
        lanczos.add_direction()
        found, _ = lanczos.run()
    assert np.abs(found - values[:k]).max() < ROUNDING * values[0]


def test_what_does_not_converge_is_an_error(monkeypatch):
    monkeypatch.setattr(lanczos, "MAX_RESTARTS", 1)
    M, _, apply = pencil(400)
    with pytest.raises(SolveError, match="has not found 20 eigenpairs"):
        ThickRestartLanczos(apply, M, 20, np.random.default_rng(0)).run()
