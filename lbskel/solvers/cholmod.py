"""Supernodal sparse Cholesky: CHOLMOD, through cvxopt.

Chen, Davis, Hager, Rajamanickam 2008, "Algorithm 887: CHOLMOD", https://doi.org/10.1145/1391989.1391995.
"""

from __future__ import annotations

__all__ = ["Cholmod"]

import numpy as np
from cvxopt import amd, cholmod, matrix, spmatrix
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import SolveError
from lbskel.solvers.factorization import Factorization


class Cholmod(Factorization):
    """The factorization L L^T of the permuted matrix.

    The ordering is used again if the sparsity pattern is the same. Intrinsic flips change the pattern in a contraction:
    the first step's ordering made later factorizations six times as slow; a new ordering costs far less.
    """

    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        rows, columns = A.indices.astype(np.int64), np.repeat(np.arange(A.shape[1]), np.diff(A.indptr))
        lower = np.flatnonzero(rows >= columns)
        self._pattern = rows[lower], columns[lower]
        X = spmatrix(matrix(A.data[lower]), *map(matrix, self._pattern), A.shape)
        if isinstance(like, Cholmod) and all(map(np.array_equal, like._pattern, self._pattern)):
            self._ordering: matrix = like._ordering
        else:
            self._ordering = amd.order(X)
        self.ordering = np.array(self._ordering).ravel()
        options_before = dict(cholmod.options)
        cholmod.options["nmethods"] = 1  # use the given ordering, do not try others
        try:
            self._factor = cholmod.symbolic(X, self._ordering)
            cholmod.numeric(X, self._factor)
        except ArithmeticError as error:
            raise SolveError(f"the matrix is not positive definite at column {error}") from None
        finally:
            cholmod.options.clear()
            cholmod.options.update(options_before)

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        X = matrix(np.asfortranarray(B, dtype=np.float64))
        cholmod.solve(self._factor, X)
        return np.array(X)
