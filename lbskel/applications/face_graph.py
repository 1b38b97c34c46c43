"""The dual graph of a mesh: its faces, neighbors across the edges, and how concave the surface is there.

Vertices at one place count as one, so that the faces of a soup of triangles have neighbors too.
"""

from __future__ import annotations

__all__ = ["FaceGraph", "connect_parts", "face_graph"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from lbskel.geometry.graphs import connected_labels
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import unique_inverse

MIN_FACES = 6  # lower bound on the faces of a part: those around a tube with the section of a triangle, the least that
# can be a limb; derived, not tuned


@dataclass(frozen=True, eq=False)
class FaceGraph:
    """Faces and the edges between them; an edge of more than two faces joins each to the next.

    Parameters
    ----------
    pairs : (p, 2) array of int
        Faces at each edge.
    lengths : (p,) array of float
        Of the edges, in units of the mesh.
    turns : (p,) array of float
        Angle between the normals in radians, positive where the surface is concave.
    spans : (p,) array of float
        Distance of the centers of the two faces, in units of the mesh.
    """

    pairs: NDArray[np.int64]
    lengths: NDArray[np.float64]
    turns: NDArray[np.float64]
    spans: NDArray[np.float64]


def face_graph(mesh: Mesh) -> FaceGraph:
    """Find the neighbors of all faces.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented; where it is not, the signs of the angles mean nothing.
    """
    V, F, m = mesh.vertices, mesh.faces, len(mesh.faces)
    place = np.unique(V, axis=0, return_inverse=True)[1].ravel()
    ends = np.sort(place[mesh.half_edges], axis=1)
    face = np.tile(np.arange(m), 3)
    edge = unique_inverse(ends[:, 0] * len(V) + ends[:, 1])[1]
    order = np.lexsort((face, edge))
    is_same = (edge[order][1:] == edge[order][:-1]) & (face[order][1:] != face[order][:-1])
    row, following = order[:-1][is_same], order[1:][is_same]
    pairs = np.stack([face[row], face[following]], axis=1)
    start, end = V[mesh.half_edges[row]].transpose(1, 0, 2)
    centers, normals = V[F].mean(axis=1), mesh.face_normals
    offset = centers[pairs[:, 1]] - centers[pairs[:, 0]]
    a, b = normals[pairs].transpose(1, 0, 2)
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("px,px->p", a, b))
    outward = -1 if mesh.is_closed and mesh.volume < 0 else 1
    bend = np.einsum("px,px->p", a - b, offset) * outward  # positive where the second center is above the first face
    return FaceGraph(
        pairs, np.linalg.norm(end - start, axis=1), np.where(bend > 0, angle, -angle), np.linalg.norm(offset, axis=1)
    )


def connect_parts(labels: NDArray[np.int64], graph: FaceGraph, areas: NDArray[np.float64]) -> NDArray[np.int64]:
    """Give the fragments of each part to the neighbors with the longest common boundary.

    A part keeps its largest piece on each connected surface, if that has at least MIN_FACES faces.

    Parameters
    ----------
    labels : (m,) array of int
        Part of each face.
    graph : FaceGraph
    areas : (m,) array of float
        Areas of the faces.
    """
    m, (i, j) = len(labels), graph.pairs.T
    surface = connected_labels(graph.pairs, m)
    current = labels.copy()
    while True:
        is_same = current[i] == current[j]
        piece = connected_labels(graph.pairs[is_same], m)
        area = np.bincount(piece, areas)
        first = np.unique(piece, return_index=True)[1]
        part = surface[first] * (current.max() + 1) + current[first]
        order = np.lexsort((np.arange(len(area)), -area, part))
        is_largest = np.zeros(len(area), dtype=bool)
        is_largest[order[np.unique(part[order], return_index=True)[1]]] = True
        is_largest &= np.bincount(piece) >= MIN_FACES
        across = ~is_same & ~(is_largest[piece[i]] & is_largest[piece[j]])
        if not across.any():
            return current
        # only a fragment that is smaller than all fragments beside it joins a neighbor, so no two swap their labels
        rank = np.full(len(area), len(area))
        rank[np.lexsort((np.arange(len(area)), area, is_largest))[: np.count_nonzero(~is_largest)]] = np.arange(
            np.count_nonzero(~is_largest)
        )
        own, beside = (np.concatenate([piece[a][across], piece[b][across]]) for a, b in ((i, j), (j, i)))
        least = np.full(len(area), len(area) + 1)
        np.minimum.at(least, own, rank[beside])
        length = np.tile(np.maximum(graph.lengths[across], np.finfo(np.float64).tiny), 2)
        border = coo_array((length, (own, current[first][beside])), shape=(len(area), int(current.max()) + 1)).tocsr()
        chosen = np.flatnonzero(~is_largest & (rank < least) & (least <= len(area)))
        new = np.full(len(area), -1)
        new[chosen] = np.asarray(border[chosen].argmax(axis=1)).ravel()
        current = np.where(new[piece] >= 0, new[piece], current)
