"""Faces that intersect other faces of the same mesh.

Candidate pairs have bounding boxes that overlap in a uniform grid; two triangles intersect where an edge of one passes
through the other. Faces that share a vertex, and coplanar faces, do not count.
"""

from __future__ import annotations

__all__ = ["self_intersecting_faces"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals
from lbskel.geometry.scaling import unit_scale

# Upper bounds on the time and memory of the test. All are guesses.
MAX_TESTED_FACES = 10_000  # faces tested against all others; of larger meshes so many are picked evenly
MAX_PAIRS = 20_000_000  # pairs of faces tested in all
BLOCK_SIZE = 1_000_000  # pairs tested at a time


def self_intersecting_faces(mesh: Mesh) -> tuple[NDArray[np.int64], float]:
    """Find faces that intersect others.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    faces : (k,) array of int
    sample : float
        Fraction of the faces that were tested.
    """
    m = len(mesh.faces)
    mesh = mesh.with_vertices(unit_scale(mesh.vertices)[0])  # products of six lengths would overflow
    stride = 1 + (m - 1) // MAX_TESTED_FACES
    pairs = _candidate_pairs(mesh, np.arange(0, m, stride))
    tested = 1.0 / stride * min(1.0, MAX_PAIRS / max(len(pairs), 1))
    pairs = pairs[:MAX_PAIRS]
    found = []
    for first in range(0, len(pairs), BLOCK_SIZE):
        one, other = pairs[first : first + BLOCK_SIZE].T
        F, G = mesh.faces[one], mesh.faces[other]
        is_disjoint = ~(F[:, :, None] == G[:, None, :]).any(axis=(1, 2))
        one, other = one[is_disjoint], other[is_disjoint]
        P, Q = mesh.vertices[mesh.faces[one]], mesh.vertices[mesh.faces[other]]
        intersects = _edge_passes_through(P, Q) | _edge_passes_through(Q, P)
        found.append(np.unique(np.concatenate([one[intersects], other[intersects]])))
    return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *found])), tested


def _candidate_pairs(mesh: Mesh, chosen: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k, 2) pairs of a chosen face and another whose bounding boxes share a grid cell and overlap."""
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
    budget = np.cumsum(widths) <= 5 * MAX_PAIRS
    here, widths = here[budget], widths[budget]
    other = np.repeat(begin[here], widths) + np.arange(widths.sum()) - np.repeat(np.cumsum(widths) - widths, widths)
    pairs = np.stack([np.repeat(face[here], widths), face[other]], axis=1)
    i, j = pairs.T
    keep = (i != j) & ((i < j) | ~is_chosen[j])
    keep[keep] = ((low[i[keep]] <= high[j[keep]]) & (low[j[keep]] <= high[i[keep]])).all(axis=1)
    return np.stack(np.divmod(np.unique(i[keep] * len(low) + j[keep]), len(low)), axis=1)


def _edge_passes_through(P: NDArray[np.float64], Q: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether an edge of each triangle of P passes through the interior of the same row's triangle of Q."""
    origin = Q[:, :1]
    one, two = Q[:, 1] - Q[:, 0], Q[:, 2] - Q[:, 0]
    normal = triangle_normals(Q[:, 0], Q[:, 1], Q[:, 2])
    heights = np.einsum("kcx,kx->kc", P - origin, normal)
    end_heights = np.roll(heights, -1, axis=1)
    crosses = heights * end_heights < 0
    t = np.divide(heights, heights - end_heights, out=np.zeros_like(heights), where=crosses)
    point = P + t[:, :, None] * (np.roll(P, -1, axis=1) - P) - origin
    squared = np.einsum("kx,kx->k", normal, normal)[:, None]
    u = np.einsum("kcx,kx->kc", np.cross(point, two[:, None]), normal)
    v = np.einsum("kcx,kx->kc", np.cross(one[:, None], point), normal)
    passes: NDArray[np.bool_] = (crosses & (u > 0) & (v > 0) & (u + v < squared)).any(axis=1)
    return passes
