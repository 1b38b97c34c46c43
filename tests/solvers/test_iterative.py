"""Iterative solvers: solutions, what is refused, normal matrices that are not formed, eigenvalue bounds."""

import numpy as np
import pytest
from linear_systems import rectangular, right_hand_side, right_hand_sides, shifted_laplacian
from scipy.sparse import csc_array, diags_array, eye_array

from lbskel import SolveError, factorize, laplacian
from lbskel.shapes import torus
from lbskel.solvers import ALL_SOLVERS, DIRECT_SOLVERS, iterative
from lbskel.solvers.iterative import NormalMatrix, eigenvalue_upper_bound, estimate_smallest_eigenvalue


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_iterative_solvers_of_symmetric_systems(solver):
    S = laplacian(torus(1.0, 0.3, 14, 9), operator="graph").stiffness
    A = csc_array(S + eye_array(S.shape[0]))
    B = np.random.default_rng(1).normal(size=(A.shape[0], 3))
    seen = []
    factorization = factorize(A, solver)
    X = factorization.solve(B, on_iterate=lambda number, X: seen.append(number))
    assert np.abs(X - np.linalg.solve(A.toarray(), B)).max() < 1e-8  # as above
    assert seen == list(range(1, len(seen) + 1))
    assert factorization.solve(B[:, 0]) == pytest.approx(X[:, 0], abs=1e-8)
    assert factorization.residual(factorization.solve(B, start=X), B) < 1e-9


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_iterative_solvers_refuse_what_is_not_positive_definite(solver):
    with pytest.raises(SolveError, match="not positive definite"):
        factorize(csc_array([[0.0, 1.0], [1.0, 0.0]]), solver)


def test_a_normal_matrix_has_the_products_of_the_formed_matrix():
    K = rectangular(0.7)
    dense = (K.T @ K).toarray()
    normal = NormalMatrix(K)
    X = right_hand_side(K)[: K.shape[1]]
    assert normal @ X == pytest.approx(dense @ X)
    assert normal.diagonal() == pytest.approx(np.diag(dense))
    ones = np.ones(K.shape[1])
    eigenvalues = np.linalg.eigvalsh(dense)
    assert eigenvalue_upper_bound(normal, ones) >= eigenvalues[-1]
    assert eigenvalues[0] <= estimate_smallest_eigenvalue(normal, ones) < 2 * eigenvalues[0] + 0.05 * eigenvalues[-1]


def test_eigenvalue_bounds_of_a_chain():
    """The chain of second differences has the eigenvalues 2 - 2 cos(k pi / (n + 1))."""
    n = 20
    A = diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1]).tocsc()
    exact = 2 - 2 * np.cos(np.arange(1, n + 1) * np.pi / (n + 1))
    ones, half = np.ones(n), np.full(n, 0.5)
    assert eigenvalue_upper_bound(A, ones) == 4  # Gershgorin
    assert eigenvalue_upper_bound(A, half) == 1
    # as many Lanczos steps as rows: exact up to rounding
    assert estimate_smallest_eigenvalue(A, ones) == pytest.approx(exact[0])
    assert estimate_smallest_eigenvalue(A, half) == pytest.approx(exact[0] / 4)


def test_too_few_iterations_are_an_error_only_where_none_were_asked_for():
    n = 3000
    A = (diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])).tocsc()
    b = np.ones(n)
    with pytest.raises(
        SolveError, match=r"2000 iterations leave a row-wise backward error of \d.*e-\d+, above 1e-14: use a direct"
    ):
        factorize(A, "gauss_seidel").solve(b)
    assert np.isfinite(factorize(A, "gauss_seidel").solve(b, iterations=3)).all()


def solution_or_none(A, X, solver):
    """The solution of A Y = A X, None if it is refused."""
    try:
        return factorize(A, solver).solve(A @ X)
    except SolveError:
        return None


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_rows_of_large_numbers_hide_no_error_of_others(solver):
    """Penalties of three vertices: by the norm of B alone, any solution with these in place would do."""
    mesh = torus(1.0, 0.3, 28, 18)
    S = laplacian(mesh).stiffness
    penalties = np.zeros(S.shape[0])
    penalties[[0, 100, 300]] = 1e8
    found = solution_or_none((S @ S + diags_array(penalties)).tocsc(), mesh.vertices, solver)
    # the condition of S^2 with three fixed rows is about 1e5
    assert found == pytest.approx(mesh.vertices, abs=1e-8) if solver.startswith("cg") else found is None


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_a_column_of_large_numbers_hides_no_error_of_others(solver):
    A = shifted_laplacian(torus(1.0, 0.3, 14, 9), 1.0)
    X = np.column_stack([np.full(126, 1e11), right_hand_sides(126, 1)])
    found = solution_or_none(A, X, solver)
    assert found is not None
    assert found[:, 1] == pytest.approx(X[:, 1], abs=1e-12)  # the condition is 13


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_a_residual_that_is_small_but_still_falls_is_an_error(solver, monkeypatch):
    monkeypatch.setattr(iterative, "MAX_ITERATIONS", 3 if solver == "cg_amg" else 12)
    A, B = shifted_laplacian(torus(1.0, 0.3, 14, 9), 10.0), right_hand_sides(126)
    with pytest.raises(SolveError, match=r"(3|12) iterations leave a row-wise backward error of") as caught:
        factorize(A, solver).solve(B)
    assert caught.value.residual < 1e-3
    assert float(str(caught.value).split(" error of ")[1].split(",")[0]) > 1e-14


def test_iterations_go_on_from_the_true_residual_where_the_one_carried_along_is_smaller():
    class Hopeful(ALL_SOLVERS["cg_jacobi"]):
        def _iterates(self, X, R):
            yield from ((Y, 0 * residual) for Y, residual in super()._iterates(X, R))

    A, B = shifted_laplacian(torus(1.0, 0.3, 14, 9), 10.0), right_hand_sides(126)
    assert Hopeful(A).solve(B) == pytest.approx(np.linalg.solve(A.toarray(), B), abs=1e-12)


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_iterations_begin_at_the_start_and_observe_whole_iterates(solver):
    A, B = shifted_laplacian(torus(1.0, 0.3, 14, 9), 1.0), right_hand_sides(126)
    exact = np.linalg.solve(A.toarray(), B)
    start = exact + 1e-3 * right_hand_sides(126)
    seen = []
    found = factorize(A, solver).solve(B, start=start, iterations=2, on_iterate=lambda number, X: seen.append(X))
    assert seen[-1] == pytest.approx(found, abs=1e-12)
    # zero is 0.5 away, the start 4e-3, and no iteration goes farther away
    assert max(np.abs(X - exact).max() for X in seen) < 0.02
    assert factorize(A, solver).solve(B, start=exact, iterations=1) == pytest.approx(exact, abs=1e-12)
