"""What a step of the contraction minimizes: a pull along the Laplacian against a hold on every vertex.

- ``curvature_flow``:    tau V'^T S V' + (V' - V)^T H (V' - V),  H = M_0 A_0 / A_t
- ``least_squares``:  W_L^2 ||L V' - T||^2 + (V' - V)^T W_H^2 (V' - V),  L = 2 S,  W_H^2 = A_0 / A_t

A_0 and A_t are the areas of a vertex's ring of triangles at the start and now, M_0 the areas of the vertices: what has
become thin is held harder; T is zero but for rows that :mod:`lbskel.contraction.degenerate_rows` puts into L. The second is Au, Tai,
Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction", https://doi.org/10.1145/1399504.1360643, equations
4 to 6; the first holds the backward Euler flow of Desbrun, Meyer, Schroeder, Barr 1999,
https://doi.org/10.1145/311535.311576, by the same weights, and needs a symmetric S. Both are solved for the
displacement, since an error relative to a small displacement is smaller than one relative to a position.
"""

from __future__ import annotations

__all__ = ["ENERGIES", "ContractionStepInput", "LinearSystem", "rectangular"]

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, diags_array, vstack

from lbskel.contraction.degenerate_rows import RowTreatment
from lbskel.operators import Laplacian
from lbskel.operators.assembly import diagonal_matrix


@dataclass(frozen=True, eq=False)
class ContractionStepInput:
    """What an energy needs to know to set up a step."""

    laplacian: Laplacian
    vertices: NDArray[np.float64]
    weight: float
    area_kept: NDArray[np.float64]  # A_0 / A_t, the square of Au's W_H
    start_mass: NDArray[np.float64]
    treatment: Callable[[csr_array], RowTreatment]

    @property
    def rows(self) -> tuple[csr_array, RowTreatment]:
        """L as it is treated, and how."""
        L = (2 * self.laplacian.stiffness).tocsr()
        treatment = self.treatment(L)
        return treatment.matrix(L), treatment


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A D = B for the displacement D, A V' = ``positions`` for where it leads.

    ``attraction`` is H or W_H^2, and ``replaced`` are the rows of L that were changed.
    """

    A: csc_array
    B: NDArray[np.float64]
    positions: NDArray[np.float64]
    attraction: NDArray[np.float64]
    replaced: NDArray[np.int64]


def _curvature_flow(pull: ContractionStepInput) -> LinearSystem:
    """(H + tau S) D = -tau S V."""
    S = pull.laplacian.stiffness * pull.weight
    H = pull.start_mass * pull.area_kept
    A = (S + diagonal_matrix(H)).tocsc()
    return LinearSystem(A, -(S @ pull.vertices), H[:, None] * pull.vertices, H, np.empty(0, dtype=np.int64))


def _least_squares(pull: ContractionStepInput) -> LinearSystem:
    """(W_H^2 + W_L^2 L^T L) D = -W_L^2 L^T (L V - T)."""
    V, H = pull.vertices, pull.area_kept
    L, treatment = pull.rows
    A = diagonal_matrix(H) + pull.weight * (L.T @ L)
    target = treatment.target(V)
    B = -pull.weight * (L.T @ (L @ V - target))
    return LinearSystem(A.tocsc(), B, H[:, None] * V + pull.weight * (L.T @ target), H, treatment.rows)


def rectangular(pull: ContractionStepInput) -> tuple[csr_array, NDArray[np.float64]]:
    """K = [W_L L; W_H] and its right-hand side, whose least-squares solution is the displacement of a step."""
    L, treatment = pull.rows
    W = np.sqrt(pull.weight)
    K = vstack([W * L, diags_array(np.sqrt(pull.area_kept))]).tocsr()
    V = pull.vertices
    return K, np.concatenate([-W * (L @ V - treatment.target(V)), np.zeros_like(V)])


ENERGIES: dict[str, Callable[[ContractionStepInput], LinearSystem]] = {
    "curvature_flow": _curvature_flow,
    "least_squares": _least_squares,
}
