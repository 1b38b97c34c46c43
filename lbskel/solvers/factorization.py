"""The interface of all solvers: refined solutions for several right-hand sides, and the ordering that was used.

One step of iterative refinement in the working precision: Higham 2002, "Accuracy and stability of numerical
algorithms", chapter 12, https://doi.org/10.1137/1.9780898718027.
"""

from __future__ import annotations

__all__ = ["Factorization", "real_matrix", "real_rows", "relative_residual"]

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import SolveError

# Largest relative residual of a solution that is returned, no unit. A guess; residuals of well-posed systems stay below
# 1e-7.
MAX_RESIDUAL = 1e-3


def real_matrix(A: Any) -> csc_array:
    """Return a matrix of real numbers, sparse or dense, in compressed columns; a SolveError says what else it is.

    Parameters
    ----------
    A : (m, n) sparse array or matrix, or array_like
    """
    try:
        matrix = csc_array(A)
        if not matrix.has_canonical_format:  # sorting its entries would change those of the caller
            matrix = matrix.copy()
            matrix.sum_duplicates()
        real = matrix.astype(np.float64, copy=False) if matrix.dtype.kind != "c" else None
    except (TypeError, ValueError) as error:
        raise SolveError(f"the matrix must be a sparse matrix of numbers: {error}") from None
    if real is None:
        raise SolveError("the matrix is complex; the solvers take real ones")
    return real


def real_rows(B: Any, n: int, what: str = "right-hand side") -> NDArray[np.float64]:
    """Return real numbers in n rows, as floats of the same shape; a SolveError says what else there is.

    Parameters
    ----------
    B : (n, k) or (n,) array_like of float
    n : int
    what : str
        Its name in messages.
    """
    try:
        given = np.asarray(B)
        rows = given.astype(np.float64, copy=False) if given.dtype.kind != "c" else given
    except (TypeError, ValueError) as error:
        raise SolveError(f"the {what} must be an array of numbers: {error}") from None
    if rows.dtype.kind == "c":
        raise SolveError(f"the {what} is complex; solve for its real and imaginary parts, as columns of one array")
    if rows.ndim not in (1, 2) or len(rows) != n:
        raise SolveError(f"the {what} must have shape ({n}, k) or ({n},), not {rows.shape}")
    return rows


def relative_residual(A: csc_array, X: NDArray[np.float64], B: NDArray[np.float64]) -> float:
    """Compute the largest |B - A X| of a column relative to its largest |B|; columns with B = 0 are left out.

    Parameters
    ----------
    A : (n, n) csc_array
    X, B : (n, k) array of float
    """
    scales = np.abs(B).max(axis=0, initial=0.0)
    residuals = np.abs(B - A @ X).max(axis=0, initial=0.0)
    return float(np.divide(residuals, scales, out=np.zeros_like(scales), where=scales > 0).max(initial=0.0))


class Factorization(ABC):
    """A factorized symmetric positive definite matrix.

    Parameters
    ----------
    A : (n, n) csc_array
        Both triangles given.
    like : Factorization, optional
        A factorization whose ordering may be used again.

    Raises
    ------
    SolveError
        If A has entries that are not finite, or cannot be factorized.

    Attributes
    ----------
    ordering : (n,) array of int
        The fill-reducing permutation, which may be used again for other matrices of the same size.
    """

    ordering: NDArray[np.int64]

    def __init__(self, A: csc_array, like: Factorization | None = None):
        if not np.isfinite(A.data).all():
            raise SolveError("the matrix has entries that are not finite")
        self._matrix = A
        self._factorize(A, like)

    @abstractmethod
    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        """Factorize the matrix and set ``ordering``."""

    @abstractmethod
    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve for (n, k) right-hand sides without refinement."""

    def solve(self, B: NDArray[np.float64], *, refined: bool = True) -> NDArray[np.float64]:
        """Solve A X = B, by default with one step of iterative refinement.

        Parameters
        ----------
        B : (n, k) or (n,) array of float
        refined : bool
            Whether to refine, which takes a second solution. Refinement is not needed for right-hand sides that are
            themselves approximate, as in an outer iteration, nor for well-conditioned matrices.

        Returns
        -------
        array of float, of the shape of B

        Raises
        ------
        SolveError
            If B has another number of rows or is complex, or the result is not finite or its residual is large: A is
            singular to working accuracy, or not symmetric.
        """
        return self.solve_with_residual(B, refined=refined)[0]

    def solve_with_residual(self, B: NDArray[np.float64], *, refined: bool = True) -> tuple[NDArray[np.float64], float]:
        """Solve A X = B as :meth:`solve` does, and return the residual too, as :meth:`residual` computes it.

        Parameters
        ----------
        B, refined
            As for :meth:`solve`.
        """
        n = self._matrix.shape[0]
        columns = real_rows(B, n).reshape(n, -1)
        X = self._solve_unrefined(columns)
        if refined:
            X = X + self._solve_unrefined(columns - self._matrix @ X)
        if not np.isfinite(X).all():
            raise SolveError("the solution is not finite")
        residual = self.residual(X, columns)
        if residual > MAX_RESIDUAL:
            raise SolveError(
                f"the solution leaves a residual of {residual:.1e}: the matrix is singular to working accuracy, "
                "or it is not symmetric",
                residual,
            )
        return X.reshape(np.shape(B)), residual

    def residual(self, X: NDArray[np.float64], B: NDArray[np.float64]) -> float:
        """Compute the largest |B - A X| of a column relative to its largest |B|, both (n, k) arrays."""
        return relative_residual(self._matrix, X, B)
