"""Intrinsic Delaunay triangulations: edges flipped in rounds of independent flips, on edge lengths alone.

A triangulation is faces, the length of the edge opposite each corner, and the half-edge glued to each: faces may use a
vertex twice and two faces may share two edges. An edge is flipped while the cotangents opposite it sum to less than
zero; the new length is that of the other diagonal of the two triangles unfolded in the plane. Fisher, Springborn,
Schroeder, Bobenko 2007, "An algorithm for the construction of intrinsic Delaunay triangulations with applications to
digital geometry processing", https://doi.org/10.1007/s00607-007-0249-8. libigl's flips of the same paper do not end on
some thin triangles, and are wrong or abort on faces that are not oriented alike, or where there is a boundary.
"""

from __future__ import annotations

__all__ = ["IntrinsicTriangulation", "cotangents_of_lengths", "delaunay", "glued"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.ordering import stable_order

TOLERANCE = 1e-9
ROUNDS = 10_000


@dataclass(frozen=True, eq=False)
class IntrinsicTriangulation:
    """(m, 3) faces and lengths, and for half-edge 3 f + k, opposite corner k of face f, its twin or -1."""

    faces: NDArray[np.int64]
    lengths: NDArray[np.float64]
    twins: NDArray[np.int64]


def glued(faces: NDArray[np.int64]) -> NDArray[np.int64] | None:
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


def _four_areas(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Four times the area of triangles with these edge lengths, by Heron's formula in Kahan's order."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    short, middle, long = np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)
    product = (long + (middle + short)) * (short - (long - middle)) * (short + (long - middle))
    return np.sqrt(np.maximum(product * (long + (middle - short)), 0.0))


def cotangents_of_lengths(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3) cotangents of the angles opposite the edges of triangles with these lengths."""
    squares = lengths**2
    with np.errstate(divide="ignore", invalid="ignore"):
        return (squares.sum(axis=1, keepdims=True) - 2 * squares) / _four_areas(*lengths.T)[:, None]


def _other_diagonal(
    ab: NDArray[np.float64],
    bc: NDArray[np.float64],
    ca: NDArray[np.float64],
    ad: NDArray[np.float64],
    db: NDArray[np.float64],
) -> NDArray[np.float64]:
    """|cd| of the triangles abc and bad, unfolded to both sides of ab."""
    along = (ca**2 - bc**2 - ad**2 + db**2) / (2 * ab)
    across = (_four_areas(ab, bc, ca) + _four_areas(ab, ad, db)) / (2 * ab)
    return np.hypot(along, across)


def _independent(edges: NDArray[np.int64], twins: NDArray[np.int64], taken: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which edges are first of all at both their faces, in an order that is mixed but always the same."""
    order = stable_order(edges * 2654435761 % 2**32)[::-1]
    faces = np.stack([edges // 3, twins // 3], axis=1)
    taken[faces[order].ravel()] = np.repeat(order, 2)  # of several at one face the last written stays
    return (taken[faces] == np.arange(len(edges))[:, None]).all(axis=1)


def delaunay(triangulation: IntrinsicTriangulation) -> IntrinsicTriangulation:
    """The Delaunay triangulation of the same surface; after ROUNDS rounds as near to it as the flips have come."""
    F, L, T = triangulation.faces.flatten(), triangulation.lengths.flatten(), triangulation.twins.copy()
    C = cotangents_of_lengths(triangulation.lengths).ravel()
    moved_to, taken, is_next = np.arange(len(T)), np.empty(len(T) // 3, dtype=np.int64), np.zeros(len(T), dtype=bool)
    edges = np.flatnonzero(np.arange(len(T)) < T)
    for _ in range(ROUNDS):
        twins = T[edges]
        slack = TOLERANCE * (1 + np.abs(C[edges]) + np.abs(C[twins]))
        flippable = (C[edges] + C[twins] < -slack) & (edges // 3 != twins // 3)
        edges, twins = edges[flippable], twins[flippable]
        if len(edges) == 0:
            break
        chosen = _independent(edges, twins, taken)
        touched = _flip(F, L, T, edges[chosen], twins[chosen], moved_to)
        C.reshape(-1, 3)[touched] = cotangents_of_lengths(L.reshape(-1, 3)[touched])
        around = (3 * touched[:, None] + np.arange(3)).ravel()
        edges = np.concatenate([edges[~chosen], around])
        edges = edges[T[edges] >= 0]
        is_next[np.minimum(edges, T[edges])] = True
        edges = np.flatnonzero(is_next)
        is_next[edges] = False
    return IntrinsicTriangulation(F.reshape(-1, 3), L.reshape(-1, 3), T)


def _flip(
    F: NDArray[np.int64],
    L: NDArray[np.float64],
    T: NDArray[np.int64],
    h: NDArray[np.int64],
    t: NDArray[np.int64],
    moved_to: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Flip edges that share no face, in place; the faces touched. Edge ab of abc and bad becomes cd of cad and dbc."""
    f, g = h // 3, t // 3
    h_a, h_b = 3 * f + (h + 1) % 3, 3 * f + (h + 2) % 3
    t_b, t_a = 3 * g + (t + 1) % 3, 3 * g + (t + 2) % 3
    a, b, c, d = F[h_a], F[h_b], F[h], F[t]
    bc, ca, ad, db = L[h_a], L[h_b], L[t_b], L[t_a]
    cd = _other_diagonal(L[h], bc, ca, ad, db)
    old, new = np.concatenate([t_b, h_b, h_a, t_a]), np.concatenate([3 * f, 3 * f + 2, 3 * g, 3 * g + 2])
    beyond = T[old]
    moved_to[old] = new
    beyond = np.where(beyond >= 0, moved_to[beyond], -1)
    moved_to[old] = old
    T[new] = beyond
    T[beyond[beyond >= 0]] = new[beyond >= 0]
    T[3 * f + 1], T[3 * g + 1] = 3 * g + 1, 3 * f + 1
    F[3 * f], F[3 * f + 1], F[3 * f + 2], F[3 * g], F[3 * g + 1], F[3 * g + 2] = c, a, d, d, b, c
    L[3 * f], L[3 * f + 1], L[3 * f + 2], L[3 * g], L[3 * g + 1], L[3 * g + 2] = ad, cd, ca, bc, cd, db
    return np.concatenate([f, g])
