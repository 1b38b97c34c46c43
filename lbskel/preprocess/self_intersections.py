"""Faces that intersect other faces of the same mesh.

Candidate pairs have bounding boxes that overlap; two triangles intersect where an edge of one passes through the other.
Faces that share a vertex, and coplanar faces, do not count.
"""

from __future__ import annotations

__all__ = ["self_intersecting_faces"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals
from lbskel.geometry.scaling import unit_vertices

# Upper bounds on the time of the test. Guesses; the seconds are of one core that other jobs share.
MAX_TESTED_FACES = 10_000  # faces tested against all others; of larger meshes so many are picked evenly
MAX_PAIRS = 5_000_000  # pairs of a face and another whose bounding boxes overlap: they take 1 to 15 s


def self_intersecting_faces(mesh: Mesh) -> tuple[NDArray[np.int64], float]:
    """Find faces that intersect others.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    faces : (k,) array of int
    sample : float
        Fraction of the faces that were tested against all others; below 1 there may be more.
    """
    m = len(mesh.faces)
    unit, _ = unit_vertices(mesh)  # products of six lengths would overflow
    mesh = mesh.with_vertices(unit)
    stride = 1 + (m - 1) // MAX_TESTED_FACES
    chosen = np.random.default_rng(0).permutation(np.arange(0, m, stride))  # so that the first are a sample too
    rank = np.full(m, m)
    rank[chosen] = np.arange(len(chosen))
    corners = mesh.vertices[mesh.faces[chosen]]
    intersects = np.zeros(m, dtype=bool)
    n_pairs, n_tested = 0, len(chosen)
    for box, other in mesh.aabb_tree.overlapping_faces(corners.min(axis=1), corners.max(axis=1)):
        n_pairs += len(box)
        is_new = box < rank[other]
        one, other = chosen[box[is_new]], other[is_new]
        F, G = mesh.faces[one].T, mesh.faces[other].T
        is_disjoint = ~(F[:, None] == G).any(axis=(0, 1))
        one, other = one[is_disjoint], other[is_disjoint]
        P, Q = mesh.vertices[mesh.faces[one]], mesh.vertices[mesh.faces[other]]
        is_crossed = _edge_passes_through(P, Q) | _edge_passes_through(Q, P)
        intersects[one[is_crossed]] = intersects[other[is_crossed]] = True
        if n_pairs > MAX_PAIRS:
            n_tested = int(box[-1])
            break
    return np.flatnonzero(intersects), n_tested / len(chosen) / stride


def _edge_passes_through(P: NDArray[np.float64], Q: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether an edge of each triangle of P passes through the interior of the same row's triangle of Q."""
    normal = triangle_normals(Q[:, 0], Q[:, 1], Q[:, 2])
    heights = np.einsum("kcx,kx->ck", P - Q[:, :1], normal)
    passes: NDArray[np.bool_] = (heights.min(axis=0) < 0) & (heights.max(axis=0) > 0)  # the plane of Q
    P, Q, normal, heights = P[passes], Q[passes], normal[passes], heights.T[passes]
    origin, one, two = Q[:, :1], Q[:, 1] - Q[:, 0], Q[:, 2] - Q[:, 0]
    end_heights = np.roll(heights, -1, axis=1)
    crosses = heights * end_heights < 0
    t = np.divide(heights, heights - end_heights, out=np.zeros_like(heights), where=crosses)
    point = P + t[:, :, None] * (np.roll(P, -1, axis=1) - P) - origin
    squared = np.einsum("kx,kx->k", normal, normal)[:, None]
    u = np.einsum("kcx,kx->kc", np.cross(point, two[:, None]), normal)
    v = np.einsum("kcx,kx->kc", np.cross(one[:, None], point), normal)
    passes[passes] = (crosses & (u > 0) & (v > 0) & (u + v < squared)).any(axis=1)
    return passes
