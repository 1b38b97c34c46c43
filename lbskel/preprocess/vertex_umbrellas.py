"""Umbrellas: the faces around a vertex that are connected through its edges; a manifold has one at each vertex.

Two faces are connected at an edge if it has no other face and they run along it in opposite directions. At an edge of
more than two faces, those that bound the same wedge of the inside are connected, so that an edge where two solids touch
is split between them.
"""

from __future__ import annotations

__all__ = ["Umbrellas", "find_umbrellas"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order, unique_inverse


@dataclass(frozen=True, eq=False)
class Umbrellas:
    """The umbrellas of a mesh.

    Parameters
    ----------
    of_corner : (m, 3) array of int
        Umbrella at each corner of each face. The first umbrella at a vertex has the number of the vertex, others have
        numbers from n on.
    twin : (3m,) array of int
        The opposite half-edge of each half-edge, -1 where there is none.
    """

    of_corner: NDArray[np.int64]
    twin: NDArray[np.int64]


def find_umbrellas(mesh: Mesh) -> Umbrellas:
    """Find the umbrellas of a mesh; faces that name a vertex twice are connected to no others.

    Parameters
    ----------
    mesh : Mesh
    """
    pairs = _connected_half_edges(mesh)
    while True:
        of_corner = _number_umbrellas(mesh, pairs)
        # an umbrella that passes an edge twice would have more than two faces there: disconnect them
        first, second = of_corner[:, [1, 2, 0]].T.ravel(), of_corner[:, [2, 0, 1]].T.ravel()
        edge = unique_inverse(np.minimum(first, second) * (of_corner.max() + 1) + np.maximum(first, second))[1]
        crowded = (np.bincount(edge)[edge] > 2)[pairs].any(axis=1)
        if not crowded.any():
            break
        pairs = pairs[~crowded]
    twin = np.full(3 * len(mesh.faces), -1)
    twin[pairs], twin[pairs[:, ::-1]] = pairs[:, ::-1], pairs
    return Umbrellas(of_corner, twin)


def _number_umbrellas(mesh: Mesh, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """(m, 3) umbrella at each corner, where faces are connected through pairs of half-edges."""
    m, n = len(mesh.faces), len(mesh.vertices)
    a, b = pairs.T
    links = [(_corner(a, 1, m), _corner(b, 2, m)), (_corner(a, 2, m), _corner(b, 1, m))]
    pairs_of_corners = np.concatenate([np.stack(link, axis=1) for link in links])
    graph = weighted_graph(pairs_of_corners, np.ones(len(pairs_of_corners), dtype=np.int8), 3 * m)
    label = connected_components(graph, directed=False)[1]
    vertex = mesh.faces.T.ravel()
    _, first = np.unique(label, return_index=True)  # a corner of each umbrella
    _, first_umbrella = np.unique(vertex[first], return_index=True)
    is_first = np.zeros(len(first), dtype=bool)
    is_first[first_umbrella] = True
    number = np.where(is_first, vertex[first], n - 1 + np.cumsum(~is_first))
    of_corner: NDArray[np.int64] = number[label].reshape(3, m).T
    return of_corner


def _corner(half_edge: NDArray[np.int64], along: int, m: int) -> NDArray[np.int64]:
    """(k,) corner at the start (1) or the end (2) of half-edges, numbered as the half-edge opposite it."""
    return (half_edge // m + along) % 3 * m + half_edge % m


def _connected_half_edges(mesh: Mesh) -> NDArray[np.int64]:
    """(k, 2) pairs of half-edges through which two faces are connected."""
    start = mesh.half_edges[:, 0]
    order = stable_order(mesh.edge_of_half_edge)
    counts = mesh.faces_per_edge
    first = np.cumsum(counts) - counts
    doubles = first[counts == 2]
    pairs = np.stack([order[doubles], order[doubles + 1]], axis=1)
    pairs = pairs[start[pairs[:, 0]] != start[pairs[:, 1]]]
    crowded = np.flatnonzero((counts > 2) & (mesh.edges[:, 0] != mesh.edges[:, 1]))
    more = [_wedge_pairs(mesh, order[first[edge] : first[edge] + counts[edge]], *mesh.edges[edge]) for edge in crowded]
    return np.concatenate([pairs, *more])


def _wedge_pairs(mesh: Mesh, half_edges: NDArray[np.int64], u: int, v: int) -> NDArray[np.int64]:
    """(k, 2) pairs of half-edges of the edge (u, v) between whose faces the inside lies."""
    V, m = mesh.vertices, len(mesh.faces)
    axis = V[v] - V[u]
    across = V[mesh.faces[half_edges % m, half_edges // m]] - V[u]
    across = across - np.outer(across @ axis, axis) / max(axis @ axis, np.finfo(float).tiny)
    side = np.cross(axis, across[0])
    angle = np.arctan2(across @ side * np.sqrt(across[0] @ across[0]), across @ across[0] * np.sqrt(side @ side))
    order = np.argsort(np.round(angle, 9), kind="stable")
    # in the order around the axis, the inside lies before a face that runs from u to v, and after one from v to u
    before, after = half_edges[order], half_edges[np.roll(order, -1)]
    is_wedge = (mesh.half_edges[before, 0] == v) & (mesh.half_edges[after, 0] == u)
    pairs: NDArray[np.int64] = np.stack([before, after], axis=1)[is_wedge]
    return pairs
