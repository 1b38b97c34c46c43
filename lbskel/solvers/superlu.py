"""Sparse LU with a symmetric ordering: SuperLU, through scipy. Several times slower than CHOLMOD, and always there.

Li 2005, "An overview of SuperLU", https://doi.org/10.1145/1089014.1089017.
"""

from __future__ import annotations

__all__ = ["SuperLU", "solve_once"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from lbskel.errors import SolveError
from lbskel.solvers.factorization import Factorization


class SuperLU(Factorization):
    """L U with pivots from the diagonal; the ordering is found once and applied beforehand after that."""

    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        if isinstance(like, SuperLU):
            self.ordering, method = like.ordering, "NATURAL"
            A = A[self.ordering][:, self.ordering].tocsc()
        else:
            self.ordering, method = np.arange(A.shape[0]), "MMD_AT_PLUS_A"
        try:
            self._factor = splu(A, permc_spec=method, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SolveError(f"the matrix cannot be factorized: {error}") from None
        is_symmetric_pivoting = np.array_equal(self._factor.perm_r, self._factor.perm_c)
        if not (is_symmetric_pivoting and (self._factor.U.diagonal() > 0).all()):
            raise SolveError("the matrix is not positive definite: a pivot is not positive")
        self._applied = self.ordering
        if method != "NATURAL":
            self.ordering = np.argsort(self._factor.perm_c)

    def _solve_once(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        X = np.empty_like(B, dtype=np.float64)
        X[self._applied] = self._factor.solve(np.ascontiguousarray(B[self._applied]))
        return X


def solve_once(A: csc_array, B: NDArray[np.float64]) -> NDArray[np.float64]:
    """X of A X = B for any square A, by one elimination with row pivots: unrefined, and of whatever residual.

    Raises
    ------
    SolveError
        If A has entries that are not finite, or a pivot is zero.
    """
    if not np.isfinite(A.data).all():
        raise SolveError("the matrix has entries that are not finite")
    try:
        return splu(A).solve(B)
    except RuntimeError as error:
        raise SolveError(f"the matrix cannot be factorized: {error}") from None
