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
    n_umbrellas, label = connected_components(graph, directed=False)
    vertex = mesh.faces.T.ravel()
    first = _first_places(label, n_umbrellas)  # a corner of each umbrella
    first_umbrella = _first_places(vertex[first], n)
    is_first = np.zeros(n_umbrellas, dtype=bool)
    is_first[first_umbrella[first_umbrella >= 0]] = True
    number = np.where(is_first, vertex[first], n - 1 + np.cumsum(~is_first))
    of_corner: NDArray[np.int64] = number[label].reshape(3, m).T
    return of_corner


def _first_places(numbers: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """(n,) first index at which each number below n occurs, -1 where it does not; numpy.unique would sort them."""
    first = np.full(n, -1)
    first[numbers[::-1]] = np.arange(len(numbers))[::-1]
    return first


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
    places = np.arange(counts[crowded].sum()) + np.repeat(
        first[crowded] - np.cumsum(counts[crowded]) + counts[crowded], counts[crowded]
    )
    return np.concatenate([pairs, _wedge_pairs(mesh, order[places], counts[crowded])])


def _wedge_pairs(mesh: Mesh, half_edges: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k, 2) pairs of half-edges of one edge between whose faces the inside lies, from those of several edges.

    Parameters
    ----------
    mesh : Mesh
    half_edges : (h,) array of int
        Those of the first edge, then those of the next.
    counts : (e,) array of int
        Number of half-edges of each edge.
    """
    if len(counts) == 0:
        return np.empty((0, 2), dtype=np.int64)
    V, m = mesh.vertices, len(mesh.faces)
    first, edge = np.cumsum(counts) - counts, np.repeat(np.arange(len(counts)), counts)
    u, v = mesh.edges[mesh.edge_of_half_edge[half_edges]].T
    axis = V[v] - V[u]
    across = V[mesh.faces[half_edges % m, half_edges // m]] - V[u]
    squares = np.maximum(_dots(axis, axis), np.finfo(float).tiny)
    across = across - (_dots(across, axis) / squares)[:, None] * axis
    reference = across[first][edge]
    side = np.cross(axis, reference)
    angle = np.arctan2(
        _dots(across, side) * np.sqrt(_dots(reference, reference)),
        _dots(across, reference) * np.sqrt(_dots(side, side)),
    )
    order = np.lexsort((np.round(angle, 9), edge))
    following = np.arange(1, len(order) + 1)
    following[first + counts - 1] = first  # the last face around an edge precedes the first
    # in the order around the axis, the inside lies before a face that runs from u to v, and after one from v to u
    before, after = half_edges[order], half_edges[order[following]]
    is_wedge = (mesh.half_edges[before, 0] == v) & (mesh.half_edges[after, 0] == u)
    pairs: NDArray[np.int64] = np.stack([before, after], axis=1)[is_wedge]
    return pairs


def _dots(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) dot products of rows."""
    return np.asarray(np.einsum("ki,ki->k", a, b), dtype=np.float64)
