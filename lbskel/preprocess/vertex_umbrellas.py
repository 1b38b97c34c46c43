"""Fans: the faces around a vertex that hang together through its edges, of which a manifold has one at each vertex.

Two faces hang together at an edge that they alone have, in opposite directions. At an edge of more faces, those hang
together that bound the same wedge of the inside: the edge where two solids touch belongs to each of them.
"""

from __future__ import annotations

__all__ = ["Fans", "fans_of"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order


@dataclass(frozen=True, eq=False)
class Fans:
    """The fans of a mesh.

    Parameters
    ----------
    of_corner : (m, 3) array of int
        Number of the fan at each corner of each face: that of its vertex for the first fan there, n and above for more.
    partner : (3m,) array of int
        The half-edge on the other side of each, -1 where there is none.
    """

    of_corner: NDArray[np.int64]
    partner: NDArray[np.int64]


def fans_of(mesh: Mesh) -> Fans:
    """The fans of a mesh; faces that name a vertex twice hang together with none."""
    pairs = _pairs(mesh)
    while True:
        of_corner = _numbers(mesh, pairs)
        # where a fan passes an edge twice it would keep more than two faces: there nothing hangs together
        F = np.sort(of_corner[:, [[1, 2], [2, 0], [0, 1]]], axis=2).transpose(1, 0, 2).reshape(-1, 2)
        _, edge, count = np.unique(F, axis=0, return_inverse=True, return_counts=True)
        crowded = (count[edge.reshape(-1)] > 2)[pairs].any(axis=1)
        if not crowded.any():
            break
        pairs = pairs[~crowded]
    partner = np.full(3 * len(mesh.faces), -1)
    partner[pairs], partner[pairs[:, ::-1]] = pairs[:, ::-1], pairs
    return Fans(of_corner, partner)


def _numbers(mesh: Mesh, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """(m, 3) the number of the fan at each corner, where faces hang together through pairs of half-edges."""
    m, n = len(mesh.faces), len(mesh.vertices)
    a, b = pairs.T
    links = [(_corner(a, 1, m), _corner(b, 2, m)), (_corner(a, 2, m), _corner(b, 1, m))]
    pairs_of_corners = np.concatenate([np.stack(link, axis=1) for link in links])
    graph = weighted_graph(pairs_of_corners, np.ones(len(pairs_of_corners), dtype=np.int8), 3 * m)
    label = connected_components(graph, directed=False)[1]
    vertex = mesh.faces.T.ravel()
    _, first = np.unique(label, return_index=True)  # a corner of each fan
    _, first_fan = np.unique(vertex[first], return_index=True)
    is_first = np.zeros(len(first), dtype=bool)
    is_first[first_fan] = True
    number = np.where(is_first, vertex[first], n - 1 + np.cumsum(~is_first))
    return number[label].reshape(3, m).T


def _corner(half_edge: NDArray[np.int64], along: int, m: int) -> NDArray[np.int64]:
    """The corner at the start (1) or the end (2) of half-edges, numbered as half-edges are by the corner opposite."""
    return (half_edge // m + along) % 3 * m + half_edge % m


def _pairs(mesh: Mesh) -> NDArray[np.int64]:
    """(k, 2) half-edges through which two faces hang together."""
    start = mesh.half_edges[:, 0]
    order = stable_order(mesh.edge_of_half_edge)
    counts = mesh.faces_per_edge
    first = np.cumsum(counts) - counts
    doubles = first[counts == 2]
    pairs = np.stack([order[doubles], order[doubles + 1]], axis=1)
    pairs = pairs[start[pairs[:, 0]] != start[pairs[:, 1]]]
    crowded = np.flatnonzero((counts > 2) & (mesh.edges[:, 0] != mesh.edges[:, 1]))
    more = [_wedges(mesh, order[first[edge] : first[edge] + counts[edge]], *mesh.edges[edge]) for edge in crowded]
    return np.concatenate([pairs, *more])


def _wedges(mesh: Mesh, half_edges: NDArray[np.int64], u: int, v: int) -> NDArray[np.int64]:
    """Pairs of the half-edges of the edge (u, v) between which the inside lies."""
    V, m = mesh.vertices, len(mesh.faces)
    axis = V[v] - V[u]
    across = V[mesh.faces[half_edges % m, half_edges // m]] - V[u]
    across = across - np.outer(across @ axis, axis) / max(axis @ axis, np.finfo(float).tiny)
    side = np.cross(axis, across[0])
    angle = np.arctan2(across @ side * np.sqrt(across[0] @ across[0]), across @ across[0] * np.sqrt(side @ side))
    order = np.argsort(np.round(angle, 9), kind="stable")
    # around the axis, the outside of a face that runs along it lies ahead, and that of one that runs back behind
    before, after = half_edges[order], half_edges[np.roll(order, -1)]
    is_wedge = (mesh.half_edges[before, 0] == v) & (mesh.half_edges[after, 0] == u)
    return np.stack([before, after], axis=1)[is_wedge]
