"""The handles of each component of a mesh, with its holes closed, by the Euler characteristic.

A surface of genus g has the characteristic V - E + F = 2 - 2 g. Surfaces that touch at a vertex, as where a scan with
many holes is closed, are counted apart: each umbrella, the faces around a vertex that are connected by edges, has a
vertex of its own.
"""

from __future__ import annotations

__all__ = ["count_handles"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.graphs import connected_labels
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order


def count_handles(mesh: Mesh) -> NDArray[np.int64]:
    """(c,) number of handles of each component.

    Parameters
    ----------
    mesh : Mesh
        With at most two faces at an edge.
    """
    m, corner_vertex = len(mesh.faces), mesh.faces.T.ravel()
    order = stable_order(mesh.edge_of_half_edge)
    is_pair = np.diff(mesh.edge_of_half_edge[order]) == 0
    a, b = order[:-1][is_pair], order[1:][is_pair]
    start, end = ((np.arange(3 * m) + k * m) % (3 * m) for k in (1, 2))  # corners of each half-edge
    is_opposite = corner_vertex[start[a]] == corner_vertex[end[b]]
    links = [(start[a], np.where(is_opposite, end[b], start[b])), (end[a], np.where(is_opposite, start[b], end[b]))]
    umbrella = connected_labels(np.concatenate([np.stack(link, axis=1) for link in links]), 3 * m)
    part = connected_labels(np.stack([a % m, b % m], axis=1), m)
    free = mesh.faces_per_edge[mesh.edge_of_half_edge] == 1
    rims = np.stack([umbrella[start[free]], umbrella[end[free]]], axis=1)
    loop = connected_labels(rims, int(umbrella.max()) + 1)[rims[:, 0]]
    component_of_face = mesh.component_of_vertex[mesh.faces[:, 0]]

    def count(labels: NDArray[np.int64], face: NDArray[np.int64]) -> NDArray[np.int64]:
        first = np.unique(labels, return_index=True)[1]
        return np.bincount(component_of_face[face[first]], minlength=mesh.n_components)

    faces = np.arange(m)
    euler = count(umbrella, np.tile(faces, 3)) - count(mesh.edge_of_half_edge, np.tile(faces, 3)) + count(faces, faces)
    handles: NDArray[np.int64] = count(part, faces) - (euler + count(loop, np.tile(faces, 3)[free])) // 2
    return handles
