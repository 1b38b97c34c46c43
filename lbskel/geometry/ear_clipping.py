"""Triangulation of long planar polygons by ear clipping: Meisters 1975, https://doi.org/10.2307/2319703.

An ear is a corner whose triangle with its neighbors has no other corner in it; it is cut off, and the rest is treated
the same. Triangles that all turn as the polygon does cover what it encloses once.
"""

from __future__ import annotations

__all__ = ["clip_ears"]

from bisect import bisect_left, bisect_right
from collections import deque

import numpy as np
from numpy.typing import NDArray

# Corners looked at for each corner of the polygon, at most, which bounds the time. Outlines of 5,000 corners, of gears,
# stars, combs, rings, spirals and random ones, took less than 4, and 0.3 to 0.7 s
MAX_TRIALS = 10

COLLINEAR = 1e-14  # double area, relative to the square of the extent, up to which three corners are in line; a guess


def clip_ears(polygon: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Triangulate a simple polygon in the plane; None if that fails, as where it crosses itself.

    Parameters
    ----------
    polygon : (k, 2) array of float
        Corners, counter-clockwise.

    Returns
    -------
    (k - 2, 3) array of int
        Corners of each triangle, counter-clockwise.
    """
    k = len(polygon)
    x, y = (polygon - polygon.min(axis=0)).T.tolist()
    tolerance = COLLINEAR * max(*x, *y) ** 2
    before, after = [k - 1, *range(k - 1)], [*range(1, k), 0]

    def turn(b: int) -> float:
        a, c = before[b], after[b]
        return float((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]))

    order = np.argsort(x, kind="stable")
    rank = np.argsort(order).tolist()
    X, Y = np.array(x)[order], np.array(y)[order]
    sorted_x = X.tolist()
    is_blocking = np.array([turn(b) <= tolerance for b in order.tolist()])  # only these can lie in an ear

    def is_ear(b: int) -> bool:
        a, c = before[b], after[b]
        first = bisect_left(sorted_x, min(x[a], x[b], x[c]))
        last = bisect_right(sorted_x, max(x[a], x[b], x[c]))
        chosen = np.flatnonzero(is_blocking[first:last]) + first
        px, py = X[chosen], Y[chosen]
        is_inside = np.ones(len(chosen), dtype=bool)
        for i, j in ((a, b), (b, c), (c, a)):
            is_inside &= (x[j] - x[i]) * (py - y[i]) - (y[j] - y[i]) * (px - x[i]) >= 0
            is_inside &= (px != x[i]) | (py != y[i])  # corners at one place, as at the ends of a bridge to a hole
        return not is_inside.any()

    triangles: list[tuple[int, int, int]] = []
    waiting, is_cut, n_before, is_relaxed = deque(range(k)), [False] * k, 0, False
    for _ in range(MAX_TRIALS * k):
        if len(triangles) == k - 2:
            return np.array(triangles)
        if not waiting:  # others than the neighbors of ears may have become ears
            waiting.extend(b for b in range(k) if not is_cut[b])
            n_before, is_relaxed = len(triangles), len(triangles) == n_before
        b = waiting.popleft()
        angle = turn(b)
        # without an ear, corners in line, and any that turn as the polygon does
        if is_cut[b] or not (angle >= -tolerance if is_relaxed else angle > tolerance and is_ear(b)):
            continue
        a, c = before[b], after[b]
        triangles.append((a, b, c))
        after[a], before[c] = c, a
        is_cut[b], is_blocking[rank[b]], is_relaxed = True, False, False
        for neighbor in (a, c):
            is_blocking[rank[neighbor]] = turn(neighbor) <= tolerance
            waiting.append(neighbor)
    return None
