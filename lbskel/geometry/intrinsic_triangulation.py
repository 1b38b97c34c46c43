"""Intrinsic Delaunay triangulations by edge flips on edge lengths alone.

A triangulation consists of its faces, the length of the edge opposite each corner, and the twin of each half-edge. A
face may use a vertex twice, and two faces may share two edges. An edge is flipped while the cotangents opposite it sum
to less than zero; its new length is that of the other diagonal of the two triangles unfolded in the plane. Fisher,
Springborn, Schroeder, Bobenko 2007, "An algorithm for the construction of intrinsic Delaunay triangulations with
applications to digital geometry processing", https://doi.org/10.1007/s00607-007-0249-8. libigl's flips by the same
paper do not terminate on some thin triangles, and are wrong or abort where faces are oriented inconsistently or there
is a boundary.
"""

from __future__ import annotations

__all__ = ["IntrinsicTriangulation", "cotangents_of_lengths", "delaunay", "half_edge_twins", "interior_twins"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.delaunay_flips import cotangents, flip_to_delaunay
from lbskel.geometry.sorting import stable_order

MAX_FLIPS_PER_HALF_EDGE = 1_000  # flips end for exact lengths; a guess, against cycles caused by rounding


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """A triangulation given by edge lengths.

    Parameters
    ----------
    faces : (m, 3) array of int
    lengths : (m, 3) array of float
        Length of the edge opposite each corner.
    twins : (3m,) array of int
        For half-edge 3 f + k, opposite corner k of face f, the other half-edge of its edge, or -1 at the boundary.
    """

    faces: NDArray[np.int64]
    lengths: NDArray[np.float64]
    twins: NDArray[np.int64]


def half_edge_twins(faces: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Find the (3m,) twin of each half-edge, -1 at the boundary.

    Returns None if an edge has more than two faces or two that are not oriented consistently, or a face uses a vertex
    twice.

    Parameters
    ----------
    faces : (m, 3) array of int
    """
    start, end, order, same = _by_edge(faces)
    first, second = order[:-1][same], order[1:][same]
    if (same[1:] & same[:-1]).any() or (start[first] == start[second]).any() or (start == end).any():
        return None
    twins = np.full(len(order), -1)
    twins[first], twins[second] = second, first
    return twins


def _by_edge(
    faces: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """List starts and ends of the (3m,) half-edges, their order by edge, and whether each has the edge of the next."""
    start, end = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    key = np.minimum(start, end) * (int(faces.max(initial=0)) + 1) + np.maximum(start, end)
    order = stable_order(key)
    return start, end, order, key[order[1:]] == key[order[:-1]]


def interior_twins(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the (3m,) twin of each half-edge whose edge has two faces, oriented consistently; -1 at all other edges.

    Parameters
    ----------
    faces : (m, 3) array of int
        None uses a vertex twice.
    """
    start, _, order, same = _by_edge(faces)
    same = np.pad(same, 1)
    is_pair = same[1:-1] & ~same[:-2] & ~same[2:]
    first, second = order[:-1][is_pair], order[1:][is_pair]
    is_consistent = start[first] != start[second]
    first, second = first[is_consistent], second[is_consistent]
    twins = np.full(len(order), -1)
    twins[first], twins[second] = second, first
    return twins


def cotangents_of_lengths(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (m, 3) cotangents of the angles opposite the edges of triangles with these (m, 3) lengths."""
    result = np.empty(lengths.size)
    cotangents(np.ascontiguousarray(lengths).ravel(), result)
    return result.reshape(-1, 3)


def delaunay(triangulation: IntrinsicTriangulation) -> IntrinsicTriangulation:
    """Flip edges until the triangulation is Delaunay, or the limit on the number of flips is reached."""
    F, L, T = triangulation.faces.flatten(), triangulation.lengths.flatten(), triangulation.twins.copy()
    flip_to_delaunay(F, L, T, MAX_FLIPS_PER_HALF_EDGE * len(T))
    return IntrinsicTriangulation(F.reshape(-1, 3), L.reshape(-1, 3), T)
