"""The base of the iterative solvers: warm starts, a callback on every iterate, a stopping rule, eigenvalue bounds.

All but Gauss-Seidel, SOR and multigrid need only products with the matrix and its diagonal, so it may also be a
:class:`NormalMatrix`, which is never formed. Iterations end when the residual of each row i and column x is at most
TOLERANCE (|A_i| max|x| + |b_i|), with |A_i| the sum of the row's magnitudes. Then x solves exactly a system of which no
row differs from the given one by more than that part of its size: the row-wise backward error of Higham 2002, "Accuracy
and stability of numerical algorithms", section 7.2, https://doi.org/10.1137/1.9780898718027. So a row or a column of
large numbers, such as a penalty, hides no other.
"""

from __future__ import annotations

__all__ = ["Iterative", "NormalMatrix", "Observer", "eigenvalue_upper_bound", "estimate_smallest_eigenvalue"]

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal
from scipy.sparse import csr_array

from lbskel.errors import SolveError
from lbskel.solvers.factorization import MAX_RESIDUAL, Factorization, real_rows

# Row-wise backward error at which iterations stop, no unit: 45 roundings, near what direct solvers leave, and above the
# rounding of the residual itself. Against 1e-10 of the norm of B, contraction, smoothing, reconstruction and spectra of
# hand.ply and dinosaur.ply took 3 to 42 % more iterations, and errors of 1e-10 to 1e-13 became 1e-13 to 1e-16.
TOLERANCE = 1e-14
MAX_ITERATIONS = 2000  # a guess; benchmarks/results/solvers.md shows which solvers need more on which systems
N_LANCZOS_STEPS = 25  # steps for the estimate of the smallest eigenvalue; a guess

Observer: TypeAlias = Callable[[int, NDArray[np.float64]], None]
Iterates: TypeAlias = Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]


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


def column_dot(X: NDArray[np.float64], Y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (k,) dot products of the columns of two (n, k) arrays."""
    result: NDArray[np.float64] = np.einsum("ij,ij->j", X, Y)
    return result


def ratios(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Divide, with 0 where the divisor is 0, as it is in a column that has converged."""
    result: NDArray[np.float64] = np.divide(a, b, out=np.zeros_like(a), where=b != 0)
    return result


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
        self._row_sums: NDArray[np.float64] = (abs(A) @ np.ones((A.shape[0], 1)))[:, 0]
        self._prepare(A)

    @abstractmethod
    def _prepare(self, A: Any) -> None:
        """Compute what all iterations on a matrix share."""

    @abstractmethod
    def _iterates(self, X: NDArray[np.float64], R: NDArray[np.float64]) -> Iterates:
        """Iterate without end from X, which has the residual R = B - A X; yield each iterate and its residual."""

    def _backward_error(self, X: NDArray[np.float64], R: NDArray[np.float64], B: NDArray[np.float64]) -> float:
        """Return the largest row-wise backward error of a column with the residual R; it may be NaN."""
        errors = (
            ratios(np.abs(r), self._row_sums * np.abs(x).max(initial=0.0) + np.abs(b)).max(initial=0.0)
            for x, r, b in zip(X.T, R.T, B.T, strict=True)
        )
        return float(np.max(list(errors), initial=0.0))

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.solve(B)

    def solve(
        self,
        B: NDArray[np.float64],
        *,
        refined: bool = True,
        start: NDArray[np.float64] | None = None,
        on_iterate: Observer | None = None,
        iterations: int | None = None,
    ) -> NDArray[np.float64]:
        """Solve A X = B by iteration, until the residual of each row and column is small.

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
            If B has another number of rows or is complex, or ``iterations`` is not given, and after 2000 iterations the
            solution is not finite or the residual is not small.
        """
        n = self._matrix.shape[0]
        columns = real_rows(B, n).reshape(n, -1)
        X = np.zeros_like(columns) if start is None else real_rows(start, n, "start").reshape(columns.shape)
        limit, number = MAX_ITERATIONS if iterations is None else iterations, 0
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            R = columns - self._matrix @ X
            iterates, error = self._iterates(X, R), self._backward_error(X, R, columns)
            while number < limit and error > TOLERANCE:
                X, R = next(iterates)
                number += 1
                if on_iterate is not None:
                    on_iterate(number, X.reshape(np.shape(B)))
                error = self._backward_error(X, R, columns)
                if not error > TOLERANCE:  # by the residual carried along, which rounding has moved from the true one
                    R = columns - self._matrix @ X
                    iterates, error = self._iterates(X, R), self._backward_error(X, R, columns)
        if iterations is None:
            if not np.isfinite(X).all():
                raise SolveError("the solution is not finite")
            residual = self.residual(X, columns)
            if error > TOLERANCE or residual > MAX_RESIDUAL:
                left = f"a residual of {residual:.1e}, above {MAX_RESIDUAL:g}"
                if error > TOLERANCE:
                    left = f"a row-wise backward error of {error:.1e}, above {TOLERANCE:g}"
                raise SolveError(f"{number} iterations leave {left}: use a direct solver, 'cholmod'", residual)
        return X.reshape(np.shape(B))
