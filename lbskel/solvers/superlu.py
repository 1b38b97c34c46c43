"""Sparse LU with a symmetric ordering: SuperLU, through scipy.

It takes 1.1 to 24 times as long as CHOLMOD on the systems of the first table of ``benchmarks/results/solvers.md``.

Li 2005, "An overview of SuperLU", https://doi.org/10.1145/1089014.1089017.
"""

from __future__ import annotations

__all__ = ["GeneralLU", "SuperLU", "solve_once"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from lbskel.errors import SolveError
from lbskel.solvers.factorization import Factorization


class SuperLU(Factorization):
    """The factorization L U with pivots from the diagonal; a known ordering is applied to the matrix beforehand."""

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

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        X = np.empty_like(B, dtype=np.float64)
        X[self._applied] = self._factor.solve(np.ascontiguousarray(B[self._applied]))
        return X


class GeneralLU(Factorization):
    """The factorization L U with row pivoting, of any square matrix that is not singular."""

    def _factorize(self, A: csc_array, like: Factorization | None) -> None:
        try:
            self._factor = splu(A)
        except RuntimeError as error:
            raise SolveError(f"the matrix cannot be factorized: {error}") from None
        self.ordering = np.argsort(self._factor.perm_c)

    def _solve_unrefined(self, B: NDArray[np.float64]) -> NDArray[np.float64]:
        X: NDArray[np.float64] = self._factor.solve(np.ascontiguousarray(B))
        return X


def solve_once(A: csc_array, B: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve A X = B for any square A by sparse LU with row pivoting, without refinement or a check of the residual.

    Parameters
    ----------
    A : (n, n) csc_array
    B : (n, k) or (n,) array of float

    Raises
    ------
    SolveError
        If A has entries that are not finite, or a pivot is zero.
    """
    if not np.isfinite(A.data).all():
        raise SolveError("the matrix has entries that are not finite")
    try:
        X: NDArray[np.float64] = splu(A).solve(B)
    except RuntimeError as error:
        raise SolveError(f"the matrix cannot be factorized: {error}") from None
    return X
