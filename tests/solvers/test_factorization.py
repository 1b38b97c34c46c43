"""Direct solvers: against dense numpy, ill-conditioned and unsolvable systems; refinement and residuals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linear_systems import EPSILON, ill_conditioned, right_hand_sides, shifted_laplacian
from scipy.sparse import csc_array, csc_matrix, eye_array

from lbskel import SolveError, UnknownChoice, factorize, laplacian
from lbskel.shapes import flat_grid, torus
from lbskel.solvers import ALL_SOLVERS, CLASSICAL_ITERATIONS, DIRECT_SOLVERS, SOLVERS, Factorization, relative_residual

every_solver = pytest.mark.parametrize("solver", DIRECT_SOLVERS)


@every_solver
@pytest.mark.parametrize("columns", [1, 3, 7])
def test_solutions_are_those_of_dense_numpy(solver, columns):
    A = shifted_laplacian(torus(1.0, 0.3, 14, 9))
    B = right_hand_sides(A.shape[0], columns)
    X = factorize(A, solver).solve(B)
    # condition 12.1 / 0.1, so that both solutions are good to some 100 roundings
    assert np.abs(X - np.linalg.solve(A.toarray(), B)).max() < 1e3 * EPSILON * np.abs(X).max()
    assert X.shape == B.shape


@every_solver
def test_solutions_by_hand(solver):
    A = csc_array([[4.0, 2.0], [2.0, 5.0]])
    assert factorize(A, solver).solve(np.array([[8.0, 4.0], [8.0, 2.0]])) == pytest.approx(np.array([[1.5, 1], [1, 0]]))
    assert factorize(csc_array([[4.0]]), solver).solve(np.array([[2.0]])) == pytest.approx(0.5)


@every_solver
def test_one_column_may_be_a_vector(solver):
    A = shifted_laplacian(flat_grid(6, 5))
    b = right_hand_sides(30, 1)
    vector = factorize(A, solver).solve(b[:, 0])
    assert vector.shape == (30,)
    assert (vector == factorize(A, solver).solve(b)[:, 0]).all()


@every_solver
def test_right_hand_sides_of_any_kind(solver):
    A = shifted_laplacian(flat_grid(6, 5))
    B = np.arange(90).reshape(30, 3)
    for other in (B, np.asfortranarray(B), B.astype(np.float32), np.arange(180.0).reshape(30, 6)[:, ::2] // 2):
        before = np.array(other)  # values to 90, condition 82: within 1e4 roundings
        assert np.abs(factorize(A, solver).solve(other) - np.linalg.solve(A.toarray(), before)).max() < 1e-10
        assert (other == before).all()


@every_solver
def test_the_matrix_stays_as_it_was(solver):
    A = shifted_laplacian(flat_grid(6, 5))
    before = A.copy()
    factorize(A, solver).solve(right_hand_sides(30))
    assert abs(A - before).max() == 0


@given(st.integers(1, 25), st.integers(0, 2**32 - 1), st.sampled_from(sorted(DIRECT_SOLVERS)))
def test_random_patterns(n, seed, solver):
    rng = np.random.default_rng(seed)
    G = csc_array(rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.2))
    A = (G @ G.T + eye_array(n)).tocsc()  # eigenvalues of 1 and more
    B = rng.normal(size=(n, 2))
    X = factorize(A, solver).solve(B)
    assert np.abs(A @ X - B).max() < 1e3 * EPSILON * np.abs(A).sum(axis=1).max() * max(np.abs(X).max(), 1)


@every_solver
def test_ordering_is_a_permutation(solver):
    n = 20 * 20
    first = factorize(shifted_laplacian(flat_grid(20, 20)), solver)
    assert np.sort(first.ordering).tolist() == list(range(n))
    again = factorize(shifted_laplacian(flat_grid(20, 20), 0.2), solver, like=first)
    assert np.sort(again.ordering).tolist() == list(range(n))


@every_solver
@pytest.mark.parametrize("other", DIRECT_SOLVERS)
def test_an_ordering_may_come_from_a_matrix_of_the_same_pattern_or_another(solver, other):
    first = factorize(shifted_laplacian(torus(1.0, 0.3, 20, 10)), other)
    B = right_hand_sides(200)
    for A in (
        shifted_laplacian(torus(1.0, 0.3, 20, 10), 0.3),  # the same pattern
        shifted_laplacian(torus(1.0, 0.3, 10, 20), 0.3),  # another
        eye_array(200, format="csc") * 2.0,  # almost no entry in common
    ):
        again = factorize(A, solver, like=first)
        assert again.residual(again.solve(B), B) < 1e2 * EPSILON  # as above: condition 120
        once_more = factorize(A, solver, like=again)
        assert once_more.residual(once_more.solve(B), B) < 1e2 * EPSILON


@every_solver
def test_ill_conditioned_systems_are_solved_backward_stably(solver):
    A, condition = ill_conditioned()
    B = A @ right_hand_sides(A.shape[0])
    factorization = factorize(A, solver)
    X = factorization.solve(B)
    assert condition > 1e12
    # Higham 2002, theorem 12.2: after one step the residual of each row is that of rounding its few terms
    terms = abs(A) @ np.abs(X) + np.abs(B)
    assert (np.abs(B - A @ X) <= 4 * EPSILON * terms).all()
    assert factorization.residual(X, B) < 1e-13
    again, residual = factorization.solve_with_residual(B)
    assert np.array_equal(again, X)
    assert residual == factorization.residual(X, B)


class Inexact(Factorization):
    """A solver that is wrong by one part in ten thousand."""

    def _factorize(self, A, like):
        self._inverse = np.linalg.inv(A.toarray())
        self.ordering = np.arange(A.shape[0])

    def _solve_unrefined(self, B):
        return 1.0001 * (self._inverse @ B)


def test_refinement_squares_the_error():
    A = shifted_laplacian(flat_grid(6, 5))
    B = right_hand_sides(30)
    solver = Inexact(A)
    assert solver.residual(solver._solve_unrefined(B), B) == pytest.approx(1e-4, rel=1e-3)
    assert solver.residual(solver.solve(B), B) == pytest.approx(1e-8, rel=1e-3)


def test_a_solution_with_a_large_residual_is_refused():
    class Useless(Inexact):
        def _solve_unrefined(self, B):
            return 0.5 * (self._inverse @ B)

    with pytest.raises(SolveError, match=r"a residual of 2\.5e-01.*singular to working accuracy") as caught:
        Useless(shifted_laplacian(flat_grid(6, 5))).solve(right_hand_sides(30))
    assert caught.value.residual == pytest.approx(0.25)


def test_residual():
    A = csc_array([[2.0, 0.0], [0.0, 4.0]])
    factorization = factorize(A)
    assert factorization.residual(np.array([[1.0], [1.0]]), np.array([[3.0], [4.0]])) == 0.25
    assert factorization.residual(np.zeros((2, 1)), np.zeros((2, 1))) == 0.0
    # of the worst column, relative to its own right-hand side
    assert factorization.residual(np.array([[1e9, 1.0], [1e9, 1.0]]), np.array([[2e9, 3.0], [4e9, 4.0]])) == 0.25


def not_positive_definite():
    S = laplacian(torus(1.0, 0.3, 20, 10), operator="graph").stiffness
    n = S.shape[0]
    return {
        "no entries": csc_array((4, 4)),
        "zero on the diagonal": csc_array([[0.0, 1.0], [1.0, 0.0]]),
        "row of zeros": csc_array([[1.0, 0.0], [0.0, 0.0]]),
        "all ones": csc_array(np.ones((3, 3))),
        "singular Laplacian": S,
        "indefinite of two rows": csc_array([[1.0, 2.0], [2.0, 1.0]]),
        "indefinite": (S - 2 * eye_array(n)).tocsc(),
        "negative definite": (-S - eye_array(n)).tocsc(),
    }


@every_solver
@pytest.mark.parametrize("name", not_positive_definite())
def test_what_is_not_positive_definite_is_refused(solver, name):
    A = not_positive_definite()[name]
    with pytest.raises(SolveError):
        factorize(A, solver).solve(right_hand_sides(A.shape[0]))


@every_solver
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(solver, value):
    A = shifted_laplacian(flat_grid(4, 4))
    B = right_hand_sides(16)
    B[5, 1] = value
    with pytest.raises(SolveError, match="solution is not finite"):
        factorize(A, solver).solve(B)
    A.data[7] = value
    with pytest.raises(SolveError, match="entries that are not finite"):
        factorize(A, solver)


@every_solver
def test_a_matrix_that_is_not_symmetric_is_solved_or_refused(solver):
    A = shifted_laplacian(flat_grid(6, 5)).tolil()
    A[3, 4] = A[8, 2] = 5.0
    A = A.tocsc()
    B = right_hand_sides(30)
    try:
        X = factorize(A, solver).solve(B)
    except SolveError:
        X = np.linalg.solve(A.toarray(), B)
    assert np.abs(A @ X - B).max() < 1e-10  # 1e5 roundings


@every_solver
def test_two_solutions_are_the_same_to_the_last_bit(solver):
    A = shifted_laplacian(torus(1.0, 0.3, 20, 10))
    B = right_hand_sides(200)
    assert factorize(A, solver).solve(B).tobytes() == factorize(A, solver).solve(B).tobytes()


def test_the_residual_is_that_of_the_right_hand_side_and_checked_after_refinement():
    """Wrong by a factor, a solution has a small residual against A X and a large one against B."""
    A = shifted_laplacian(flat_grid(6, 5))
    B = right_hand_sides(30)
    X = np.linalg.solve(A.toarray(), B)
    assert relative_residual(A, 2 * X, B) == pytest.approx(1)
    assert relative_residual(A, X, 4 * B) == pytest.approx(0.75)
    assert relative_residual(A, 0 * X, B) == 1


def test_tables_of_solvers():
    assert set(DIRECT_SOLVERS) < set(SOLVERS)
    assert not set(SOLVERS) & set(CLASSICAL_ITERATIONS)
    assert list(ALL_SOLVERS) == [*SOLVERS, *CLASSICAL_ITERATIONS]
    for name, kind in ALL_SOLVERS.items():
        assert type(factorize(eye_array(3, format="csc"), name)) is kind
    with pytest.raises(UnknownChoice, match="cholmod, superlu, cg_jacobi, cg_amg, richardson, jacobi"):
        factorize(eye_array(3, format="csc"), "magic")


def test_corrections_remove_the_error_that_refinement_would():
    A = shifted_laplacian(flat_grid(12, 10))
    B = right_hand_sides(120)
    factor = factorize(A)
    X = factor.solve(B, refined=False)
    X = X + factor.solve(B - A @ X, refined=False)
    assert (factor.solve(B) == X).all()
    with pytest.raises(SolveError, match="not finite"):
        factor.solve(np.full((120, 1), np.nan), refined=False)


@pytest.mark.parametrize("solver", ALL_SOLVERS)
def test_matrices_of_other_kinds_are_converted(solver):
    A, b = shifted_laplacian(flat_grid(4, 4), 4.0), right_hand_sides(16, 1)
    expected = factorize(A, solver).solve(b)
    for other in (A.tocoo(), A.tocsr(), csc_matrix(A), A.toarray()):
        assert factorize(other, solver).solve(b) == pytest.approx(expected, abs=1e-12)
    assert factorize(A.astype(np.float32), solver).solve(b) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("solver", ALL_SOLVERS)
@pytest.mark.parametrize(
    ("A", "B", "message"),
    [
        (np.eye(4)[:, :3], np.ones(4), "must be square, not 4 x 3; lstsq"),
        (1j * np.eye(4), np.ones(4), "the matrix is complex"),
        ("four", np.ones(4), "must be a sparse matrix of numbers"),
        (np.eye(4), np.ones(3), r"must have shape \(4, k\) or \(4,\), not \(3,\)"),
        (np.eye(4), np.ones((1, 4)), r"not \(1, 4\)"),
        (np.eye(4), 1.0, r"not \(\)"),
        (np.eye(4), 1j * np.ones(4), "right-hand side is complex"),
        (np.eye(4), ["a", "b", "c", "d"], "right-hand side must be an array of numbers"),
    ],
)
def test_what_is_no_system_is_refused(solver, A, B, message):
    with pytest.raises(SolveError, match=message):
        factorize(A, solver).solve(B)


@pytest.mark.parametrize("solver", ALL_SOLVERS)
@pytest.mark.parametrize("is_writeable", [True, False])
def test_the_matrix_of_the_caller_stays_as_it_is(solver, is_writeable):
    """Its entries are not sorted, and one is given in two parts."""
    data, rows, begins = np.array([-1.0, 1.0, 1.0, 2.0, -1.0]), np.array([1, 0, 0, 1, 0]), np.array([0, 3, 5])
    A = csc_array((data.copy(), rows.copy(), begins), shape=(2, 2))
    for array in (A.data, A.indices, A.indptr):
        array.flags.writeable = is_writeable
    assert factorize(A, solver).solve(np.array([1.0, 1.0])) == pytest.approx([1.0, 1.0], rel=1e-6)  # of iterations
    assert (A.data.tolist(), A.indices.tolist()) == (data.tolist(), rows.tolist())
