"""What a step of the contraction minimises: a pull along the Laplacian against a hold on every vertex.

- ``first_order``:    tau V'^T S V' + (V' - V)^T H (V' - V),  H = M_0 A_0 / A_t
- ``least_squares``:  W_L^2 ||L V'||^2 + (V' - V)^T W_H^2 (V' - V),  L = 2 S,  W_H^2 = A_0 / A_t

A_0 and A_t are the areas of a vertex's ring of triangles at the start and now, M_0 the areas of the vertices: what has
become thin is held harder. The second is Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
https://doi.org/10.1145/1399504.1360643, equations 4 to 6; the first holds the backward Euler flow of Desbrun, Meyer,
Schroeder, Barr 1999, https://doi.org/10.1145/311535.311576, by the same weights. Both are solved for the displacement.
"""

from __future__ import annotations

__all__ = ["ENERGIES", "Pull", "System"]

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from lbskel.operators import Laplacian


@dataclass(frozen=True, eq=False)
class Pull:
    """What an energy needs to know to set up a step."""

    laplacian: Laplacian
    vertices: NDArray[np.float64]
    weight: float
    area_kept: NDArray[np.float64]  # A_0 / A_t, the square of Au's W_H
    start_mass: NDArray[np.float64]
    identity_rows: NDArray[np.int64]
    holds_rows: bool


System: TypeAlias = tuple[csc_array, NDArray[np.float64], NDArray[np.float64]]


def _first_order(pull: Pull) -> System:
    """(H + tau S) D = -tau S V."""
    S = pull.laplacian.stiffness * pull.weight
    H = pull.start_mass * pull.area_kept
    return (S + diags_array(H, format="csc")).tocsc(), -(S @ pull.vertices), H


def _least_squares(pull: Pull) -> System:
    """(W_H^2 + W_L^2 L^T L) D = -W_L^2 L^T (L V - target), where only identity rows have a target."""
    V, rows = pull.vertices, pull.identity_rows
    L = (2 * pull.laplacian.stiffness).tocsr()
    if len(rows):
        keep = np.ones(len(V))
        keep[rows] = 0
        L = (diags_array(keep) @ L + diags_array(1 - keep)).tocsr()
    unexplained = L @ V
    if len(rows) and pull.holds_rows:
        unexplained[rows] -= V[rows]
    H = pull.area_kept
    A = diags_array(H, format="csc") + pull.weight * (L.T @ L)
    return A.tocsc(), -pull.weight * (L.T @ unexplained), H


ENERGIES: dict[str, Callable[[Pull], System]] = {"first_order": _first_order, "least_squares": _least_squares}
