"""Faces that cut through other faces of the same mesh.

Pairs that may meet come from a grid of boxes; two triangles cut each other where an edge of one passes through the
other. Faces that share a vertex, and those that lie in one plane, do not count.
"""

from __future__ import annotations

__all__ = ["crossing_faces"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale

MOST_FACES = 10_000  # tested against all others; of larger meshes so many are picked evenly
MOST_PAIRS = 20_000_000  # tested in all
BLOCK = 1_000_000


def crossing_faces(mesh: Mesh) -> tuple[NDArray[np.int64], float]:
    """The faces that were found to cut through another, and which share of the faces was tested."""
    m = len(mesh.faces)
    mesh = mesh.with_vertices(unit_scale(mesh.vertices)[0])  # products of six lengths would overflow
    every = 1 + (m - 1) // MOST_FACES
    pairs = _near_pairs(mesh, np.arange(0, m, every))
    tested = 1.0 / every * min(1.0, MOST_PAIRS / max(len(pairs), 1))
    pairs = pairs[:MOST_PAIRS]
    found = []
    for first in range(0, len(pairs), BLOCK):
        one, other = pairs[first : first + BLOCK].T
        F, G = mesh.faces[one], mesh.faces[other]
        apart = ~(F[:, :, None] == G[:, None, :]).any(axis=(1, 2))
        one, other = one[apart], other[apart]
        P, Q = mesh.vertices[mesh.faces[one]], mesh.vertices[mesh.faces[other]]
        cuts = _passes_through(P, Q) | _passes_through(Q, P)
        found.append(np.unique(np.concatenate([one[cuts], other[cuts]])))
    return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *found])), tested


def _near_pairs(mesh: Mesh, chosen: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k, 2) pairs of a chosen face and any other whose boxes share a cell of a grid and overlap."""
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    size = max(float(np.percentile(high - low, 75)), 1e-3 * mesh.diagonal) or 1.0
    first = np.floor((low - low.min(axis=0)) / size).astype(np.int64)
    counts = np.floor((high - low.min(axis=0)) / size).astype(np.int64) - first + 1
    n_cells = counts.prod(axis=1)
    face = np.repeat(np.arange(len(low)), n_cells)
    number = np.arange(n_cells.sum()) - np.repeat(np.cumsum(n_cells) - n_cells, n_cells)
    x, rest = np.divmod(number, counts[face, 1] * counts[face, 2])
    y, z = np.divmod(rest, counts[face, 2])
    cell = first[face] + np.stack([x, y, z], axis=1)
    key = (cell[:, 0] << 42) + (cell[:, 1] << 21) + cell[:, 2]
    order = np.argsort(key, kind="stable")
    key, face = key[order], face[order]
    is_chosen = np.zeros(len(low), dtype=bool)
    is_chosen[chosen] = True
    begin, end = np.searchsorted(key, key, "left"), np.searchsorted(key, key, "right")
    here = np.flatnonzero(is_chosen[face])
    widths = (end - begin)[here]
    budget = np.cumsum(widths) <= 5 * MOST_PAIRS
    here, widths = here[budget], widths[budget]
    other = np.repeat(begin[here], widths) + np.arange(widths.sum()) - np.repeat(np.cumsum(widths) - widths, widths)
    pairs = np.stack([np.repeat(face[here], widths), face[other]], axis=1)
    i, j = pairs.T
    keep = (i != j) & ((i < j) | ~is_chosen[j])
    keep[keep] = ((low[i[keep]] <= high[j[keep]]) & (low[j[keep]] <= high[i[keep]])).all(axis=1)
    return np.stack(np.divmod(np.unique(i[keep] * len(low) + j[keep]), len(low)), axis=1)


def _passes_through(P: NDArray[np.float64], Q: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether an edge of each triangle of P passes through the inside of that of Q."""
    origin = Q[:, :1]
    one, two = Q[:, 1] - Q[:, 0], Q[:, 2] - Q[:, 0]
    normal = np.cross(one, two)
    height = np.einsum("kcx,kx->kc", P - origin, normal)
    ahead = np.roll(height, -1, axis=1)
    crosses = height * ahead < 0
    share = np.divide(height, height - ahead, out=np.zeros_like(height), where=crosses)
    point = P + share[:, :, None] * (np.roll(P, -1, axis=1) - P) - origin
    squared = np.einsum("kx,kx->k", normal, normal)[:, None]
    u = np.einsum("kcx,kx->kc", np.cross(point, two[:, None]), normal)
    v = np.einsum("kcx,kx->kc", np.cross(one[:, None], point), normal)
    return (crosses & (u > 0) & (v > 0) & (u + v < squared)).any(axis=1)
