"""Cotangents of the angles at triangle corners, and the test for degenerate ones.

cot = (a . b) / |a x b| for the edges a, b at a corner. The cross product is taken of the two shortest edges of the
triangle, which loses the fewest digits where it is thin. A cotangent beyond ``MAX_COTANGENT`` belongs to an angle that
double-precision positions cannot distinguish from 0 or 180 degrees. Operators that use the angles of the given
triangles give such a corner weight zero and list the vertices of its face as treated; ``clamped_cotangent`` clamps the
angle instead, and operators with mollified lengths lengthen the edges.
"""

from __future__ import annotations

__all__ = [
    "MAX_COTANGENT",
    "corner_cotangents",
    "edge_vectors",
    "incident_vertices",
    "row_dot",
    "zero_degenerate",
]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.triangles import corner_products
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.sorting import distinct

MAX_COTANGENT = 1 / np.finfo(np.float64).eps  # 4.5e15, no unit: the angle is below one rounding of the positions


def edge_vectors(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the (m, 3) vectors of the edges opposite the corners, scaled by :func:`unit_scale`; they sum to zero."""
    V = unit_scale(mesh.vertices)[0]
    A, B, C = (V[mesh.faces[:, k]] for k in range(3))
    return C - B, A - C, B - A


def row_dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (m,) dot products of the rows of two (m, 3) arrays."""
    result: NDArray[np.float64] = np.einsum("mx,mx->m", a, b)
    return result


def corner_cotangents(mesh: Mesh) -> NDArray[np.float64]:
    """Return the (m, 3) cotangents of the corner angles: infinite at 0 and 180 degrees, NaN where undefined."""
    dots, _, double_areas = corner_products(unit_scale(mesh.vertices)[0], mesh.faces)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cotangents: NDArray[np.float64] = dots / double_areas[:, None]
    return cotangents


def zero_degenerate(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Set values beyond MAX_COTANGENT, infinite ones and NaN to zero; return them with the mask of those set."""
    degenerate = np.logical_not(np.abs(values) <= MAX_COTANGENT)
    return np.where(degenerate, 0.0, values), degenerate


def incident_vertices(mesh: Mesh, is_marked: Any) -> NDArray[np.int64]:
    """Return the (v,) vertices of all faces with a marked corner, given an (m, k) mask, in ascending order."""
    return distinct(mesh.faces[is_marked.any(axis=1)].ravel())
