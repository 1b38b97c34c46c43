"""The base of the iterative solvers: warm starts, a callback on every iterate, a stopping rule, eigenvalue bounds.

All but Gauss-Seidel, SOR and multigrid need only products with the matrix and its diagonal, so it may also be a
:class:`NormalMatrix`, which is never formed. All right-hand sides are iterated together, as one vector.
"""

from __future__ import annotations

__all__ = ["Iterative", "NormalMatrix", "Observer", "eigenvalue_upper_bound", "estimate_smallest_eigenvalue"]

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal
from scipy.sparse import csr_array

from lbskel.errors import SolveError
from lbskel.solvers.factorization import MAX_RESIDUAL, Factorization

TOLERANCE = 1e-10  # residual at which iterations stop, relative to that of the start; a guess
MAX_ITERATIONS = 2000  # a guess; benchmarks/results/solvers.md shows which solvers need more on which systems
N_LANCZOS_STEPS = 25  # steps for the estimate of the smallest eigenvalue; a guess

Observer: TypeAlias = Callable[[int, NDArray[np.float64]], None]


class NormalMatrix:
    """K^T K for a rectangular K, available through products only.

    Parameters
    ----------
    K : (m, n) csr_array
    """

    def __init__(self, K: csr_array):
        self._K, self._transposed = K, K.T.tocsr()
        self.data, self.shape = K.data, (K.shape[1], K.shape[1])

    def __matmul__(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        product: NDArray[np.float64] = self._transposed @ (self._K @ X)
        return product

    def __abs__(self) -> NormalMatrix:
        """Return the normal matrix of |K|, whose products bound those of |K^T K|."""
        return NormalMatrix(abs(self._K))

    def diagonal(self) -> NDArray[np.float64]:
        """Return the squared norms of the columns of K."""
        return np.asarray(self._K.power(2).sum(axis=0)).ravel()


def eigenvalue_upper_bound(A: Any, scale: NDArray[np.float64]) -> float:
    """Bound the eigenvalues of diag(scale) A diag(scale) from above, by Gershgorin's theorem.

    Parameters
    ----------
    A : (n, n) sparse array or NormalMatrix
    scale : (n,) array of float
    """
    return float(((abs(A) @ scale[:, None])[:, 0] * scale).max())


def estimate_smallest_eigenvalue(A: Any, scale: NDArray[np.float64]) -> float:
    """Estimate the smallest eigenvalue of diag(scale) A diag(scale) from above, by Lanczos's method.

    Golub, Van Loan 2013, "Matrix computations", section 10.1.

    Parameters
    ----------
    A : (n, n) sparse array or NormalMatrix
    scale : (n,) array of float
    """
    q, previous = np.cos(np.arange(len(scale), dtype=np.float64)), np.zeros(len(scale))
    q /= np.linalg.norm(q)
    diagonal: list[float] = []
    off_diagonal: list[float] = [0.0]
    for _ in range(min(N_LANCZOS_STEPS, len(scale))):
        r = scale * (A @ (scale * q)[:, None])[:, 0] - off_diagonal[-1] * previous
        diagonal.append(float(q @ r))
        r -= diagonal[-1] * q
        off_diagonal.append(float(np.linalg.norm(r)))
        if off_diagonal[-1] <= 1e-12 * abs(diagonal[0]):
            break
        previous, q = q, r / off_diagonal[-1]
    return float(eigh_tridiagonal(diagonal, off_diagonal[1 : len(diagonal)], eigvals_only=True)[0])


class Iterative(Factorization):
    """A solver whose iterates converge to the solution; the preparation of a matrix is cheap."""

    def _factorize(self, A: Any, like: Factorization | None) -> None:
        if not (A.diagonal() > 0).all():
            raise SolveError("the matrix is not positive definite: its diagonal is not positive")
        self.ordering = np.arange(A.shape[0])
        self._prepare(A)

    @abstractmethod
    def _prepare(self, A: Any) -> None:
        """Compute what all iterations on a matrix share."""

    @abstractmethod
    def _iterate(self, B: NDArray[np.float64], iterations: int, observe: Observer) -> NDArray[np.float64]:
        """Iterate from zero until the residual is small; call ``observe`` with the number and value of each iterate."""

    def _has_converged(self, R: NDArray[np.float64], B: NDArray[np.float64]) -> bool:
        """Whether the residual R is small, or NaN."""
        norm = float(np.linalg.norm(R))
        return not norm > TOLERANCE * float(np.linalg.norm(B))

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._iterate(B, MAX_ITERATIONS, lambda number, X: None)

    def solve(
        self,
        B: NDArray[np.float64],
        *,
        refined: bool = True,
        start: NDArray[np.float64] | None = None,
        on_iterate: Observer | None = None,
        iterations: int | None = None,
    ) -> NDArray[np.float64]:
        """Solve A X = B by iteration.

        Parameters
        ----------
        B : (n, k) or (n,) array of float
        refined : bool
            Has no effect: refinement is for direct solvers.
        start : array of float, of the shape of B, optional
            The initial guess; zero by default.
        on_iterate : callable, optional
            Called with the number of each iterate, from 1, and its value.
        iterations : int, optional
            Limit on the number of iterations. If it is given, the last iterate is returned whatever its residual.

        Returns
        -------
        array of float, of the shape of B

        Raises
        ------
        SolveError
            If ``iterations`` is not given, and after at most 2000 iterations the solution is not finite or the relative
            residual is above a thousandth.
        """
        columns = np.asarray(B, dtype=np.float64).reshape(len(B), -1)
        initial = (
            np.zeros_like(columns) if start is None else np.asarray(start, dtype=np.float64).reshape(columns.shape)
        )

        def observe(number: int, X: NDArray[np.float64]) -> None:
            if on_iterate is not None:
                on_iterate(number, (initial + X).reshape(np.shape(B)))

        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            limit = MAX_ITERATIONS if iterations is None else iterations
            X = initial + self._iterate(columns - self._matrix @ initial, limit, observe)
        if iterations is None:
            if not np.isfinite(X).all():
                raise SolveError("the solution is not finite")
            residual = self.residual(X, columns)
            if residual > MAX_RESIDUAL:
                raise SolveError(
                    f"{MAX_ITERATIONS} iterations leave a residual of {residual:.1e}: use a direct solver, 'cholmod'",
                    residual,
                )
        return X.reshape(np.shape(B))
