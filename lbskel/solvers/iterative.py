"""What the iterative solvers share: warm starts, a look at every iterate, and an end.

They need only products with the matrix, so that it may also be a :class:`NormalMatrix`, which is never formed. All
right-hand sides advance together, as one vector.
"""

from __future__ import annotations

__all__ = ["Iterative", "NormalMatrix", "Observer", "largest_eigenvalue", "smallest_eigenvalue"]

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal
from scipy.sparse import csr_array

from lbskel.errors import SolveError
from lbskel.solvers.factorization import LARGEST_RESIDUAL, Factorization

TOLERANCE = 1e-10  # on the residual relative to that of the start
MOST_ITERATIONS = 2000
RITZ_STEPS = 25

Observer: TypeAlias = Callable[[int, NDArray[np.float64]], None]


class NormalMatrix:
    """K^T K for a rectangular K, as products only."""

    def __init__(self, K: csr_array):
        self._K, self._transposed = K, K.T.tocsr()
        self.data, self.shape = K.data, (K.shape[1], K.shape[1])

    def __matmul__(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._transposed @ (self._K @ X)

    def __abs__(self) -> NormalMatrix:
        """Of |K|: its products bound those of |K^T K|."""
        return NormalMatrix(abs(self._K))

    def diagonal(self) -> NDArray[np.float64]:
        """Squared norms of the columns of K."""
        return np.asarray(self._K.power(2).sum(axis=0)).ravel()


def largest_eigenvalue(A: Any, scale: NDArray[np.float64]) -> float:
    """A bound on those of diag(scale) A diag(scale) from above, by Gershgorin."""
    return float(((abs(A) @ scale[:, None])[:, 0] * scale).max())


def smallest_eigenvalue(A: Any, scale: NDArray[np.float64]) -> float:
    """An estimate of that of diag(scale) A diag(scale) from above, by Lanczos's method.

    Golub, Van Loan 2013, "Matrix computations", section 10.1.
    """
    q, before = np.cos(np.arange(len(scale), dtype=np.float64)), np.zeros(len(scale))
    q /= np.linalg.norm(q)
    diagonal: list[float] = []
    beside: list[float] = [0.0]
    for _ in range(min(RITZ_STEPS, len(scale))):
        r = scale * (A @ (scale * q)[:, None])[:, 0] - beside[-1] * before
        diagonal.append(float(q @ r))
        r -= diagonal[-1] * q
        beside.append(float(np.linalg.norm(r)))
        if beside[-1] <= 1e-12 * abs(diagonal[0]):
            break
        before, q = q, r / beside[-1]
    return float(eigh_tridiagonal(diagonal, beside[1 : len(diagonal)], eigvals_only=True)[0])


class Iterative(Factorization):
    """A solver that comes nearer with every iteration; what it prepares beforehand costs little."""

    def _factorize(self, A: Any, like: Factorization | None) -> None:
        if not (A.diagonal() > 0).all():
            raise SolveError("the matrix is not positive definite: its diagonal is not positive")
        self.ordering = np.arange(A.shape[0])
        self._prepare(A)

    @abstractmethod
    def _prepare(self, A: Any) -> None:
        """What is done once for a matrix."""

    @abstractmethod
    def _iterate(self, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        """From zero until the residual is small, calling ``observe`` with the number and value of each iterate."""

    def _is_done(self, R: NDArray[np.float64], B: NDArray[np.float64]) -> bool:
        """Whether a residual is small, or no longer a number."""
        size = float(np.linalg.norm(R))
        return not size > TOLERANCE * float(np.linalg.norm(B))

    def _solve_once(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._iterate(B, MOST_ITERATIONS, lambda number, X: None)

    def solve(
        self,
        B: NDArray[np.float64],
        *,
        start: NDArray[np.float64] | None = None,
        on_iterate: Observer | None = None,
        iterations: int | None = None,
    ) -> NDArray[np.float64]:
        """X with A X = B, or as near as some iterations come.

        Parameters
        ----------
        B : (n, k) or (n,) array of float
        start : array like B, optional
            Where to begin; zero by default.
        on_iterate : callable, optional
            Called with the number of each iterate, from 1, and its value.
        iterations : int, optional
            No more than these, and what they give is returned, however good.

        Raises
        ------
        SolveError
            If ``iterations`` is not given and 2000 do not bring the residual down to a thousandth.
        """
        columns = np.asarray(B, dtype=np.float64).reshape(len(B), -1)
        first = np.zeros_like(columns) if start is None else np.asarray(start, dtype=np.float64).reshape(columns.shape)

        def observe(number: int, X: NDArray[np.float64]) -> None:
            if on_iterate is not None:
                on_iterate(number, (first + X).reshape(np.shape(B)))

        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            most = MOST_ITERATIONS if iterations is None else iterations
            X = first + self._iterate(columns - self._matrix @ first, most, observe)
        if iterations is None:
            if not np.isfinite(X).all():
                raise SolveError("the solution is not finite")
            residual = self.residual(X, columns)
            if residual > LARGEST_RESIDUAL:
                raise SolveError(
                    f"{MOST_ITERATIONS} iterations leave a residual of {residual:.1e}: use a direct solver, 'cholmod'",
                    residual,
                )
        return X.reshape(np.shape(B))
