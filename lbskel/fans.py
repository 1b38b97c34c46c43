"""The fans of faces round the vertices of a closed, oriented, edge-manifold surface.

A side of a face is numbered like the corner opposite it, as in ``Mesh.half_edges``.
"""

from __future__ import annotations

__all__ = ["count_fans"]

import numpy as np
from numpy.typing import NDArray

from lbskel.kernels.regions import fans


def count_fans(edge_of_side: NDArray[np.int64]) -> int:
    """How many fans there are: one for each vertex, or more where the surface is pinched to a point.

    Parameters
    ----------
    edge_of_side : (3m,) array of int
        The edge of each side; every edge has two.
    """
    sides = np.arange(len(edge_of_side))
    both = np.bincount(edge_of_side, weights=sides).astype(np.int64)  # the sum of its two sides
    return fans(both[edge_of_side] - sides)
