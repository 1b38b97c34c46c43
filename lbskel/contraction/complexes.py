"""The faces and edges of a contracted mesh while it collapses to a graph, and which of them may be removed.

In all functions n is the number of vertices. The key of an edge is ``low * n + high``.
"""

from __future__ import annotations

__all__ = [
    "Complex",
    "closing_edges",
    "free_edges",
    "has_face",
    "keys_of",
    "open_surfaces",
    "remove_free_edges",
    "unique_rows",
]

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import distinct, is_among


@dataclass(frozen=True, eq=False)
class Complex:
    """The faces and edges not yet collapsed, and removed edges, along which patches of the surface still meet.

    Parameters
    ----------
    faces : (m, 3) array of int
        With ascending corners.
    edges : (k, 2) array of int
        With ascending ends.
    cochain : (k, 1) array of int
        Value of each edge from its lower to its higher end, modulo 2^64.
    is_removed : (k,) array of bool
        Whether an edge has been removed, together with its last face, and is no edge of the graph.
    """

    faces: NDArray[np.int64]
    edges: NDArray[np.int64]
    cochain: NDArray[np.int64]
    is_removed: NDArray[np.bool_]


def keys_of(edges: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """(k,) unique number of each ordered pair of n vertices, given as a (k, 2) array."""
    keys: NDArray[np.int64] = edges[:, 0] * n + edges[:, 1]
    return keys


def has_face(remaining: Complex, n: int) -> NDArray[np.bool_]:
    """(k,) whether each edge belongs to a face."""
    return is_among(keys_of(remaining.edges, n), _keys_at_sides(remaining, n))


def _keys_at_sides(remaining: Complex, n: int) -> NDArray[np.int64]:
    """(3m,) number of the pair of vertices at each side of each face."""
    return np.concatenate([keys_of(remaining.faces[:, pair], n) for pair in ([0, 1], [0, 2], [1, 2])])


def unique_rows(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the distinct rows of an (m, 3) array in lexicographic order."""
    faces = faces[np.lexsort(faces.T[::-1])]
    is_new = np.ones(len(faces), dtype=bool)
    is_new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    return faces[is_new]


def free_edges(remaining: Complex, n: int) -> NDArray[np.int64]:
    """(f,) keys of the edges that belong to exactly one face."""
    keys, count = np.unique(_keys_at_sides(remaining, n), return_counts=True)
    free: NDArray[np.int64] = keys[count == 1]
    return free


def remove_free_edges(remaining: Complex, free: NDArray[np.int64], P: NDArray[np.float64], n: int) -> Complex:
    """Remove the longest free edge of each face that has one, and the face, which neither opens nor closes a loop."""
    keys = _keys_at_sides(remaining, n).reshape(3, -1)
    lengths = vector_lengths(P[keys // n] - P[keys % n])
    lengths[~is_among(keys, free)] = -1
    longest = np.argmax(lengths, axis=0)
    has_free_edge = lengths.max(axis=0) >= 0
    removed = keys[longest, np.arange(keys.shape[1])][has_free_edge]
    is_removed = remaining.is_removed | is_among(keys_of(remaining.edges, n), removed)
    return replace(remaining, faces=remaining.faces[~has_free_edge], is_removed=is_removed)


def open_surfaces(remaining: Complex, n: int) -> Complex:
    """Remove the first face of each connected part of the faces."""
    part = component_roots(
        np.concatenate([remaining.faces[:, :2], remaining.faces[:, 1:]]), np.zeros(n, dtype=np.int64)
    )
    _, first = np.unique(part[remaining.faces[:, 0]], return_index=True)
    return replace(remaining, faces=np.delete(remaining.faces, first, axis=0))


def closing_edges(remaining: Complex, n: int) -> NDArray[np.int64]:
    """(c,) keys of the edges that cannot collapse: those of triangles around which the cochain does not sum to zero."""
    pairs = np.concatenate([remaining.edges, remaining.edges[:, ::-1]])
    order = np.argsort(keys_of(pairs, n))
    pairs, values = pairs[order], np.concatenate([remaining.cochain, -remaining.cochain])[order]
    keys, first = keys_of(pairs, n), np.searchsorted(pairs[:, 0], np.arange(n + 1))
    degrees = np.diff(first)
    # every edge from the end with fewer neighbors, each of which may be the third corner of a triangle
    edge = np.flatnonzero(degrees[pairs[:, 0]] <= degrees[pairs[:, 1]])
    sizes = degrees[pairs[edge, 0]]
    place = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    edge = np.repeat(edge, sizes)
    to_third = first[pairs[edge, 0]] + place
    sides = np.stack([pairs[edge, 1], pairs[to_third, 1]], axis=1)
    third = np.minimum(np.searchsorted(keys, keys_of(sides, n)), len(keys) - 1)
    is_triangle = keys[third] == keys_of(sides, n)
    differs = is_triangle & (values[edge] + values[third] != values[to_third]).any(axis=1)
    return distinct(keys_of(np.sort(pairs[edge[differs]], axis=1), n))
