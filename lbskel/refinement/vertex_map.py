"""The map from vertices to nodes: near each vertex, and in one piece on the surface for every node and edge.

Nearness alone tears regions apart where nodes are closer together than vertices. Of each node's region the largest
piece stays; what is cut off from it is taken over by the regions around, from their borders inwards, each vertex by the
one beside it whose node is nearest. A region that grows vertex by vertex along edges stays in one piece. Where the
regions of two neighboring nodes then do not touch, as at junctions, the shortest way between them is given to the two.

A connected preimage is what Cornea, Silver, Min 2007, https://doi.org/10.1109/TVCG.2007.1002, call component-wise
differentiation: a part of the skeleton stands for a part of the shape.
"""

from __future__ import annotations

__all__ = [
    "complete_map",
    "edges_with_disjoint_regions",
    "is_in_largest_piece",
    "make_regions_connected",
    "nearest_balls",
]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.spatial.distance import cdist

from lbskel._kernels.connectivity import pieces
from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order
from lbskel.skeleton.skeleton import Skeleton

ROUNDS = 4  # of ways laid between regions: measured, the number of parted edges hardly falls after them
AT_ONCE = 4_000_000  # distances held at a time
AROUND = 3  # edges of the skeleton from the two nodes within which the way between their regions is looked for


