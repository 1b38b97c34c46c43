"""Cotangents of the angles at triangle corners, and the test for degenerate ones.

cot = (a . b) / |a x b| for the edges a, b at a corner. The cross product is taken of the two shortest edges of the
triangle, which loses the fewest digits where it is thin. A triangle is degenerate if its area is zero up to the
rounding of the coordinates (:func:`degenerate_faces`), wherever it is. Operators that use the angles of the given
triangles give all three corners of such a face weight zero and list its vertices as treated; ``clamped_cotangent``
clamps the angle instead, and operators with mollified lengths lengthen the edges.
"""

from __future__ import annotations

__all__ = [
    "MAX_COTANGENT",
    "corner_cotangents",
    "degenerate_faces",
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
from lbskel.geometry.scaling import unit_vertices
from lbskel.geometry.sorting import distinct

EPSILON = float(np.finfo(np.float64).eps)
MAX_COTANGENT = 1 / EPSILON  # 4.5e15, no unit, of triangles known by their lengths: the angle is below their rounding
# Height of a degenerate triangle over its longest edge, in units of the rounding EPSILON M of the largest coordinate M.
# Three coordinates rounded to EPSILON M / 2 move a vertex by sqrt(3) / 2 and its distance from the line of two others
# by sqrt(3) such units; those of a mesh that was turned and moved are rounded twice, which is 2 sqrt(3) = 3.5.
MAX_HEIGHT = 4.0


def edge_vectors(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the (m, 3) vectors of the edges opposite the corners, by :func:`unit_vertices`; they sum to zero."""
    V = unit_vertices(mesh)[0]
    A, B, C = V.take(mesh.faces.T, axis=0)
    return C - B, A - C, B - A


def row_dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (m,) dot products of the rows of two (m, 3) arrays."""
    result: NDArray[np.float64] = np.einsum("mx,mx->m", a, b)
    return result


def corner_cotangents(mesh: Mesh) -> NDArray[np.float64]:
    """Return the (m, 3) cotangents of the corner angles: infinite at 0 and 180 degrees, NaN where undefined."""
    dots, _, double_areas = corner_products(unit_vertices(mesh)[0], mesh.faces)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cotangents: NDArray[np.float64] = dots / double_areas[:, None]
    return cotangents


def degenerate_faces(mesh: Mesh) -> NDArray[np.bool_]:
    """Return the (m,) mask of the faces that have no area, up to the rounding of the coordinates."""
    V = unit_vertices(mesh)[0]
    _, squared_lengths, double_areas = corner_products(V, mesh.faces)
    rounding = EPSILON * np.abs(V).max()
    is_degenerate: NDArray[np.bool_] = double_areas <= MAX_HEIGHT * rounding * np.sqrt(squared_lengths.max(axis=1))
    return is_degenerate


def zero_degenerate(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Set the rows of cotangents of lengths to zero in which one is beyond MAX_COTANGENT or NaN, and return the mask.

    Parameters
    ----------
    values : (m, 3) array of float

    Returns
    -------
    values : (m, 3) array of float
    degenerate : (m, 3) array of bool
        The same in all columns.
    """
    a, b, c = (np.abs(values) <= MAX_COTANGENT).T
    is_degenerate = ~(a & b & c)[:, None]
    return np.where(is_degenerate, 0.0, values), np.broadcast_to(is_degenerate, values.shape)


def incident_vertices(mesh: Mesh, is_marked: Any) -> NDArray[np.int64]:
    """Return the (v,) vertices of all faces with a marked corner, given an (m, k) mask, in ascending order."""
    return distinct(mesh.faces[is_marked.any(axis=1)].ravel())
