"""The classical iterations, against their formulas."""

import numpy as np
import pytest
from linear_systems import rectangular, right_hand_side
from scipy.sparse import csc_array, csr_array, diags_array, eye_array, vstack

from lbskel import SolveError, factorize, laplacian
from lbskel.shapes import torus
from lbskel.solvers import CLASSICAL_ITERATIONS, SOLVERS
from lbskel.solvers.least_squares import lstsq


def test_richardsons_iterates_are_landwebers():
    K = rectangular()
    B = right_hand_side(K)
    iterates = []
    lstsq(K, B, "richardson", iterations=3, on_iterate=lambda number, X: iterates.append(X))
    factor = (iterates[0] / (K.T @ B)).mean()
    assert 0 < factor < 2 / np.linalg.norm(K.toarray(), 2) ** 2
    X = np.zeros_like(iterates[0])
    for iterate in iterates:
        X = X + factor * (K.T @ (B - K @ X))
        assert iterate == pytest.approx(X, abs=1e-12)


def test_gauss_seidel_solves_for_one_column_after_the_other():
    K = rectangular()
    B = right_hand_side(K, 1)
    dense, X, R = K.toarray(), np.zeros((K.shape[1], 1)), np.array(B)
    for j in range(K.shape[1]):
        step = dense[:, j] @ R / (dense[:, j] @ dense[:, j])
        X[j] += step
        R -= dense[:, [j]] * step
    assert lstsq(K, B, "gauss_seidel", iterations=1) == pytest.approx(X, abs=1e-12)


@pytest.mark.parametrize("method", ["richardson", "jacobi", "gauss_seidel", "sor", "chebyshev"])
def test_slow_convergence_is_an_error_unless_a_number_of_iterations_is_given(method):
    mesh = torus(1.0, 0.1, 300, 4)
    L = laplacian(mesh, operator="graph").stiffness  # from a thousandth to ten, the constants aside
    K, V = csr_array(vstack([1e5 * L, eye_array(L.shape[0])])), mesh.vertices  # smooth: what these change last
    B = np.concatenate([np.zeros_like(V), V])
    with pytest.raises(SolveError, match="cholmod") as caught:
        lstsq(K, B, method)
    assert caught.value.residual > 1e-3
    partial = lstsq(K, B, method, iterations=20)
    assert 0 < np.linalg.norm(K @ partial - B) < np.linalg.norm(B)


def small_system():
    """A positive definite matrix of three rows, and two right-hand sides."""
    return csc_array([[4.0, -1.0, 0.5], [-1.0, 3.0, 1.0], [0.5, 1.0, 2.0]]), np.array(
        [[1.0, 2.0], [0.0, -1.0], [3.0, 1.0]]
    )


@pytest.mark.parametrize(("solver", "w"), [("gauss_seidel", 1.0), ("sor", 1.5)])
def test_relaxed_sweeps_move_each_unknown_w_times_as_far(solver, w):
    A, B = small_system()
    dense, X = A.toarray(), np.zeros_like(B)
    iterates = []
    factorize(A, solver).solve(B, iterations=3, on_iterate=lambda number, X: iterates.append(X))
    for iterate in iterates:
        for i in range(3):
            X[i] += w * (B[i] - dense[i] @ X) / dense[i, i]
        assert iterate == pytest.approx(X, abs=1e-14)


@pytest.mark.parametrize("solver", ["richardson", "jacobi"])
def test_richardson_and_jacobi_take_the_optimal_factor_for_their_bounds(solver):
    A, B = small_system()
    D = A.diagonal()[:, None] if solver == "jacobi" else np.ones((3, 1))
    scaled = A.toarray() / np.sqrt(D) / np.sqrt(D.T)
    bound, smallest = np.abs(scaled).sum(axis=1).max(), np.linalg.eigvalsh(scaled)[0]
    iterates = []
    factorize(A, solver).solve(B, iterations=3, on_iterate=lambda number, X: iterates.append(X))
    X = np.zeros_like(B)
    for iterate in iterates:
        # Lanczos's method in as many steps as there are rows is exact; Gershgorin's bound is that of scaled rows
        X = X + 2 / (bound + smallest) * (B - A @ X) / D
        assert iterate == pytest.approx(X, rel=1e-6)


def test_chebyshev_residuals_are_chebyshev_polynomials():
    """After k iterations each eigencomponent of the residual is T_k((c - lambda) / h) / T_k(c / h)."""
    n = 12
    A = csc_array(diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1]) / 2)
    values, vectors = np.linalg.eigh(A.toarray())
    low, high = values[0], 2.0  # Lanczos's estimate is exact here, Gershgorin's bound is 2
    center, half = (high + low) / 2, (high - low) / 2
    b = vectors @ np.ones(n)
    residuals = []
    factorize(A, "chebyshev").solve(b, iterations=6, on_iterate=lambda number, x: residuals.append(b - A @ x))
    for k, residual in enumerate(residuals, start=1):
        T = np.polynomial.chebyshev.Chebyshev.basis(k)
        assert vectors.T @ residual == pytest.approx(T((center - values) / half) / T(center / half), abs=1e-9)


def test_classical_iterations_solve_and_are_not_among_the_solvers_for_use():
    A, B = small_system()
    for solver in CLASSICAL_ITERATIONS:
        assert factorize(A, solver).solve(B) == pytest.approx(np.linalg.solve(A.toarray(), B), abs=1e-8)
        assert solver not in SOLVERS
