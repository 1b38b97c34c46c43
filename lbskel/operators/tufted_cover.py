"""The tufted cover: two copies of every face, glued around each edge so that every edge has exactly two faces.

Around an edge, the faces are taken in the order of their angles; the side of each face towards the next one is glued to
the side of the next face towards it. So any triangle soup gets a closed edge-manifold cover on the same vertices, and a
boundary edge joins the two sides of its one face. Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes",
https://doi.org/10.1111/cgf.14069.
"""

from __future__ import annotations

__all__ = ["tufted_cover"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import normalized
from lbskel.geometry.sorting import stable_order, unique_inverse


def tufted_cover(V: NDArray[np.float64], F: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Build the tufted cover of a triangle soup.

    Parameters
    ----------
    V : (n, 3) array of float
    F : (m, 3) array of int
        No face uses a vertex twice.

    Returns
    -------
    faces : (2m, 3) array of int
        The faces, then their reversed copies.
    twins : (6m,) array of int
        For half-edge 3 f + k, opposite corner k of face f, the other half-edge of its edge.
    """
    m = len(F)
    start, end = F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()
    edge = unique_inverse(np.minimum(start, end) * len(V) + np.maximum(start, end))[1]
    order = _order_around_edges(V, F, edge, start > end)
    sorted_edges = edge[order]
    is_first = np.ones(3 * m, dtype=bool)
    np.not_equal(sorted_edges[1:], sorted_edges[:-1], out=is_first[1:])
    first = np.flatnonzero(is_first)
    following = np.arange(1, 3 * m + 1)
    following[np.append(first[1:], 3 * m) - 1] = first  # the last face around an edge precedes the first
    face, corner = np.divmod(np.arange(3 * m), 3)
    reversed_copy = 3 * (face + m) + np.array([0, 2, 1])[corner]
    # the front of a face looks towards larger angles if the face runs along its edge from the lower vertex
    looks_ahead = np.where(start < end, np.arange(3 * m), reversed_copy)[order]
    looks_back = np.where(start < end, reversed_copy, np.arange(3 * m))[order]
    twins = np.empty(6 * m, dtype=np.int64)
    twins[looks_ahead], twins[looks_back[following]] = looks_back[following], looks_ahead
    return np.concatenate([F, F[:, [0, 2, 1]]]), twins


def _order_around_edges(
    V: NDArray[np.float64], F: NDArray[np.int64], edge: NDArray[np.int64], is_reversed: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Order the half-edges by edge and, where an edge has more than two faces, by the angle of the face around it."""
    order = stable_order(edge)
    count = np.bincount(edge)
    crowded = order[(count > 2)[edge[order]]]
    if len(crowded) == 0:
        return order
    face, corner = np.divmod(crowded, 3)
    low, high = F[face, (corner + 1) % 3], F[face, (corner + 2) % 3]
    low, high = np.where(is_reversed[crowded], high, low), np.where(is_reversed[crowded], low, high)
    along, towards = normalized(V[high] - V[low]), V[F[face, corner]] - V[low]
    axis = np.argmin(np.abs(along), axis=1)  # the same for all faces of an edge, as is the reference direction
    reference = normalized(np.cross(along, np.eye(3)[axis]))
    angle = np.arctan2(
        np.einsum("ki,ki->k", towards, np.cross(along, reference)), np.einsum("ki,ki->k", towards, reference)
    )
    order[np.flatnonzero((count > 2)[edge[order]])] = crowded[np.lexsort((angle, edge[crowded]))]
    return order
