"""Least squares, min ||K X - B||, of a rectangular sparse matrix: dense, augmented, by normal equations, iterative.

Every solver of symmetric systems can solve the normal equations K^T K X = K^T B; K^T K is not formed for iterative ones
that need only products with it. The condition number that matters is that of K for the errors of qr, svd and augmented
and for the convergence of cgls, lsqr and lsmr, and its square for the errors of the normal equations. Bjoerck 1996,
"Numerical methods for least squares problems", https://doi.org/10.1137/1.9781611971484; Paige, Saunders 1982,
https://doi.org/10.1145/355984.355989; Fong, Saunders 2011, https://doi.org/10.1137/10079687X.
"""

from __future__ import annotations

__all__ = ["LEAST_SQUARES", "MAX_DENSE_BYTES", "lstsq"]

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import block_array, csc_array, csr_array, eye_array
from scipy.sparse.linalg import lsmr, lsqr, splu

from lbskel.errors import SolveError, choose
from lbskel.solvers import ALL_SOLVERS
from lbskel.solvers.factorization import MAX_RESIDUAL, real_matrix, real_rows
from lbskel.solvers.iterative import (
    MAX_ITERATIONS,
    TOLERANCE,
    Iterative,
    NormalMatrix,
    Observer,
    column_dot,
    ratios,
)
from lbskel.solvers.stationary import GaussSeidel

# Largest size of K as a dense matrix, in bytes. A guess; the factors take as much again, once or twice.
MAX_DENSE_BYTES = 1e9
ROUNDING = 1e-10  # entries of K^T B relative to |K|^T |B| that may be rounding alone, a hundred times over; a guess
SLACK = 10.0  # gradient of an accepted solution over that at which iterations stop, which rounding may change; a guess

Method = Callable[[csr_array, NDArray[np.float64], int | None, Observer], NDArray[np.float64]]


def _dense(driver: str) -> Method:
    """Make a method that calls LAPACK on the dense matrix."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int | None, observe: Observer) -> NDArray[np.float64]:
        size = 8.0 * K.shape[0] * K.shape[1]
        if size > MAX_DENSE_BYTES:
            raise SolveError(
                f"a dense matrix of {K.shape[0]} x {K.shape[1]} takes {size / 1e9:.1f} GB and its factors more, "
                f"over the limit of {MAX_DENSE_BYTES / 1e9:g} GB; use a sparse method, 'cholmod' or 'augmented'"
            )
        X: NDArray[np.float64] = scipy.linalg.lstsq(K.toarray(), B, lapack_driver=driver, overwrite_a=True)[0]
        return X

    return solve


def _augmented(K: csr_array, B: NDArray[np.float64], iterations: int | None, observe: Observer) -> NDArray[np.float64]:
    """Solve [I K; K^T 0] [R; X] = [B; 0] by sparse LU, refined once: the condition is not squared."""
    m, n = K.shape
    A = csc_array(block_array([[eye_array(m), K], [K.T, None]]))
    right = np.concatenate([B, np.zeros((n, B.shape[1]))])
    try:
        factor = splu(A)
    except RuntimeError as error:
        raise SolveError(f"the matrix cannot be factorized: {error}") from None
    solution: NDArray[np.float64] = factor.solve(right)
    solution += factor.solve(right - A @ solution)
    return solution[m:]


def _gradient_bound(K: csr_array, B: NDArray[np.float64]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Make the function from X to the (n, k) size at which K^T (B - K X) counts as zero, row by row, as in A X = B."""
    T = abs(K).T.tocsr()
    row_sums, right = T @ abs(K).sum(axis=1)[:, None], T @ np.abs(B)
    return lambda X: TOLERANCE * (row_sums * np.abs(X).max(axis=0, initial=0.0) + right)


def _cgls(K: csr_array, B: NDArray[np.float64], iterations: int | None, observe: Observer) -> NDArray[np.float64]:
    """Iterate conjugate gradients on the normal equations, with the residual B - K X updated instead of theirs."""
    T, bound = K.T.tocsr(), _gradient_bound(K, B)
    X, R = np.zeros((K.shape[1], B.shape[1])), B
    P = S = T @ R
    squared_norms = column_dot(S, S)
    for number in range(1, _limit(iterations) + 1):
        if not (np.abs(S) > bound(X)).any():
            break
        Q = K @ P
        steps = ratios(squared_norms, column_dot(Q, Q))
        X, R = X + steps * P, R - steps * Q
        S = T @ R
        previous, squared_norms = squared_norms, column_dot(S, S)
        P = S + ratios(squared_norms, previous) * P
        observe(number, X)
    return X


def _scipy_krylov(method: Callable[..., Any], limit_name: str) -> Method:
    """Make a method of scipy's lsqr or lsmr, which run until rounding ends the convergence of each column.

    These have no callback: to observe the iterates 1, 2, 4, ... the method is run again from the start for each.
    """

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int | None, observe: Observer) -> NDArray[np.float64]:
        limit = _limit(iterations)
        number = limit if observe is _no_observer else min(1, limit)
        while True:
            results = [method(K, b, atol=0, btol=0, conlim=0, **{limit_name: number}) for b in B.T]
            X = np.array([result[0] for result in results]).reshape(-1, K.shape[1]).T
            last = max((result[2] for result in results), default=0)
            observe(min(number, last), X)
            if number >= limit or last < number:
                return X
            number = min(2 * number, limit)

    return solve


