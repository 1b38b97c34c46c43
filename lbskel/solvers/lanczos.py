"""Thick-restart Lanczos iteration: the largest eigenpairs of an operator that is symmetric in the product x^T M y.

Wu, Simon 2000, "Thick-restart Lanczos method for large symmetric eigenvalue problems",
https://doi.org/10.1137/S0895479898334605: when the basis is full, it is replaced by the best Ritz vectors and the last
Lanczos vector, and the recurrence goes on. Every vector is made M-orthogonal to the whole basis once, after the
recurrence has been subtracted. The basis is changed at restarts alone, by one product of matrices; ARPACK applies
reflectors one by one, and took 1.6 times as long (100 pairs, 26,000 vertices).
"""

from __future__ import annotations

__all__ = ["ThickRestartLanczos"]

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import csc_array

from lbskel.errors import SolveError

# Largest residual of a Ritz pair that has converged, relative to its Ritz value; errors of eigenvalues are about its
# square, those of eigenvectors this over the relative gap.
TOLERANCE = 1e-14
# Steps between two tests of convergence, as a share of the pairs wanted, and their minimum; each test solves an
# eigenproblem of the size of the basis. A guess.
CHECK_SHARE, MIN_INTERVAL = 0.2, 10
MIN_SURPLUS = 30  # vectors of the basis beyond the pairs wanted, at least; it has as many as pairs if these are more
MAX_RESTARTS = 300  # a guess, far above the ten of the slowest mesh tried
BREAKDOWN = 1e-14  # a new direction below this, relative to the image of the last, is rounding error

Apply = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class ThickRestartLanczos:
    """Lanczos iteration that can go on with a new direction after it has converged.

    Parameters
    ----------
    apply : callable
        (n,) to (n,): the product of A M^-1 with a vector, for an operator A with x^T M A y = y^T M A x. It is called
        with M q.
    M : (n, n) csc_array
        Symmetric, positive definite.
    k : int
        Number of eigenpairs, less than n.
    random : numpy.random.Generator
        Source of the starting vectors.
    """

    def __init__(self, apply: Apply, M: csc_array, k: int, random: np.random.Generator):
        n = M.shape[0]
        self._apply, self._M, self._k, self._random = apply, M, k, random
        self._capacity = min(k + max(k, MIN_SURPLUS), n)
        self._interval = max(MIN_INTERVAL, int(CHECK_SHARE * k))
        self._V = np.empty((n, self._capacity + 1), order="F")
        self._H = np.zeros((self._capacity, self._capacity))
        self._size, self._beta = 0, 0.0
        self._start()

    def run(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Iterate until the k largest Ritz pairs have converged, after a number of steps with a new direction.

        Returns
        -------
        values : (k,) array of float
            Descending.
        vectors : (n, k) array of float
            M-orthonormal columns.

        Raises
        ------
        SolveError
            If they have not converged after MAX_RESTARTS restarts.
        """
        fewest = max(self._k + 1, self._size + self._interval)  # pairs of an earlier run have converged at once
        for _ in range(MAX_RESTARTS):
            for size in range(self._size + 1, self._capacity + 1):
                self._step()
                if size == self._capacity or (size >= fewest and size % self._interval == 0):
                    values, Y = eigh(self._H[:size, :size])
                    values, Y = values[::-1], Y[:, ::-1]
                    residuals = self._beta * np.abs(Y[-1, : self._k])
                    if (residuals <= TOLERANCE * np.abs(values[: self._k])).all() or size == len(self._V):
                        self._restart(values, Y, self._k)
                        return values[: self._k], self._V[:, : self._k].copy()
            self._restart(values, Y, self._k + (self._capacity - self._k) // 3)
        raise SolveError(f"Lanczos' method has not found {self._k} eigenpairs after {MAX_RESTARTS} restarts")

    def add_direction(self) -> None:
        """Go on with a random vector: in exact arithmetic one start finds one vector of each multiple eigenvalue.

        Convergence is next tested after twice as many steps as before, so that a vector that is still missing can come
        up among those found, which have converged at once.
        """
        self._interval *= 2
        self._H[: self._size, self._size] = self._H[self._size, : self._size] = 0.0
        self._start()

    def _start(self) -> None:
        """Put a random vector, M-orthonormal to the basis, at its end."""
        V = self._V[:, : self._size]
        q = self._random.uniform(-1, 1, len(V))
        for _ in range(2):
            q = q - V @ (V.T @ (self._M @ q))
            q /= np.sqrt(q @ (self._M @ q))
        self._V[:, self._size] = q

    def _step(self) -> None:
        """Take the last vector into the basis and compute the next one; its column of H is known above the diagonal."""
        j = self._size
        V, q, known = self._V[:, : j + 1], self._V[:, j], self._H[:j, j]
        w = self._apply(self._M @ q)
        length = np.sqrt(w @ (self._M @ w))
        first = int(np.argmax(known != 0)) if j else 0  # one entry, or after a restart all
        w -= V[:, first:j] @ known[first:]
        diagonal = q @ (self._M @ w)
        w -= diagonal * q
        correction = V.T @ (self._M @ w)
        w -= V @ correction
        self._H[j, j] = diagonal + correction[j]
        self._beta = float(np.sqrt(w @ (self._M @ w)))
        self._size = j + 1
        if not self._beta > BREAKDOWN * length:  # the basis is invariant
            self._beta = 0.0
            if self._size < len(V):
                self._start()
        else:
            self._V[:, j + 1] = w / self._beta
        if self._size < self._capacity:
            self._H[j, j + 1] = self._H[j + 1, j] = self._beta

    def _restart(self, values: NDArray[np.float64], Y: NDArray[np.float64], n_kept: int) -> None:
        """Replace the basis by its best Ritz vectors and the last Lanczos vector, which is coupled to all of them."""
        n_kept = min(n_kept, self._size - 1)
        last = self._V[:, self._size].copy()
        self._V[:, :n_kept] = self._V[:, : self._size] @ Y[:, :n_kept]
        self._V[:, n_kept] = last
        self._H[:] = 0.0
        self._H[np.arange(n_kept), np.arange(n_kept)] = values[:n_kept]
        self._H[:n_kept, n_kept] = self._H[n_kept, :n_kept] = self._beta * Y[-1, :n_kept]
        self._size = n_kept
