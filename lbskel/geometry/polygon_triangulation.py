"""Closed lines in space filled with the triangles of least area: rims of holes, and polygons that are not convex.

By dynamic programming over their stretches, Barequet, Sharir 1995, "Filling gaps in the boundary of a polyhedron",
https://doi.org/10.1016/0167-8396(94)00011-G. In a plane every triangulation that stays within the polygon has the
polygon's area, and every other one more.
"""

from __future__ import annotations

__all__ = ["MOST_EDGES", "least_area", "unfold"]

import numpy as np
from numpy.typing import NDArray

MOST_EDGES = 300  # of a line that is filled so: the work grows with the third power
AT_ONCE = 1_000_000  # stretches whose areas are held at a time


def least_area(
    rims: NDArray[np.float64], taken: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The triangulation of least area of each of some lines of as many corners.

    Parameters
    ----------
    rims : (p, k, 3) array of float
    taken : (p, k, k) array of bool, optional
        ``taken[p, i, j]`` forbids the edge from corner i to j > i.

    Returns
    -------
    triangles : (p, k - 2, 3) array of int
        Ascending numbers of corners.
    double_area : (p,) array of float
        Infinite where too many edges are forbidden: the triangles are then of no use.
    """
    p, k, _ = rims.shape
    cost, split = np.zeros((p, k, k)), np.zeros((p, k, k), dtype=np.int64)
    for gap in range(2, k):
        i = np.arange(k - gap)
        between = i[:, None] + np.arange(1, gap)
        A, B, C = rims[:, i, None], rims[:, between], rims[:, i + gap, None]
        area = np.linalg.norm(np.cross(B - A, C - A), axis=3)
        total = area + cost[:, i[:, None], between] + cost[:, between, i[:, None] + gap]
        best = total.argmin(axis=2)
        split[:, i, i + gap] = between[i, best]
        least = np.take_along_axis(total, best[:, :, None], 2)[:, :, 0]
        cost[:, i, i + gap] = least if taken is None else np.where(taken[:, i, i + gap], np.inf, least)
    rim, low, high = np.arange(p), np.zeros(p, dtype=np.int64), np.full(p, k - 1)
    found = []
    while len(rim):
        middle = split[rim, low, high]
        found.append(np.stack([rim, low, middle, high], axis=1))
        rim, low, high = np.tile(rim, 2), np.concatenate([low, middle]), np.concatenate([middle, high])
        is_open = high - low > 1
        rim, low, high = rim[is_open], low[is_open], high[is_open]
    rows = np.concatenate(found)
    return rows[np.argsort(rows[:, 0], kind="stable"), 1:].reshape(p, k - 2, 3), cost[:, 0, -1]


def unfold(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], polygon: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The triangles of fans with those of polygons that are not convex, which lie over each other, made anew.

    Each polygon keeps its number of triangles and their place in the order; those of over 300 corners stay fans.

    Parameters
    ----------
    vertices : (n, 3) array of float
    triangles : (m, 3) array of int
        Fans, each from the first corner of its polygon.
    polygon : (m,) array of int
        The polygon of each, in ascending order.
    """
    unit = vertices / max(np.abs(vertices).max(), np.finfo(float).tiny)
    A, B, C = unit[triangles].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A)
    across = np.stack([np.bincount(polygon, x) for x in normals.T], axis=1)
    is_folded = np.bincount(polygon, (normals * across[polygon]).sum(axis=1) < 0) > 0
    counts = np.bincount(polygon)
    starts = np.cumsum(counts) - counts
    unfolded = np.array(triangles)
    for count in np.unique(counts[is_folded & (counts + 2 <= MOST_EDGES)]):
        chosen = starts[is_folded & (counts == count)]
        at_once = 1 + AT_ONCE // (count + 2) ** 2
        for first in range(0, len(chosen), at_once):
            rows = chosen[first : first + at_once, None] + np.arange(count)
            corners = np.concatenate([triangles[rows[:, 0], :2], triangles[rows, 2]], axis=1)
            best, _ = least_area(unit[corners])
            unfolded[rows] = np.take_along_axis(corners, best.reshape(len(corners), -1), 1).reshape(best.shape)
    return unfolded
