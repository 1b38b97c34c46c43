"""Treatment of the rows of L at degenerate triangles, for the least-squares energy.

A treatment multiplies row i of L V' = 0 by a factor and adds an identity entry. The treatments are those found in
implementations of Au, Tai, Chu, Cohen-Or, Lee 2008, https://doi.org/10.1145/1399504.1360643: an identity row with
right-hand side zero, which asks for v_i' = 0 and so pulls the vertex to the origin; an identity row that asks for
v_i' = v_i; and the treatment of the authors' demo program, which scales down rows whose weights sum to more than a
bound.
Strategies that change the weights themselves (clamped, mean value, mollified, intrinsic Delaunay, robust) are
operators.
"""

from __future__ import annotations

__all__ = ["MAX_ROW_SUM", "ROW_TREATMENTS", "RowTreatment"]

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

MAX_ROW_SUM = 1e4  # bound on the sum of the weights cot a + cot b of a row, dimensionless; Au et al.'s demo program


@dataclass(frozen=True, eq=False)
class RowTreatment:
    """A change of the rows of L: row i becomes ``factors[i] L_i + identity[i] e_i``.

    Parameters
    ----------
    factors, identity : (n,) array of float
        1 and 0 for a row that is not changed.
    keeps_position : bool
        Whether an identity row has the present position as its right-hand side; otherwise it has zero, the origin.
    """

    factors: NDArray[np.float64]
    identity: NDArray[np.float64]
    keeps_position: bool = False

    @property
    def changed_rows(self) -> NDArray[np.int64]:
        """(r,) indices of the rows that are changed."""
        return np.flatnonzero((self.factors != 1) | (self.identity != 0))

    def apply(self, L: csr_array) -> csr_array:
        """Return L with the rows changed."""
        if len(self.changed_rows) == 0:
            return L
        return (diags_array(self.factors) @ L + diags_array(self.identity)).tocsr()

    def right_hand_side(self, V: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) right-hand side T of L V' = T for (n, 3) present positions V."""
        return self.identity[:, None] * V if self.keeps_position else np.zeros_like(V)


def _none(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Change no row."""
    return RowTreatment(np.ones(L.shape[0]), np.zeros(L.shape[0]))


def _identity(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Ask the degenerate vertices to stay where they are."""
    identity = np.zeros(L.shape[0])
    identity[degenerate] = 1
    return RowTreatment(1 - identity, identity, keeps_position=True)


def _identity_zero(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Pull the degenerate vertices to the origin."""
    held = _identity(L, degenerate)
    return RowTreatment(held.factors, held.identity)


def _row_sums(L: csr_array, degenerate: NDArray[np.int64]) -> RowTreatment:
    """Scale down every row whose weights sum to more than the bound, whether degenerate or not."""
    sums = np.abs(L.diagonal())
    return RowTreatment(MAX_ROW_SUM / np.maximum(sums, MAX_ROW_SUM), np.zeros(L.shape[0]))


ROW_TREATMENTS: dict[str, Callable[[csr_array, NDArray[np.int64]], RowTreatment]] = {
    "none": _none,
    "identity": _identity,
    "identity_zero": _identity_zero,
    "row_sums": _row_sums,
}
"""Functions from L and the indices of the vertices of degenerate triangles to a RowTreatment, by name."""
