"""Least squares by every method: solutions, iterates, warm starts, and what is refused."""

import numpy as np
import pytest
from linear_systems import rectangular, right_hand_side
from scipy.sparse import csr_array, diags_array, eye_array, vstack

from lbskel import SolveError, UnknownChoice
from lbskel.solvers import CLASSICAL_ITERATIONS, DIRECT_SOLVERS, least_squares
from lbskel.solvers.least_squares import LEAST_SQUARES, _require_zero_gradient, lstsq

WITHOUT_ITERATES = {"qr", "svd", "augmented", *DIRECT_SOLVERS}
every_method = pytest.mark.parametrize("method", LEAST_SQUARES)
every_iterative = pytest.mark.parametrize("method", sorted(set(LEAST_SQUARES) - WITHOUT_ITERATES))


@every_method
def test_solutions_are_those_of_numpy(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    X = lstsq(K, B, method)
    # iterations end at a residual of 1e-10 of the start's, conditioned at 4 squared
    assert np.abs(X - np.linalg.lstsq(K.toarray(), B)[0]).max() < 1e-8
    assert X.shape == (K.shape[1], 3)


@every_method
def test_a_vector_gives_a_vector(method):
    K = rectangular(0.3)
    b = right_hand_side(K, 1)[:, 0]
    x = lstsq(K, b, method)
    assert x.shape == (K.shape[1],)
    assert x == pytest.approx(lstsq(K, b[:, None], method)[:, 0], abs=1e-12)


@every_method
def test_a_zero_right_hand_side_has_the_zero_solution(method):
    K = rectangular(0.3)
    assert (lstsq(K, np.zeros((K.shape[0], 2)), method) == 0).all()


@every_iterative
def test_iterates_are_observed_in_order_and_converge(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    seen = []
    X = lstsq(K, B, method, on_iterate=lambda number, X: seen.append((number, np.linalg.norm(X - exact))))
    numbers, errors = zip(*seen, strict=True)
    assert list(numbers) == sorted(set(numbers))
    assert numbers[0] == 1
    assert errors[0] > 1e-3
    assert errors[-1] == pytest.approx(np.linalg.norm(X - exact), abs=1e-12)
    assert errors[-1] < 1e-8


@every_iterative
def test_rows_and_columns_of_large_numbers_hide_no_error_of_others(method):
    """A chain held at both ends by rows of weight 1e3; one column is 1e9 times as large as the other."""
    n = 60
    chain = diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1]).tocsr()[1:-1]
    K = csr_array(vstack([chain, csr_array(([1e3, 1e3], ([0, 1], [0, n - 1])), shape=(2, n))]))
    X = np.linspace(0, 1, n)[:, None] ** 2 * [1e9, 1.0]
    try:
        found = lstsq(K, K @ X, method)
    except SolveError:
        assert method in {*CLASSICAL_ITERATIONS, "lsqr", "lsmr"}
    else:
        assert np.abs(found / [1e9, 1.0] - X / [1e9, 1.0]).max() < 1e-6  # the condition of K^T K is 1e8 after scaling


@pytest.mark.parametrize("method", ["cgls", "lsqr", "lsmr"])
def test_krylov_methods_that_have_not_converged_are_refused(method, monkeypatch):
    monkeypatch.setattr(least_squares, "MAX_ITERATIONS", 20)
    K = rectangular(0.3)
    with pytest.raises(SolveError, match="try 'cholmod'") as caught:
        lstsq(K, right_hand_side(K), method)
    assert caught.value.residual < 1e-3


