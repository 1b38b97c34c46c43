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

from lbskel._kernels.gluing import glue_copies, half_edges_by_edge
from lbskel.geometry.normals import normalized


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
    order, begins = half_edges_by_edge(F, len(V))
    _sort_around_edges(V, F, order, np.diff(begins))
    return np.concatenate([F, F[:, [0, 2, 1]]]), glue_copies(F, order, begins)


def _sort_around_edges(
    V: NDArray[np.float64],
    F: NDArray[np.int64],
    order: NDArray[np.int64],
    counts: NDArray[np.int64],
) -> None:
    """Sort the half-edges of each edge with more than two faces by the angle of the face around it.

    Parameters
    ----------
    V : (n, 3) array of float
    F : (m, 3) array of int
    order : (3m,) array of int
        The half-edges, those of one edge after those of another; changed in place.
    counts : (e,) array of int
        Number of half-edges of each edge.
    """
    if counts.max(initial=0) <= 2:
        return
    edge = np.repeat(np.arange(len(counts)), counts)
    places = np.flatnonzero((counts > 2)[edge])
    crowded = order[places]
    face, corner = np.divmod(crowded, 3)
    start, end = F[face, (corner + 1) % 3], F[face, (corner + 2) % 3]
    low, high = np.minimum(start, end), np.maximum(start, end)
    along, towards = normalized(V[high] - V[low]), V[F[face, corner]] - V[low]
    axis = np.argmin(np.abs(along), axis=1)  # the same for all faces of an edge, as is the reference direction
    reference = normalized(np.cross(along, np.eye(3)[axis]))
    angle = np.arctan2(
        np.einsum("ki,ki->k", towards, np.cross(along, reference)), np.einsum("ki,ki->k", towards, reference)
    )
    order[places] = crowded[np.lexsort((angle, edge[places]))]
