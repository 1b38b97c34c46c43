"""The classical iterations for A x = b, for study; with A = K^T K they solve least-squares problems.

With R = B - A X: Richardson (Landweber) X + w R; Jacobi X + w D^-1 R; Gauss-Seidel and successive overrelaxation
X + (D / w + L)^-1 R with L the strict lower triangle; Chebyshev's semi-iteration, with a new w in each iteration.
Bjoerck 1996, "Numerical methods for least squares problems", chapter 7, https://doi.org/10.1137/1.9781611971484. The
factor of Gauss-Seidel is 1, that of SOR is 1.5, and the others follow from an upper bound on the eigenvalues and an
estimate of the smallest. All of these converge for any positive definite matrix: Chebyshev in the order of
sqrt(cond(A)) iterations, the others in the order of cond(A).
"""

from __future__ import annotations

__all__ = ["SOR", "Chebyshev", "GaussSeidel", "Jacobi", "Richardson"]

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array, tril
from scipy.sparse.linalg import splu

from lbskel.solvers.iterative import Iterates, Iterative, eigenvalue_upper_bound, estimate_smallest_eigenvalue


class _Stationary(Iterative):
    """An iteration that applies the same linear map to the residual every time."""

    @abstractmethod
    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the change of X for the residual R."""

    def _iterates(self, X: NDArray[np.float64], R: NDArray[np.float64]) -> Iterates:
        while True:
            D = self._correction(R)
            X, R = X + D, R - self._matrix @ D
            yield X, R


class Richardson(_Stationary):
    """Richardson's iteration X + w R, with the optimal w for the estimated interval of eigenvalues."""

    def _prepare(self, A: Any) -> None:
        ones = np.ones(A.shape[0])
        self._factor = 2 / (eigenvalue_upper_bound(A, ones) + max(estimate_smallest_eigenvalue(A, ones), 0.0))

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._factor * R


class Jacobi(_Stationary):
    """Jacobi's iteration X + w D^-1 R, with the optimal w for the estimated interval of eigenvalues."""

    def _prepare(self, A: Any) -> None:
        scale = 1 / np.sqrt(A.diagonal())
        factor = 2 / (eigenvalue_upper_bound(A, scale) + max(estimate_smallest_eigenvalue(A, scale), 0.0))
        self._factors: NDArray[np.float64] = (factor * scale**2)[:, None]

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._factors * R


class GaussSeidel(_Stationary):
    """Gauss-Seidel: each unknown in turn is solved for, with the new values of those before it."""

    relaxation = 1.0

    def _prepare(self, A: csc_array) -> None:
        lower = tril(A, k=-1) + diags_array(A.diagonal() / self.relaxation)
        self._lower = splu(
            csc_array(lower), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        correction: NDArray[np.float64] = self._lower.solve(R)
        return correction


class SOR(GaussSeidel):
    """Successive overrelaxation: each change of Gauss-Seidel times 1.5."""

    relaxation = 1.5


class Chebyshev(Iterative):
    """Chebyshev's semi-iteration: the residual polynomial with the smallest maximum over the eigenvalue interval.

    The matrix is scaled to unit diagonal.
    """

    def _prepare(self, A: Any) -> None:
        self._scale = 1 / np.sqrt(A.diagonal())
        high = eigenvalue_upper_bound(A, self._scale)
        low = max(estimate_smallest_eigenvalue(A, self._scale), 1e-12 * high)
        self._center, self._half_width = (high + low) / 2, (high - low) / 2

    def _iterates(self, X: NDArray[np.float64], R: NDArray[np.float64]) -> Iterates:
        squared_scale = (self._scale**2)[:, None]
        D, ratio = squared_scale * R / self._center, self._half_width / self._center
        while True:
            X, R = X + D, R - self._matrix @ D
            yield X, R
            if self._half_width > 0:
                next_ratio = 1 / (2 * self._center / self._half_width - ratio)
                D = next_ratio * (ratio * D + 2 / self._half_width * (squared_scale * R))
                ratio = next_ratio
            else:
                D = squared_scale * R / self._center