@every_iterative
def test_a_start_at_the_solution_stays_there(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    assert lstsq(K, B, method, start=exact, iterations=3) == pytest.approx(exact, abs=1e-12)


@every_iterative
def test_a_start_near_the_solution_is_nearer_after_as_many_iterations(method):
    K = rectangular()
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    cold, warm = (
        np.linalg.norm(lstsq(K, B, method, start=start, iterations=4) - exact) for start in (None, 1.001 * exact)
    )
    assert warm < 0.01 * cold


@every_iterative
def test_no_more_iterations_than_asked(method):
    K = rectangular()
    seen = []
    lstsq(K, right_hand_side(K), method, iterations=5, on_iterate=lambda number, X: seen.append(number))
    assert max(seen) == 5


def test_krylov_methods_need_the_square_root_of_the_iterations_of_stationary_ones():
    K = rectangular()
    B = right_hand_side(K)
    counts = {}
    for method in ("richardson", "chebyshev", "cgls", "cg_jacobi"):
        counts[method] = 0

        def count(number, X, method=method):
            counts[method] = number

        lstsq(K, B, method, on_iterate=count)
    # condition 13^2 of the normal equations: 169 / 2 iterations for each digit's e-fold against 13 / 2
    assert counts["chebyshev"] < counts["richardson"] / 3
    assert max(counts["cgls"], counts["cg_jacobi"]) < counts["chebyshev"]


@pytest.mark.parametrize("method", ["qr", "svd"])
def test_dense_matrices_over_the_limit_of_memory_are_refused(method):
    n = 10_000  # 20,000 x 10,000 doubles are 1.6 GB
    K = csr_array(vstack([eye_array(n), eye_array(n)]))
    with pytest.raises(SolveError, match=r"20000 x 10000 takes 1\.6 GB.*augmented"):
        lstsq(K, np.ones(2 * n), method)


@pytest.mark.parametrize("method", ["augmented", "cholmod", "superlu"])
def test_dependent_columns_are_refused(method):
    K = csr_array([[1.0, 1.0], [2.0, 2.0], [0.0, 0.0]])
    with pytest.raises(SolveError):
        lstsq(K, [1.0, 1.0, 1.0], method)


@every_method
def test_what_is_not_finite_is_refused(method):
    K = rectangular()
    K.data[3] = np.nan
    with pytest.raises(SolveError, match="not finite"):
        lstsq(K, right_hand_side(K), method)


def test_an_unknown_method_is_answered_with_all_that_exist():
    with pytest.raises(UnknownChoice, match="lsmr"):
        lstsq(rectangular(), np.zeros(252), "magic")


def test_augmented_and_orthogonal_methods_do_not_square_the_condition():
    n = 200
    chain = diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    K = csr_array(chain @ chain)  # condition 2.7e8, of which the square is beyond double precision
    X = np.ones((n, 1))
    errors = {method: np.abs(lstsq(K, K @ X, method) - X).max() for method in ("qr", "svd", "augmented")}
    assert max(errors.values()) < 1e-6  # 2.7e8 roundings
    assert np.abs(lstsq(K, K @ X, "cholmod") - X).max() > 1e-2  # it does


@pytest.mark.parametrize("method", ["augmented", "cgls", "lsqr", "lsmr"])
def test_a_line_through_points_by_hand(method):
    """Through (0, 1), (1, 2), (2, 2), (3, 5) goes 0.7 + 1.2 t."""
    K = csr_array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])
    assert lstsq(K, [1.0, 2.0, 2.0, 5.0], method) == pytest.approx([0.7, 1.2], abs=1e-9)


def test_the_gradient_that_is_checked_is_that_of_the_normal_equations():
    """A large residual B - K X is no error: only its part in the range of K is."""
    K = csr_array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    assert lstsq(K, [1.0, 2.0, 1e6]) == pytest.approx([1, 2])
    with pytest.raises(SolveError, match=r"is 1\.0e\+00 of K\^T B"):
        _require_zero_gradient(K, np.zeros((2, 1)), np.ones((3, 1)))


@pytest.mark.parametrize("method", [*DIRECT_SOLVERS, "qr", "svd", "augmented", "lsqr", "lsmr"])
def test_a_right_hand_side_orthogonal_to_the_columns_has_the_zero_solution(method):
    """Its K^T B is rounding alone, and no gradient is small relative to that."""
    assert lstsq(csr_array(np.ones((3, 1))), [0.1, 0.2, -0.3], method) == pytest.approx([0], abs=1e-15)


@pytest.mark.parametrize("method", ["lsqr", "lsmr", "cgls"])
def test_no_iteration_is_made_where_none_is_asked_for(method):
    K, seen = rectangular(), []
    X = lstsq(K, right_hand_side(K), method, iterations=0, on_iterate=lambda number, X: seen.append(number))
    assert not X.any()
    assert not any(seen)


def test_what_is_no_system_is_refused():
    K = rectangular()
    with pytest.raises(SolveError, match=r"must have shape \(252, k\)"):
        lstsq(K, np.ones(251))
    with pytest.raises(SolveError, match="right-hand side is complex"):
        lstsq(K, 1j * np.ones(252))
    with pytest.raises(SolveError, match="matrix is complex"):
        lstsq(1j * K, np.ones(252))
    with pytest.raises(SolveError, match="start must have shape"):
        lstsq(K, np.ones(252), "cgls", start=np.ones(3))
    assert lstsq(K.toarray(), np.ones(252)) == pytest.approx(lstsq(K, np.ones(252)), abs=1e-14)
