"""Intrinsic Delaunay triangulations: edges flipped one after the other, on edge lengths alone.

A triangulation is faces, the length of the edge opposite each corner, and the half-edge glued to each: faces may use a
vertex twice and two faces may share two edges. An edge is flipped while the cotangents opposite it sum to less than
zero; the new length is that of the other diagonal of the two triangles unfolded in the plane. Fisher, Springborn,
Schroeder, Bobenko 2007, "An algorithm for the construction of intrinsic Delaunay triangulations with applications to
digital geometry processing", https://doi.org/10.1007/s00607-007-0249-8. libigl's flips of the same paper do not end on
some thin triangles, and are wrong or abort on faces that are not oriented alike, or where there is a boundary.
"""

from __future__ import annotations

__all__ = ["IntrinsicTriangulation", "cotangents_of_lengths", "delaunay", "half_edge_twins"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.delaunay_flips import cotangents, flip_to_delaunay
from lbskel.geometry.sorting import stable_order

FLIPS = 1_000  # of each edge, at most


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """(m, 3) faces and lengths, and for half-edge 3 f + k, opposite corner k of face f, its twin or -1."""

    faces: NDArray[np.int64]
    lengths: NDArray[np.float64]
    twins: NDArray[np.int64]


def half_edge_twins(faces: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """(3m,) twin of each half-edge, -1 at the boundary; None unless each edge has at most two faces, oriented alike."""
    start, end = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    n = int(faces.max()) + 1
    key = np.minimum(start, end) * n + np.maximum(start, end)
    order = stable_order(key)
    same = key[order[1:]] == key[order[:-1]]
    first, second = order[:-1][same], order[1:][same]
    if (same[1:] & same[:-1]).any() or (start[first] == start[second]).any() or (start == end).any():
        return None
    twins = np.full(len(key), -1)
    twins[first], twins[second] = second, first
    return twins


def cotangents_of_lengths(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3) cotangents of the angles opposite the edges of triangles with these lengths."""
    result = np.empty(lengths.size)
    cotangents(np.ascontiguousarray(lengths).ravel(), result)
    return result.reshape(-1, 3)


def delaunay(triangulation: IntrinsicTriangulation) -> IntrinsicTriangulation:
    """The Delaunay triangulation of the same surface; after FLIPS of each edge as near to it as they have come."""
    F, L, T = triangulation.faces.flatten(), triangulation.lengths.flatten(), triangulation.twins.copy()
    flip_to_delaunay(F, L, T, FLIPS * len(T))
    return IntrinsicTriangulation(F.reshape(-1, 3), L.reshape(-1, 3), T)
