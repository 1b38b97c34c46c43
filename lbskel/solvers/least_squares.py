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
from scipy.sparse.linalg import LinearOperator, lsmr, lsqr, splu

from lbskel.errors import SolveError, choose
from lbskel.solvers import ALL_SOLVERS
from lbskel.solvers.factorization import MAX_RESIDUAL
from lbskel.solvers.iterative import MAX_ITERATIONS, TOLERANCE, Iterative, NormalMatrix, Observer
from lbskel.solvers.stationary import GaussSeidel

# Largest size of K as a dense matrix, in bytes. A guess; the factors take as much again, once or twice.
MAX_DENSE_BYTES = 1e9
ROUNDING = 1e-10  # entries of K^T B relative to |K|^T |B| that may be rounding alone, a hundred times over; a guess

Method = Callable[[csr_array, NDArray[np.float64], int, Observer], NDArray[np.float64]]


def _dense(driver: str) -> Method:
    """Make a method that calls LAPACK on the dense matrix."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        size = 8.0 * K.shape[0] * K.shape[1]
        if size > MAX_DENSE_BYTES:
            raise SolveError(
                f"a dense matrix of {K.shape[0]} x {K.shape[1]} takes {size / 1e9:.1f} GB and its factors more, "
                f"over the limit of {MAX_DENSE_BYTES / 1e9:g} GB; use a sparse method, 'cholmod' or 'augmented'"
            )
        X: NDArray[np.float64] = scipy.linalg.lstsq(K.toarray(), B, lapack_driver=driver, overwrite_a=True)[0]
        return X

    return solve


def _augmented(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
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


def _cgls(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
    """Iterate conjugate gradients on the normal equations, with the residual B - K X updated instead of theirs."""
    T = K.T.tocsr()
    X, R = np.zeros((K.shape[1], B.shape[1])), B
    S = T @ R
    P, squared_norm = S, float((S * S).sum())
    threshold = TOLERANCE**2 * squared_norm
    for number in range(1, iterations + 1):
        if not squared_norm > threshold:
            break
        Q = K @ P
        step = squared_norm / float((Q * Q).sum())
        X, R = X + step * P, R - step * Q
        S = T @ R
        previous, squared_norm = squared_norm, float((S * S).sum())
        P = S + squared_norm / previous * P
        observe(number, X)
    return X


def _scipy_krylov(method: Callable[..., Any], limit_name: str) -> Method:
    """Make a method of scipy's lsqr or lsmr.

    These have no callback: to observe the iterates 1, 2, 4, ... the method is run again from the start for each.
    """

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        T, k = K.T.tocsr(), B.shape[1]
        operator = LinearOperator(
            (K.shape[0] * k, K.shape[1] * k),
            matvec=lambda x: (K @ x.reshape(-1, k)).ravel(),
            rmatvec=lambda y: (T @ y.reshape(-1, k)).ravel(),
            dtype=np.float64,
        )
        number = iterations if observe is _no_observer else min(1, iterations)
        while True:
            result = method(operator, B.ravel(), atol=TOLERANCE, btol=TOLERANCE, conlim=0, **{limit_name: number})
            X: NDArray[np.float64] = result[0].reshape(-1, k)
            observe(min(number, result[2]), X)
            if number >= iterations or result[2] < number:
                return X
            number = min(2 * number, iterations)

    return solve


def _normal(solver: str) -> Method:
    """Make a method that applies a solver of symmetric systems to K^T K."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        kind = ALL_SOLVERS[solver]
        right = K.T @ B
        if not issubclass(kind, Iterative):
            return kind(csc_array(K.T @ K), None).solve(right)
        needs_entries = issubclass(kind, GaussSeidel) or solver == "cg_amg"
        iterative = kind(csc_array(K.T @ K) if needs_entries else NormalMatrix(K), None)
        return iterative.solve(right, on_iterate=observe, iterations=iterations)

    return solve


def _no_observer(number: int, X: NDArray[np.float64]) -> None:
    """Ignore an iterate."""


LEAST_SQUARES: dict[str, Method] = {
    "qr": _dense("gelsy"),
    "svd": _dense("gelsd"),
    "augmented": _augmented,
    **{solver: _normal(solver) for solver in ALL_SOLVERS},
    "cgls": _cgls,
    "lsqr": _scipy_krylov(lsqr, "iter_lim"),
    "lsmr": _scipy_krylov(lsmr, "maxiter"),
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
        If an entry is not finite, a dense matrix would be too large, the matrix of a direct method cannot be factorized
        since columns are dependent to working accuracy (``qr`` and ``svd`` return the solution of least norm), or, if
        ``iterations`` is not given, K^T (B - K X) is above a thousandth of K^T B after at most 2000 iterations.
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
    right = np.asarray(B, dtype=np.float64)
    columns = right.reshape(len(right), -1)
    shape = (K.shape[1], *right.shape[1:])
    initial = np.zeros((K.shape[1], columns.shape[1]))
    if start is not None:
        initial += np.asarray(start, dtype=np.float64).reshape(initial.shape)
    if not (np.isfinite(K.data).all() and np.isfinite(columns).all()):
        raise SolveError("the matrix or the right-hand side has entries that are not finite")
    observe = _no_observer
    if on_iterate is not None:

        def observe(number: int, X: NDArray[np.float64]) -> None:
            on_iterate(number, (initial + X).reshape(shape))

    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        X = initial + solve(K, columns - K @ initial, MAX_ITERATIONS if iterations is None else iterations, observe)
        if iterations is None:
            _require_zero_gradient(K, X, columns)
    return X.reshape(shape)


def _require_zero_gradient(K: csr_array, X: NDArray[np.float64], B: NDArray[np.float64]) -> None:
    """Raise a SolveError unless the gradient K^T (B - K X) is small relative to K^T B."""
    rounding = ROUNDING * (abs(K).T @ np.abs(B)).max(initial=0.0)
    scale = max(np.abs(K.T @ B).max(initial=0.0), rounding)
    gradient = np.abs(K.T @ (B - K @ X)).max(initial=0.0)
    residual = float(gradient / scale) if scale > 0 else float(gradient)
    if not residual <= MAX_RESIDUAL:
        raise SolveError(
            f"the gradient K^T (B - K X) is {residual:.1e} of K^T B where it should be zero; try 'cholmod'", residual
        )
