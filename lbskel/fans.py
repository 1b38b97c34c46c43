"""The fans of faces round the vertices of a closed, oriented, edge-manifold surface.

A side of a face is numbered like the corner opposite it, as in ``Mesh.half_edges``. From a corner, the next one round
its vertex lies across the side that leaves it; the corners of one fan share the least number on their round, which is
found in leaps of twice the length each time (pointer jumping: Wyllie 1979, "The complexity of parallel computations").
"""

from __future__ import annotations

__all__ = ["count_fans"]

import numpy as np
from numpy.typing import NDArray


def count_fans(edge_of_side: NDArray[np.int64]) -> int:
    """How many fans there are: one for each vertex, or more where the surface is pinched to a point.

    Parameters
    ----------
    edge_of_side : (3m,) array of int
        The edge of each side; every edge has two.
    """
    n = len(edge_of_side)
    by_edge = np.argsort(edge_of_side, kind="stable").reshape(-1, 2)
    twin = np.empty(n, dtype=np.int64)
    twin[by_edge[:, 0]], twin[by_edge[:, 1]] = by_edge[:, 1], by_edge[:, 0]
    m = n // 3
    following = (np.roll(twin, m) - m) % n
    least = np.minimum(np.arange(n), following)
    while True:
        following = following[following]
        lower = np.minimum(least, least[following])
        if np.array_equal(lower, least):
            return int((least == np.arange(n)).sum())
        least = lower
