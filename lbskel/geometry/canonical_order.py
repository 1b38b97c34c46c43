"""A numbering of vertices and faces that follows from the surface, not from the order in which a file lists them.

Simplification, seeds and ties between equal lengths depend on the numbering. The canonical one is that of a
breadth-first traversal of the faces across their edges: it begins at the corner farthest from the centroid, and enters
each face's other neighbors in the sense of its orientation. So it does not change with the order of vertices and faces,
nor, but for shapes with several such corners, with rotation.
"""

from __future__ import annotations

__all__ = ["in_canonical_order"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.vertex_map import VertexMap

DIGITS = 9  # decimals of lengths, in diameter bounds, that are compared: rounding of sums must not decide


def in_canonical_order(mesh: Mesh) -> tuple[Mesh, VertexMap]:
    """Renumber a mesh in its canonical order.

    Components stay in their order. Edges of one or more than two faces are not crossed, and each part of the surface
    between these has a first corner of its own. Vertices without a face come last, as they are.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    mesh : Mesh
        The same surface.
    vertex_map : VertexMap
        From the vertices of the given mesh to those of the returned one.
    """
    n, m = len(mesh.vertices), len(mesh.faces)
    if m == 0:
        return mesh, VertexMap.identity(n)
    corners = _traversal(mesh)
    component = mesh.component_of_vertex
    corners = corners[stable_order(component[mesh.faces[corners % m, 0]])]
    faces, entry = corners % m, corners // m
    turned = np.stack([mesh.faces[faces, (entry + k) % 3] for k in range(3)], axis=1)
    used, first = np.unique(turned.ravel(), return_index=True)
    order = np.concatenate([used[stable_order(first)], np.setdiff1d(np.arange(n), used)])
    new_index = np.empty(n, dtype=np.int64)
    new_index[order] = np.arange(n)
    return replace(mesh, vertices=mesh.vertices[order], faces=new_index[turned]), VertexMap(new_index)


def _traversal(mesh: Mesh) -> NDArray[np.int64]:
    """(m,) the half-edge by which each face is entered, in order; half-edge ``k * m + f`` is opposite corner k."""
    m = len(mesh.faces)
    twins = _twins(mesh)
    crossed = np.flatnonzero(twins >= 0)
    part = component_roots(np.stack([crossed, twins[crossed]], axis=1) % m, np.zeros(m, dtype=np.int64))
    starts = _by_position(mesh)
    level = starts[np.sort(np.unique(part[starts % m], return_index=True)[1])]  # one in each part
    is_entered = np.zeros(m, dtype=bool)
    entered: list[NDArray[np.int64]] = []
    turns = np.arange(3) * m
    while len(level):
        is_entered[level % m] = True
        entered.append(level)
        # around the face from the edge by which it was entered, which leads back but at the start
        across = twins[(level[:, None] + turns).ravel() % (3 * m)]
        across = across[across >= 0]
        across = across[~is_entered[across % m]]
        level = across[np.sort(np.unique(across % m, return_index=True)[1])]
    return np.concatenate(entered)


def _twins(mesh: Mesh) -> NDArray[np.int64]:
    """(3 m,) the other half-edge at an edge of two faces; -1 at other edges."""
    order = stable_order(mesh.edge_of_half_edge)
    starts = np.cumsum(mesh.faces_per_edge) - mesh.faces_per_edge
    first = starts[mesh.faces_per_edge == 2]
    twins = np.full(len(order), -1)
    twins[order[first]], twins[order[first + 1]] = order[first + 1], order[first]
    return twins


def _by_position(mesh: Mesh) -> NDArray[np.int64]:
    """(3 m,) half-edges by the distance of their start from the centroid, their length and their coordinates."""
    unit = (mesh.vertices - mesh.centroid) / max(mesh.diameter_bound, np.finfo(np.float64).tiny)
    distance = np.round(np.linalg.norm(unit, axis=1), DIGITS)
    start, end = mesh.half_edges.T
    length = np.round(np.linalg.norm(unit[end] - unit[start], axis=1), DIGITS)
    places = np.round(np.hstack([unit[end], unit[start]]), DIGITS)
    order: NDArray[np.int64] = np.lexsort((*places.T, -length, -distance[start]))
    return order
