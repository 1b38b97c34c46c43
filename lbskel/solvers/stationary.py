"""The classical iterations for A x = b, which for A = K^T K are those for least squares.

With R = B - A X: Richardson's (Landweber's) X + w R; Jacobi's X + w D^-1 R; Gauss-Seidel's and successive
overrelaxation's X + (D / w + L)^-1 R, L the lower triangle; Chebyshev's semi-iteration, with a new w each time.
Bjoerck 1996, "Numerical methods for least squares problems", chapter 7, https://doi.org/10.1137/1.9781611971484. Their
factors are taken from bounds on the eigenvalues, so that all of them converge for any positive definite matrix; all but
Chebyshev's take some cond(A) iterations, his sqrt(cond(A)).
"""

from __future__ import annotations

__all__ = ["SOR", "Chebyshev", "GaussSeidel", "Jacobi", "Richardson"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array, tril
from scipy.sparse.linalg import splu

from lbskel.solvers.iterative import Iterative, Observer, largest_eigenvalue, smallest_eigenvalue


class _Stationary(Iterative):
    """The same correction of the residual at every iteration."""

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        raise NotImplementedError

    def _iterate(self, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        X, R = np.zeros_like(B), B
        for number in range(1, iterations + 1):
            if self._is_done(R, B):
                break
            X = X + self._correction(R)
            R = B - self._matrix @ X
            observe(number, X)
        return X


class Richardson(_Stationary):
    """X + w R with the best w for the bounds."""

    def _prepare(self, A: Any) -> None:
        ones = np.ones(A.shape[0])
        self._factor = 2 / (largest_eigenvalue(A, ones) + max(smallest_eigenvalue(A, ones), 0.0))

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._factor * R


class Jacobi(_Stationary):
    """X + w D^-1 R with the best w for the bounds."""

    def _prepare(self, A: Any) -> None:
        scale = 1 / np.sqrt(A.diagonal())
        factor = 2 / (largest_eigenvalue(A, scale) + max(smallest_eigenvalue(A, scale), 0.0))
        self._factors = (factor * scale**2)[:, None]

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._factors * R


class GaussSeidel(_Stationary):
    """Each unknown in turn solved for, with the new values of those before it."""

    relaxation = 1.0

    def _prepare(self, A: csc_array) -> None:
        lower = tril(A, k=-1) + diags_array(A.diagonal() / self.relaxation)
        self._lower = splu(
            csc_array(lower), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )

    def _correction(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._lower.solve(R)


class SOR(GaussSeidel):
    """Successive overrelaxation: each change of Gauss and Seidel's 1.5 times as far."""

    relaxation = 1.5


class Chebyshev(Iterative):
    """The polynomial in A that is smallest over an interval of eigenvalues, on the matrix scaled to unit diagonal."""

    def _prepare(self, A: Any) -> None:
        self._scale = 1 / np.sqrt(A.diagonal())
        high = largest_eigenvalue(A, self._scale)
        low = max(smallest_eigenvalue(A, self._scale), 1e-12 * high)
        self._middle, self._half = (high + low) / 2, (high - low) / 2

    def _iterate(self, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        squares = (self._scale**2)[:, None]
        X, R = np.zeros_like(B), B
        D, ratio = squares * R / self._middle, self._half / self._middle
        for number in range(1, iterations + 1):
            if self._is_done(R, B):
                break
            X = X + D
            R = R - self._matrix @ D
            observe(number, X)
            if self._half > 0:
                following = 1 / (2 * self._middle / self._half - ratio)
                D = following * (ratio * D + 2 / self._half * (squares * R))
                ratio = following
            else:
                D = squares * R / self._middle
        return X
