"""The energy that a contraction step minimizes: contraction along the Laplacian against attraction of every vertex.

- ``curvature_flow``:  V'^T S V' + (V' - V)^T H / tau (V' - V),  H = M_0 A_0 / A_t
- ``least_squares``:  W_L^2 ||L V' - T||^2 + (V' - V)^T W_H^2 (V' - V),  L = 2 S,  W_H^2 = A_0 / A_t

A_0 and A_t are the areas of a vertex's ring of triangles at the start and now (ATTRACTIONS has other measures too), and
M_0 the vertex areas at the start: the thinner the surroundings of a vertex have become, the more strongly it is
attracted to its position. T is zero except for rows that :mod:`lbskel.contraction.degenerate_rows` changes in L. The
second energy is that of Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
https://doi.org/10.1145/1399504.1360643, equations 4 to 6. The first adds the same attraction to the backward Euler step
of the flow of Desbrun, Meyer, Schroeder, Barr 1999, https://doi.org/10.1145/311535.311576, and needs a symmetric S.
With roll-back, both are solved for the displacement, since an error relative to a small displacement is smaller than
one relative to a position.
"""

from __future__ import annotations

__all__ = ["ENERGIES", "ContractionStepInput", "LinearSystem", "stacked_system"]

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
    """What determines a contraction step, on a mesh scaled to diameter bound 1.

    Parameters
    ----------
    laplacian : Laplacian
        On the present positions.
    vertices : (n, 3) array of float
        Present positions.
    weight : float or (n,) array of float
        Contraction weight: tau for ``curvature_flow``, W_L^2 for ``least_squares``.
    shrinkage : (n,) array of float
        A_0 / A_t, the square of Au's W_H.
    initial_mass : (n,) array of float
        M_0, the vertex areas at the start.
    treatment : callable
        From L to the treatment of its degenerate rows.
    """

    laplacian: Laplacian
    vertices: NDArray[np.float64]
    weight: float | NDArray[np.float64]
    shrinkage: NDArray[np.float64]
    initial_mass: NDArray[np.float64]
    treatment: Callable[[csr_array], RowTreatment]

    @property
    def treated_rows(self) -> tuple[csr_array, RowTreatment]:
        """L with its degenerate rows treated, and the treatment."""
        L = (2 * self.laplacian.stiffness).tocsr()
        treatment = self.treatment(L)
        return treatment.apply(L), treatment


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """The linear system of a step, once for displacements and once for positions: A D = B and A V' = P.

    Parameters
    ----------
    A : (n, n) csc_array
        Symmetric positive definite where S is symmetric or the energy is ``least_squares``.
    B : (n, 3) array of float
        Right-hand side for the displacement D.
    positions : (n, 3) array of float
        Right-hand side P for the new positions V'.
    attraction : (n,) array of float
        Diagonal of H or W_H^2.
    replaced_rows : (r,) array of int
        Rows of L that were changed.
    """

    A: csc_array
    B: NDArray[np.float64]
    positions: NDArray[np.float64]
    attraction: NDArray[np.float64]
    replaced_rows: NDArray[np.int64]


def _curvature_flow(step: ContractionStepInput) -> LinearSystem:
    """(H / tau + S) D = -S V.

    Where tau varies, each vertex has a time step of its own and moves along its mean curvature normal. Edges weighted
    by tau would move vertices along the surface too, towards larger tau, and fold it where the thickness changes.
    """
    S, H, tau = step.laplacian.stiffness, step.initial_mass * step.shrinkage, step.weight
    H_over_tau = np.divide(H, tau, out=np.array(H), where=np.broadcast_to(tau, len(H)) > 0)  # it is 0 without a face
    A = (S + diagonal_matrix(H_over_tau)).tocsc()
    return LinearSystem(A, -(S @ step.vertices), H_over_tau[:, None] * step.vertices, H, np.empty(0, dtype=np.int64))


def _least_squares(step: ContractionStepInput) -> LinearSystem:
    """(W_H^2 + W_L^2 L^T L) D = -W_L^2 L^T (L V - T)."""
    V, H = step.vertices, step.shrinkage
    L, treatment = step.treated_rows
    W2 = diagonal_matrix(np.broadcast_to(step.weight, len(V)))
    A = diagonal_matrix(H) + L.T @ W2 @ L
    T = treatment.right_hand_side(V)
    B = -(L.T @ (W2 @ (L @ V - T)))
    return LinearSystem(A.tocsc(), B, H[:, None] * V + L.T @ (W2 @ T), H, treatment.changed_rows)


def stacked_system(step: ContractionStepInput) -> tuple[csr_array, NDArray[np.float64]]:
    """Build K = [W_L L; W_H] and its right-hand side, whose least-squares solution is the displacement of a step.

    Returns
    -------
    K : (2 n, n) csr_array
    right_hand_side : (2 n, 3) array of float
    """
    L, treatment = step.treated_rows
    V = step.vertices
    W = diags_array(np.broadcast_to(np.sqrt(step.weight), len(V)))
    K = vstack([W @ L, diags_array(np.sqrt(step.shrinkage))]).tocsr()
    return K, np.concatenate([-W @ (L @ V - treatment.right_hand_side(V)), np.zeros_like(V)])


ENERGIES: dict[str, Callable[[ContractionStepInput], LinearSystem]] = {
    "curvature_flow": _curvature_flow,
    "least_squares": _least_squares,
}
"""Functions from the input of a step to its linear system, by name."""
