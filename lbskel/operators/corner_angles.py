"""Angles at the corners of triangles, and what counts as degenerate.

cot = (a . b) / |a x b| for the edges a, b at a corner. The cross product is that of the two shortest edges of the
triangle, which loses least where it is thin. A cotangent beyond ``LIMIT`` belongs to an angle that positions in double
precision cannot tell from 0 or 180 degrees: every operator gives such a corner no weight, and lists its vertices.
"""

from __future__ import annotations

__all__ = [
    "LIMIT",
    "corner_cotangents",
    "edge_vectors",
    "products",
    "touched_vertices",
    "without_degenerate",
]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.triangles import corners_of
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale

LIMIT = 1 / np.finfo(np.float64).eps


def edge_vectors(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The (m, 3) vectors along the edge opposite each corner, on the mesh scaled by :func:`unit_scale`; sum zero."""
    V = unit_scale(mesh.vertices)[0]
    A, B, C = (V[mesh.faces[:, k]] for k in range(3))
    return C - B, A - C, B - A


def products(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) scalar products of the rows."""
    return np.einsum("mx,mx->m", a, b)


def corner_cotangents(mesh: Mesh) -> NDArray[np.float64]:
    """(m, 3) cotangent of the angle at each corner of each face; infinite at 0 and 180 degrees, NaN at no angle."""
    scalar, _, double_areas = corners_of(unit_scale(mesh.vertices)[0], mesh.faces)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return scalar / double_areas[:, None]


def without_degenerate(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(m, 3) values with zero wherever one is not within LIMIT, and which those are."""
    degenerate = np.logical_not(np.abs(values) <= LIMIT)
    return np.where(degenerate, 0.0, values), degenerate


def touched_vertices(mesh: Mesh, corners: Any) -> NDArray[np.int64]:
    """The vertices of the faces that have one of these (m, k) corners."""
    return np.unique(mesh.faces[corners.any(axis=1)])
