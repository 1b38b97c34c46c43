"""What becomes of the rows of L at degenerate triangles, for the energy that has rows: least squares.

Row i of L V' = 0 is multiplied by a factor and gets an identity on top. The strategies are those that implementations
of Au, Tai, Chu, Cohen-Or, Lee 2008, https://doi.org/10.1145/1399504.1360643, have tried: an identity row whose
right-hand side stays zero, which asks for v_i' = 0 and so draws the vertex to the origin; one that asks for v_i' = v_i;
and the authors' own program's, which scales down a row whose weights sum to more than a limit. Strategies that change
the weights themselves (clamped, mean value, mollified, intrinsic Delaunay, robust) are operators.
"""

from __future__ import annotations

__all__ = ["MAX_ROW_SUM", "ROW_TREATMENTS", "RowTreatment"]

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

MAX_ROW_SUM = 1e4  # of the authors' program, in weights cot a + cot b


@dataclass(frozen=True, eq=False)
class RowTreatment:
    """How rows of L are changed: row i becomes ``factors[i] L_i + identity[i] e_i``.

    Parameters
    ----------
    factors, identity : (n,) array of float
    holds : bool
        Whether an identity row asks for the vertex to stay; otherwise it asks for the origin.
    """

    factors: NDArray[np.float64]
    identity: NDArray[np.float64]
    holds: bool = False

    @property
    def rows(self) -> NDArray[np.int64]:
        """Which rows are changed."""
        return np.flatnonzero((self.factors != 1) | (self.identity != 0))

    def matrix(self, L: csr_array) -> csr_array:
        """The changed L."""
        if len(self.rows) == 0:
            return L
        return (diags_array(self.factors) @ L + diags_array(self.identity)).tocsr()

    def target(self, V: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) what L V' should be."""
        return self.identity[:, None] * V if self.holds else np.zeros_like(V)


def _none(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Rows stay as they are."""
    return RowTreatment(np.ones(L.shape[0]), np.zeros(L.shape[0]))


def _identity(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """The vertex is asked to stay."""
    identity = np.zeros(L.shape[0])
    identity[degenerate] = 1
    return RowTreatment(1 - identity, identity, holds=True)


def _identity_zero(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """The vertex is asked to the origin."""
    held = _identity(L, degenerate)
    return RowTreatment(held.factors, held.identity)


def _row_sums(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Rows whose weights sum to more than the limit are scaled down to it, wherever their triangles are."""
    sums = np.abs(L.diagonal())
    return RowTreatment(MAX_ROW_SUM / np.maximum(sums, MAX_ROW_SUM), np.zeros(L.shape[0]))


ROW_TREATMENTS: dict[str, Callable[[csr_array, NDArray[np.int64]], RowTreatment]] = {
    "none": _none,
    "identity": _identity,
    "identity_zero": _identity_zero,
    "row_sums": _row_sums,
}
