"""Least squares, min ||K X - B||, of a rectangular sparse matrix: dense, augmented, by normal equations, iterative.

Every solver of symmetric systems serves for the normal equations K^T K X = K^T B; the iterative ones that need products
only get them without K^T K being formed. Condition numbers: those of K for qr, svd, augmented, cgls, lsqr and lsmr in
exact arithmetic, and their squares for the normal equations. Bjoerck 1996, "Numerical methods for least squares
problems", https://doi.org/10.1137/1.9781611971484; Paige, Saunders 1982, https://doi.org/10.1145/355984.355989; Fong,
Saunders 2011, https://doi.org/10.1137/10079687X.
"""

from __future__ import annotations

__all__ = ["LARGEST_DENSE", "LEAST_SQUARES", "lstsq"]

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import block_array, csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, lsmr, lsqr, splu

from lbskel.errors import SolveError, choose
from lbskel.solvers import SOLVERS
from lbskel.solvers.factorization import LARGEST_RESIDUAL
from lbskel.solvers.iterative import MOST_ITERATIONS, TOLERANCE, Iterative, NormalMatrix, Observer
from lbskel.solvers.stationary import GaussSeidel

LARGEST_DENSE = 1e9  # bytes of K as a dense matrix; the factors take as much again, once or twice

Method = Callable[[csr_array, NDArray[np.float64], int, Observer], NDArray[np.float64]]


def _dense(driver: str) -> Method:
    """LAPACK on the matrix with all its zeros."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        size = 8.0 * K.shape[0] * K.shape[1]
        if size > LARGEST_DENSE:
            raise SolveError(
                f"a dense matrix of {K.shape[0]} x {K.shape[1]} takes {size / 1e9:.1f} GB and its factors more, "
                f"over the limit of {LARGEST_DENSE / 1e9:g} GB; use a sparse method, 'cholmod' or 'augmented'"
            )
        return scipy.linalg.lstsq(K.toarray(), B, lapack_driver=driver, overwrite_a=True)[0]

    return solve


def _augmented(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
    """[I K; K^T 0] [R; X] = [B; 0] by sparse elimination, refined once: nothing is squared."""
    m, n = K.shape
    A = csc_array(block_array([[eye_array(m), K], [K.T, None]]))
    both = np.concatenate([B, np.zeros((n, B.shape[1]))])
    try:
        factor = splu(A)
    except RuntimeError as error:
        raise SolveError(f"the matrix cannot be factorized: {error}") from None
    solution = factor.solve(both)
    solution += factor.solve(both - A @ solution)
    return solution[m:]


def _cgls(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
    """Conjugate gradients on the normal equations, with the residual of K kept instead of theirs."""
    T = K.T.tocsr()
    X, R = np.zeros((K.shape[1], B.shape[1])), B
    S = T @ R
    P, size = S, float((S * S).sum())
    enough = TOLERANCE**2 * size
    for number in range(1, iterations + 1):
        if not size > enough:
            break
        Q = K @ P
        step = size / float((Q * Q).sum())
        X, R = X + step * P, R - step * Q
        S = T @ R
        before, size = size, float((S * S).sum())
        P = S + size / before * P
        observe(number, X)
    return X


def _scipys(method: Callable[..., Any], most: str) -> Method:
    """scipy's lsqr or lsmr, which show no iterates: looked at after 1, 2, 4, ... each from the start."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        T, k = K.T.tocsr(), B.shape[1]
        operator = LinearOperator(
            (K.shape[0] * k, K.shape[1] * k),
            matvec=lambda x: (K @ x.reshape(-1, k)).ravel(),
            rmatvec=lambda y: (T @ y.reshape(-1, k)).ravel(),
            dtype=np.float64,
        )
        number = 1 if observe is not _unobserved else iterations
        while True:
            result = method(operator, B.ravel(), atol=TOLERANCE, btol=TOLERANCE, conlim=0, **{most: number})
            X = result[0].reshape(-1, k)
            observe(min(number, result[2]), X)
            if number >= iterations or result[2] < number:
                return X
            number = min(2 * number, iterations)

    return solve


def _normal(solver: str) -> Method:
    """A solver of symmetric systems on K^T K."""

    def solve(K: csr_array, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        kind = SOLVERS[solver]
        right = K.T @ B
        if not issubclass(kind, Iterative):
            return kind(csc_array(K.T @ K), None).solve(right)
        needs_entries = issubclass(kind, GaussSeidel) or solver == "cg_amg"
        iterative = kind(csc_array(K.T @ K) if needs_entries else NormalMatrix(K), None)
        return iterative.solve(right, on_iterate=observe, iterations=iterations)

    return solve


def _unobserved(number: int, X: NDArray[np.float64]) -> None:
    """Nobody looks."""


LEAST_SQUARES: dict[str, Method] = {
    "qr": _dense("gelsy"),
    "svd": _dense("gelsd"),
    "augmented": _augmented,
    **{solver: _normal(solver) for solver in SOLVERS},
    "cgls": _cgls,
    "lsqr": _scipys(lsqr, "iter_lim"),
    "lsmr": _scipys(lsmr, "maxiter"),
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
    """X that makes ||K X - B|| smallest, for a matrix whose columns are independent.

    Parameters
    ----------
    K : (m, n) csr_array
    B : (m, k) or (m,) array_like of float
    method : str
        A name in LEAST_SQUARES.
    start : (n, k) or (n,) array_like of float, optional
        Where the iterative methods begin; zero by default.
    on_iterate : callable, optional
        Called with the number of each iterate, from 1, and its value, by the iterative methods; of ``lsqr`` and
        ``lsmr`` with those numbered 1, 2, 4 and so on.
    iterations : int, optional
        No more than these, and what they give is returned, however good.

    Raises
    ------
    UnknownChoice
        If no method has that name.
    SolveError
        If the columns are dependent to working accuracy, a dense matrix would be too large, or, where ``iterations``
        is not given, 2000 do not bring K^T (B - K X) down to a thousandth.

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
    first = np.zeros((K.shape[1], columns.shape[1]))
    if start is not None:
        first += np.asarray(start, dtype=np.float64).reshape(first.shape)
    if not (np.isfinite(K.data).all() and np.isfinite(columns).all()):
        raise SolveError("the matrix or the right-hand side has entries that are not finite")
    observe = _unobserved
    if on_iterate is not None:

        def observe(number: int, X: NDArray[np.float64]) -> None:
            on_iterate(number, (first + X).reshape(shape))

    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        X = first + solve(K, columns - K @ first, MOST_ITERATIONS if iterations is None else iterations, observe)
        if iterations is None:
            _require_a_solution(K, X, columns)
    return X.reshape(shape)


def _require_a_solution(K: csr_array, X: NDArray[np.float64], B: NDArray[np.float64]) -> None:
    """The gradient must vanish, relative to that at zero."""
    scale = np.abs(K.T @ B).max(initial=0.0)
    gradient = np.abs(K.T @ (B - K @ X)).max(initial=0.0)
    residual = float(gradient / scale) if scale > 0 else float(gradient)
    if not residual <= LARGEST_RESIDUAL:
        raise SolveError(f"K^T (B - K X) is not zero but {residual:.1e} of K^T B: no use; try 'cholmod'", residual)
