"""Supernodal sparse Cholesky: CHOLMOD, through cvxopt.

Chen, Davis, Hager, Rajamanickam 2008, "Algorithm 887: CHOLMOD", https://doi.org/10.1145/1391989.1391995.
"""

# SPDX-License-Identifier: GPL-3.0-or-later, which cvxopt and the CHOLMOD in it ask for
from __future__ import annotations

__all__ = ["Cholmod", "count_negative_pivots"]

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from cvxopt import amd, cholmod, matrix, spmatrix
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import SolveError
from lbskel.solvers.factorization import Factorization

_options_lock = threading.Lock()  # CHOLMOD's options are one dictionary of the process


class Cholmod(Factorization):
    """The factorization L L^T of the permuted matrix.

    A given ordering is used again if the sparsity pattern is the same. Intrinsic flips change the pattern between the
    steps of a contraction: the first step's ordering made later factorizations six times as slow, and a new ordering
    costs far less.
    """

    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        X, self._pattern = _lower_triangle(A)
        if isinstance(like, Cholmod) and all(map(np.array_equal, like._pattern, self._pattern)):
            self._ordering: matrix = like._ordering
        else:
            self._ordering = amd.order(X)
        self.ordering = np.array(self._ordering).ravel()
        with _options():
            try:
                self._factor = cholmod.symbolic(X, self._ordering)
                cholmod.numeric(X, self._factor)
            except ArithmeticError:
                raise SolveError("the matrix is not positive definite") from None

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        X = matrix(np.asfortranarray(B, dtype=np.float64))
        cholmod.solve(self._factor, X)
        return np.array(X)


def count_negative_pivots(A: csc_array, ordering: NDArray[np.int64] | None = None) -> int:
    """Count the negative eigenvalues of a symmetric matrix: the negative pivots of L D L^T, by Sylvester's law.

    Parameters
    ----------
    A : (n, n) csc_array
        Both triangles given; may be indefinite.
    ordering : (n,) array of int, optional
        A fill-reducing permutation, such as that of a factorization of a matrix with the same pattern.

    Raises
    ------
    SolveError
        If a pivot is zero.
    """
    X, _ = _lower_triangle(A)
    pivots = matrix(1.0, (A.shape[0], 1))
    with _options(supernodal=0):  # the supernodal factorization is L L^T, of positive definite matrices only
        try:
            factor = cholmod.symbolic(X, amd.order(X) if ordering is None else matrix(ordering))
            cholmod.numeric(X, factor)
        except ArithmeticError:
            raise SolveError("the matrix has a pivot of zero") from None
        cholmod.solve(factor, pivots, sys=6)  # D x = 1
    return int((np.array(pivots) < 0).sum())


def _lower_triangle(A: csc_array) -> tuple[spmatrix, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return the lower triangle as cvxopt's matrix, and its pattern."""
    rows, columns = A.indices.astype(np.int64), np.repeat(np.arange(A.shape[1]), np.diff(A.indptr))
    lower = np.flatnonzero(rows >= columns)
    pattern = rows[lower], columns[lower]
    return spmatrix(matrix(A.data[lower]), *map(matrix, pattern), A.shape), pattern


@contextmanager
def _options(**changes: int) -> Iterator[None]:
    """Use the given ordering and do not try others, one thread at a time; the options are restored afterwards."""
    with _options_lock:
        before = dict(cholmod.options)
        cholmod.options.update(nmethods=1, **changes)
        try:
            yield
        finally:
            cholmod.options.clear()
            cholmod.options.update(before)