def nearest_balls(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.int64]:
    """(n,) the node whose ball is nearest to each vertex: a map for a skeleton that has none."""
    radii = np.nan_to_num(skeleton.radii)  # unknown ones are NaN
    at_once = max(1, AT_ONCE // len(skeleton.nodes))
    parts = [mesh.vertices[first : first + at_once] for first in range(0, len(mesh.vertices), at_once)]
    return np.concatenate([np.argmin(cdist(part, skeleton.nodes) - radii, axis=1) for part in parts])


def is_in_largest_piece(
    node_of_vertex: NDArray[np.int64], mesh: Mesh, nodes: NDArray[np.int64] | None = None
) -> NDArray[np.bool_]:
    """(n,) whether a vertex belongs to the piece of its node that has the most vertices; of equals, the first.

    A piece is what hangs together by edges of the mesh. Of nodes other than those given all is taken to be one piece.
    """
    if len(node_of_vertex) != len(mesh.vertices):
        raise ValueError("there must be a node for each vertex")
    asked = node_of_vertex if nodes is None else np.where(np.isin(node_of_vertex, nodes), node_of_vertex, -1)
    piece = pieces(mesh.edges, asked)
    size = np.bincount(piece)
    first = np.flatnonzero(size)
    node = node_of_vertex[first]
    order = np.lexsort((first, -size[first], node))
    is_kept = np.zeros(len(size), dtype=bool)
    is_kept[first[order[np.diff(node[order], prepend=-1) > 0]]] = True
    return is_kept[piece] | (asked < 0)


def edges_with_disjoint_regions(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.int64]:
    """(p, 2) edges of the skeleton whose two nodes both have vertices, but none that are neighbors on the mesh."""
    k = len(skeleton.nodes)
    has_vertex = np.bincount(skeleton.node_of_vertex, minlength=k) > 0
    i, j = (skeleton.node_of_vertex[ends] for ends in mesh.edges.T)
    differ = np.flatnonzero(i != j)
    i, j = i[differ], j[differ]
    touching = np.unique(np.minimum(i, j) * k + np.maximum(i, j))
    is_touching = np.isin(skeleton.edges @ [k, 1], touching)
    return skeleton.edges[~is_touching & has_vertex[skeleton.edges].all(axis=1)]


def make_regions_connected(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with a map by which the vertices of a node hang together on the mesh, and touch those of the next.

    The first holds for every node, unless its vertices lie on several components of the mesh; the second for nearly
    every edge.
    """
    skeleton = _whole(skeleton, mesh)
    parted = edges_with_disjoint_regions(skeleton, mesh)
    if len(parted) == 0:
        return skeleton
    i, j = mesh.edges.T
    way = mesh.vertices[i] - mesh.vertices[j]
    length = np.sqrt(np.einsum("ex,ex->e", way, way)) + 1e-12 * mesh.diameter_bound  # none may be zero
    graph = coo_array((length, (i, j)), shape=(len(mesh.vertices), len(mesh.vertices))).tocsr()
    graph = graph + graph.T
    for _ in range(ROUNDS):
        tried = _with_ways(skeleton, graph, parted)
        both = np.stack([skeleton.node_of_vertex, tried.node_of_vertex])
        tried = _whole(tried, mesh, np.unique(both[:, both[0] != both[1]]))
        still_parted = edges_with_disjoint_regions(tried, mesh)
        if len(still_parted) >= len(parted):
            break
        skeleton, parted = tried, still_parted
    return skeleton


def complete_map(skeleton: Skeleton, node_of_vertex: NDArray[np.int64], mesh: Mesh) -> Skeleton:
    """The skeleton with a map that is known in part, -1 elsewhere: regions grow, and what they do not reach is nearest.

    Parameters
    ----------
    skeleton : Skeleton
        With radii.
    node_of_vertex : (n,) array of int
    mesh : Mesh
    """
    grown = _grown(skeleton.nodes, node_of_vertex, node_of_vertex >= 0, mesh)
    return replace(skeleton, node_of_vertex=np.where(grown < 0, nearest_balls(skeleton, mesh), grown))


def _whole(skeleton: Skeleton, mesh: Mesh, nodes: NDArray[np.int64] | None = None) -> Skeleton:
    """Every vertex outside the largest piece of its node given to a piece beside it; some nodes may be known to do."""
    is_placed = is_in_largest_piece(skeleton.node_of_vertex, mesh, nodes)
    return replace(skeleton, node_of_vertex=_grown(skeleton.nodes, skeleton.node_of_vertex, is_placed, mesh))


def _grown(
    nodes: NDArray[np.float64], node_of_vertex: NDArray[np.int64], is_placed: NDArray[np.bool_], mesh: Mesh
) -> NDArray[np.int64]:
    """The map with every vertex that is not placed given to the node of one beside it that is, as far as edges lead."""
    node_of_vertex, is_placed = np.array(node_of_vertex), np.array(is_placed)
    i, j = mesh.edges.T
    from_start, from_end = np.flatnonzero(~is_placed[i]), np.flatnonzero(~is_placed[j])
    both = np.concatenate([mesh.edges[from_start], mesh.edges[from_end, ::-1]])
    while True:
        vertex, beside = both[is_placed[both[:, 1]]].T
        if len(vertex) == 0:
            return node_of_vertex
        node = node_of_vertex[beside]
        far = np.linalg.norm(mesh.vertices[vertex] - nodes[node], axis=1)
        order = np.lexsort((node, far, vertex))
        reached, first = np.unique(vertex[order], return_index=True)
        node_of_vertex[reached] = node[order][first]
        is_placed[reached] = True
        both = both[~is_placed[both[:, 0]]]


def _with_ways(skeleton: Skeleton, graph: csr_array, parted: NDArray[np.int64]) -> Skeleton:
    """The vertices of the shortest way between the regions of each parted edge given to its nodes, half to each."""
    node_of_vertex = np.array(skeleton.node_of_vertex)
    ways = ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)
    by_node = stable_order(node_of_vertex)
    begins = np.searchsorted(node_of_vertex[by_node], np.arange(len(skeleton.nodes) + 1))
    neighbors = [beside.tolist() for beside in skeleton.neighbors]
    kinds, is_around = np.zeros(len(node_of_vertex), dtype=np.int8), np.zeros(len(neighbors), dtype=bool)
    for first, last in parted.tolist():
        around = {first, last}
        for _ in range(AROUND):
            around.update(*(neighbors[node] for node in around))
        nodes = sorted(around)
        is_around[nodes] = True
        here = np.concatenate([by_node[begins[node] : begins[node + 1]] for node in nodes])
        here = np.sort(here[is_around[node_of_vertex[here]]])
        is_around[nodes] = False
        node = node_of_vertex[here]
        kinds[here] = np.where(node == last, 2, 1)
        inner = ways.first_of(here[node == first], kinds)[1][1:-1]  # no way where one before has taken over a region
        kinds[here] = 0
        node_of_vertex[inner[: len(inner) // 2]] = last
        node_of_vertex[inner[len(inner) // 2 :]] = first
    return replace(skeleton, node_of_vertex=node_of_vertex)
