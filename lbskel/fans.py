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
    sides: NDArray[np.integer] = np.arange(n, dtype=np.int32 if n < 2**31 else np.int64)  # half to read
    both = np.bincount(edge_of_side, weights=sides).astype(np.int64)  # the sum of its two sides
    twin = both[edge_of_side] - sides
    m = n // 3
    following = ((np.roll(twin, m) - m) % n).astype(sides.dtype)
    least = np.minimum(sides, following)
    while True:
        following = following[following]
        lower = np.minimum(least, least[following])
        if np.array_equal(lower, least):
            return int((least == sides).sum())
        least = lower
