"""What every solver gives: a solve for several right-hand sides, once refined, and the ordering that it used.

One step of iterative refinement in the working precision: Higham 2002, "Accuracy and stability of numerical
algorithms", chapter 12, https://doi.org/10.1137/1.9780898718027.
"""

from __future__ import annotations

__all__ = ["Factorization", "relative_residual"]

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import SolveError

LARGEST_RESIDUAL = 1e-3  # above which a solution is of no use; sound systems stay below 1e-7


def relative_residual(A: csc_array, X: NDArray[np.float64], B: NDArray[np.float64]) -> float:
    """Largest |B - A X| relative to the largest |B|."""
    scale = np.abs(B).max(initial=0.0)
    return float(np.abs(B - A @ X).max(initial=0.0) / scale) if scale > 0 else 0.0


class Factorization(ABC):
    """A factorized symmetric positive definite matrix.

    Attributes
    ----------
    ordering : (n,) array of int
        The fill-reducing permutation, which serves other matrices of the same size.
    """

    ordering: NDArray[np.int64]

    def __init__(self, A: csc_array, like: Factorization | None = None):
        if not np.isfinite(A.data).all():
            raise SolveError("the matrix has entries that are not finite")
        self._matrix = A
        self._factorize(A, like)

    @abstractmethod
    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        """Factor the matrix and set ``ordering``."""

    @abstractmethod
    def _solve_once(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        """One pair of triangular solves."""

    def solve(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        """X with A X = B, refined once against its own residual.

        Parameters
        ----------
        B : (n, k) or (n,) array of float

        Raises
        ------
        SolveError
            If the result is not finite or solves nothing: the matrix is singular to working accuracy or not symmetric.
        """
        columns = np.asarray(B, dtype=np.float64).reshape(len(B), -1)
        X = self._solve_once(columns)
        X = X + self._solve_once(columns - self._matrix @ X)
        if not np.isfinite(X).all():
            raise SolveError("the solution is not finite")
        residual = self.residual(X, columns)
        if residual > LARGEST_RESIDUAL:
            raise SolveError(
                f"the solution leaves a residual of {residual:.1e}: the matrix is singular to working accuracy, "
                "or it is not symmetric",
                residual,
            )
        return X.reshape(np.shape(B))

    def residual(self, X: NDArray[np.float64], B: NDArray[np.float64]) -> float:
        """Largest |B - A X| relative to the largest |B|."""
        return relative_residual(self._matrix, X, B)
