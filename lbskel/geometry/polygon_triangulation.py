"""Triangulation of minimum area of closed polygons in space: boundary loops of holes, and nonconvex faces.

Dynamic programming over chains of edges, Barequet, Sharir 1995, "Filling gaps in the boundary of a polyhedron",
https://doi.org/10.1016/0167-8396(94)00011-G. In a plane, every triangulation that stays inside the polygon has the
polygon's area, and every other one has more. Faces with more corners than that has time for are taken as planar, and
triangulated by :mod:`lbskel.geometry.ear_clipping`.
"""

from __future__ import annotations

__all__ = ["MAX_POLYGON_EDGES", "min_area_triangulation", "retriangulate_nonconvex"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import were
from lbskel.geometry.ear_clipping import clip_ears
from lbskel.geometry.normals import triangle_normals

MAX_POLYGON_EDGES = 300  # edges of a polygon that is triangulated so; a guess: the time grows with their third power
MAX_TABLE_ENTRIES = 1_000_000  # entries of the tables of areas held at a time; a guess that bounds the memory


def min_area_triangulation(
    polygons: NDArray[np.float64], forbidden: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Triangulate each of p polygons of k corners with minimum area.

    Parameters
    ----------
    polygons : (p, k, 3) array of float
    forbidden : (p, k, k) array of bool, optional
        ``forbidden[p, i, j]`` excludes the edge from corner i to j > i.

    Returns
    -------
    triangles : (p, k - 2, 3) array of int
        Corner indices, ascending in each triangle.
    double_area : (p,) array of float
        Infinite where the forbidden edges leave no triangulation; the triangles are then invalid.
    """
    p, k, _ = polygons.shape
    cost, split = np.zeros((p, k, k)), np.zeros((p, k, k), dtype=np.int64)
    for gap in range(2, k):
        i = np.arange(k - gap)
        between = i[:, None] + np.arange(1, gap)
        A, B, C = polygons[:, i, None], polygons[:, between], polygons[:, i + gap, None]
        area = np.linalg.norm(triangle_normals(A, B, C), axis=3)
        total = area + cost[:, i[:, None], between] + cost[:, between, i[:, None] + gap]
        best = total.argmin(axis=2)
        split[:, i, i + gap] = between[i, best]
        lowest = np.take_along_axis(total, best[:, :, None], 2)[:, :, 0]
        cost[:, i, i + gap] = lowest if forbidden is None else np.where(forbidden[:, i, i + gap], np.inf, lowest)
    polygon, low, high = np.arange(p), np.zeros(p, dtype=np.int64), np.full(p, k - 1)
    found = []
    while len(polygon):
        middle = split[polygon, low, high]
        found.append(np.stack([polygon, low, middle, high], axis=1))
        polygon, low, high = np.tile(polygon, 2), np.concatenate([low, middle]), np.concatenate([middle, high])
        is_open = high - low > 1
        polygon, low, high = polygon[is_open], low[is_open], high[is_open]
    rows = np.concatenate(found)
    return rows[np.argsort(rows[:, 0], kind="stable"), 1:].reshape(p, k - 2, 3), cost[:, 0, -1]


def retriangulate_nonconvex(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], polygon: NDArray[np.int64]
) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Replace the fans of nonconvex polygons, whose triangles overlap, by triangulations of minimum area.

    Each polygon keeps its number of triangles and their rows. Polygons of more than 300 corners are triangulated in a
    plane.

    Parameters
    ----------
    vertices : (n, 3) array of float
    triangles : (m, 3) array of int
        Fans, each from the first corner of its polygon.
    polygon : (m,) array of int
        The polygon of each triangle, in ascending order.

    Returns
    -------
    triangles : (m, 3) array of int
    notes : tuple of str
        Which polygons stay fans, since their outline crosses itself in the plane; empty for none.
    """
    unit = vertices / max(np.abs(vertices).max(), np.finfo(float).tiny)
    A, B, C = unit[triangles].transpose(1, 0, 2)
    normals = triangle_normals(A, B, C)
    polygon_normals = np.stack([np.bincount(polygon, x) for x in normals.T], axis=1)
    is_folded = np.bincount(polygon, (normals * polygon_normals[polygon]).sum(axis=1) < 0) > 0
    counts = np.bincount(polygon)
    starts = np.cumsum(counts) - counts
    result = np.array(triangles)
    for count in np.unique(counts[is_folded & (counts + 2 <= MAX_POLYGON_EDGES)]):
        chosen = starts[is_folded & (counts == count)]
        block_size = 1 + MAX_TABLE_ENTRIES // (count + 2) ** 2
        for first in range(0, len(chosen), block_size):
            rows = chosen[first : first + block_size, None] + np.arange(count)
            corners = np.concatenate([triangles[rows[:, 0], :2], triangles[rows, 2]], axis=1)
            best, _ = min_area_triangulation(unit[corners])
            result[rows] = np.take_along_axis(corners, best.reshape(len(corners), -1), 1).reshape(best.shape)
    crossing = []
    for number in np.flatnonzero(is_folded & (counts + 2 > MAX_POLYGON_EDGES)).tolist():
        rows = starts[number] + np.arange(counts[number])
        corners = np.append(triangles[rows[0], :2], triangles[rows, 2])
        normal = polygon_normals[number]
        clipped = clip_ears(unit[corners] @ _plane(normal)) if normal.any() else None
        if clipped is None:
            crossing.append(number)
        else:
            result[rows] = corners[clipped]
    if not crossing:
        return result, ()
    note = (
        f"{were(len(crossing), 'polygon')} cut into triangles that overlap, the first of them polygon {crossing[0]}: "
        f"its outline of {counts[crossing[0]] + 2:,} corners crosses itself"
    )
    return result, (note,)


def _plane(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 2) two axes at right angles to a normal, around which they turn counter-clockwise."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    axes = np.stack([first, np.cross(normal, first)], axis=1)
    return np.asarray(axes / np.linalg.norm(axes, axis=0))