def _normal(solver: str) -> Method:
    """Make a method that applies a solver of symmetric systems to K^T K."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int | None, observe: Observer) -> NDArray[np.float64]:
        kind = ALL_SOLVERS[solver]
        right = K.T @ B
        if not issubclass(kind, Iterative):
            return kind(csc_array(K.T @ K), None).solve(right)
        needs_entries = issubclass(kind, GaussSeidel) or solver == "cg_amg"
        iterative = kind(csc_array(K.T @ K) if needs_entries else NormalMatrix(K), None)
        return iterative.solve(right, on_iterate=observe, iterations=iterations)

    return solve


def _limit(iterations: int | None) -> int:
    return MAX_ITERATIONS if iterations is None else iterations


def _no_observer(number: int, X: NDArray[np.float64]) -> None:
    """Ignore an iterate."""


KRYLOV: dict[str, Method] = {
    "cgls": _cgls,
    "lsqr": _scipy_krylov(lsqr, "iter_lim"),
    "lsmr": _scipy_krylov(lsmr, "maxiter"),
}

LEAST_SQUARES: dict[str, Method] = {
    "qr": _dense("gelsy"),
    "svd": _dense("gelsd"),
    "augmented": _augmented,
    **{solver: _normal(solver) for solver in ALL_SOLVERS},
    **KRYLOV,
}


def lstsq(
    K: csr_array,
    B: ArrayLike,
    method: str = "cholmod",
    *,
    start: ArrayLike | None = None,
    on_iterate: Observer | None = None,
    iterations: int | None = None,
) -> NDArray[np.float64]:
    """Solve min ||K X - B|| for a matrix with independent columns.

    Parameters
    ----------
    K : (m, n) csr_array
    B : (m, k) or (m,) array_like of float
    method : str
        A name in LEAST_SQUARES.
    start : (n, k) or (n,) array_like of float, optional
        Initial guess of the iterative methods; zero by default.
    on_iterate : callable, optional
        Called by the iterative methods with the number of each iterate, from 1, and its value; for ``lsqr`` and
        ``lsmr`` only with those numbered 1, 2, 4 and so on.
    iterations : int, optional
        Limit on the number of iterations. If it is given, the last iterate is returned whatever its residual.

    Returns
    -------
    (n, k) or (n,) array of float

    Raises
    ------
    UnknownChoice
        If no method has that name.
    SolveError
        If an entry is complex or not finite, B has another number of rows, a dense matrix would be too large, the
        matrix of a direct method cannot be factorized since columns are dependent to working accuracy (``qr`` and
        ``svd`` return the solution of least norm), or, if ``iterations`` is not given, K^T (B - K X) is above a
        thousandth of K^T B in a column, or iterations have not converged after 2000 (:mod:`lbskel.solvers.iterative`).
    MissingDependency
        If the method is ``cg_amg`` and pyamg is not installed.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> line = csr_array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
    >>> lstsq(line, [1.0, 3.0, 5.0], "qr").round(12)
    array([1., 2.])
    """
    solve = choose(LEAST_SQUARES, method, "least-squares method")
    K = csr_array(real_matrix(K))
    right = real_rows(B, K.shape[0])
    columns = right.reshape(len(right), -1)
    shape = (K.shape[1], *right.shape[1:])
    initial = np.zeros((K.shape[1], columns.shape[1]))
    if start is not None:
        initial += real_rows(start, K.shape[1], "start").reshape(initial.shape)
    if not (np.isfinite(K.data).all() and np.isfinite(columns).all()):
        raise SolveError("the matrix or the right-hand side has entries that are not finite")
    observe = _no_observer
    if on_iterate is not None:

        def observe(number: int, X: NDArray[np.float64]) -> None:
            on_iterate(number, (initial + X).reshape(shape))

    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        X = initial + solve(K, columns - K @ initial, iterations, observe)
        if iterations is None:
            _require_zero_gradient(K, X, columns, in_each_row=method in KRYLOV)
    return X.reshape(shape)


def _require_zero_gradient(
    K: csr_array, X: NDArray[np.float64], B: NDArray[np.float64], *, in_each_row: bool = False
) -> None:
    """Raise a SolveError unless the gradient K^T (B - K X) of each column is small relative to its K^T B.

    ``in_each_row`` asks that each row be small, as in an iterative solver of A X = B.
    """
    rounding = ROUNDING * (abs(K).T @ np.abs(B)).max(axis=0, initial=0.0)
    scales = np.maximum(np.abs(K.T @ B).max(axis=0, initial=0.0), rounding)
    gradient = np.abs(K.T @ (B - K @ X))
    largest = gradient.max(axis=0, initial=0.0)
    residual = float(np.divide(largest, scales, out=largest, where=scales > 0).max(initial=0.0))
    if not residual <= MAX_RESIDUAL or (in_each_row and (gradient > SLACK * _gradient_bound(K, B)(X)).any()):
        raise SolveError(
            f"the gradient K^T (B - K X) is {residual:.1e} of K^T B where it should be zero; try 'cholmod'", residual
        )
