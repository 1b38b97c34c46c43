"""The map from vertices to nodes, as regions of the surface: near their nodes, connected, and adjacent along edges.

The region of a node is the set of vertices mapped to it. Nearness alone splits regions where nodes are closer together
than vertices. The largest connected piece of each region is kept; the other vertices are taken over by the regions
around them, from their borders inwards, each by the adjacent region whose node is nearest. A region that grows vertex
by vertex along edges stays connected. Where the regions of two adjacent nodes then do not touch, as at junctions, the
shortest path between the regions is divided between the two nodes.

A connected preimage is what Cornea, Silver, Min 2007, https://doi.org/10.1109/TVCG.2007.1002, call component-wise
differentiation: a part of the skeleton represents a part of the shape.
"""

from __future__ import annotations

__all__ = [
    "complete_regions",
    "edges_with_disjoint_regions",
    "make_regions_connected",
    "nearest_balls",
    "reassign_to_nearest_node",
]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.distance import cdist

from lbskel._kernels.connectivity import descend_to_nearest_node
from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.graphs import edge_length_graph, shortest_paths, weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import is_among, split_at, stable_order
from lbskel.geometry.vertex_map import VertexMap, is_in_largest_piece
from lbskel.skeleton.skeleton import Skeleton

MAX_DISTANCES = 4_000_000  # held in memory at a time, which is 32 MB
N_RINGS = 3  # edges of the skeleton from its two nodes within which the path between two regions is searched; a guess,
# benchmarks/results/constants.md


def nearest_balls(skeleton: Skeleton, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) the node whose ball is nearest to each point; for vertices, a map for a skeleton that has none.

    Parameters
    ----------
    skeleton : Skeleton
        An unknown radius counts as 0.
    points : (n, 3) array of float
    """
    radii = np.nan_to_num(skeleton.radii)  # unknown radii are NaN
    chunk = max(1, MAX_DISTANCES // len(skeleton.nodes))
    parts = [points[first : first + chunk] for first in range(0, len(points), chunk)]
    return np.concatenate([np.argmin(cdist(part, skeleton.nodes) - radii, axis=1) for part in parts])


def complete_regions(skeleton: Skeleton, node_of_vertex: NDArray[np.int64], mesh: Mesh) -> NDArray[np.int64]:
    """(n,) a node for each vertex, near it where the given map has none.

    A vertex without a node gets that of an adjacent vertex, from known ones outwards, or the nearest node where no
    edges lead to a known one. The vertex is then reassigned along the edges of the skeleton as long as an adjacent node
    is nearer, and to an adjacent region where its own is not connected.

    Parameters
    ----------
    skeleton : Skeleton
        Its own map is not used.
    node_of_vertex : (n,) array of int
        The known nodes, which are kept; -1 where there is none.
    mesh : Mesh
    """
    is_known = node_of_vertex >= 0
    if is_known.all():
        return node_of_vertex
    grown = VertexMap(_grown(skeleton.nodes, node_of_vertex, is_known, mesh)).complete(mesh.vertices, skeleton.nodes)
    near = reassign_to_nearest_node(replace(skeleton, node_of_vertex=grown.indices), mesh).node_of_vertex
    near = np.where(is_known, node_of_vertex, near)
    connected = _with_connected_regions(replace(skeleton, node_of_vertex=near), mesh).node_of_vertex
    return np.where(is_known, node_of_vertex, connected)


def reassign_to_nearest_node(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """Reassign each vertex along the edges of the skeleton, as long as an adjacent node is nearer to it.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    mesh : Mesh
        The mesh that ``node_of_vertex`` belongs to.
    """
    node_of_vertex = descend_to_nearest_node(
        mesh.vertices, skeleton.node_of_vertex, skeleton.nodes, *skeleton.adjacency
    )
    return replace(skeleton, node_of_vertex=node_of_vertex)


def edges_with_disjoint_regions(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.int64]:
    """(p, 2) edges of the skeleton whose nodes both have vertices, but none that are adjacent on the mesh.

    Parameters
    ----------
    skeleton, mesh
        As for :func:`reassign_to_nearest_node`.
    """
    k = len(skeleton.nodes)
    has_vertex = np.bincount(skeleton.node_of_vertex, minlength=k) > 0
    i, j = (skeleton.node_of_vertex[ends] for ends in mesh.edges.T)
    differ = np.flatnonzero(i != j)
    i, j = i[differ], j[differ]
    is_touching = is_among(skeleton.edges @ np.array([k, 1]), np.minimum(i, j) * k + np.maximum(i, j))
    return skeleton.edges[~is_touching & has_vertex[skeleton.edges].all(axis=1)]


def make_regions_connected(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """Make the regions of the map connected, and adjacent for adjacent nodes.

    Afterwards every region is connected, unless its vertices lie on several components of the mesh, and nearly every
    edge of the skeleton joins adjacent regions.

    Parameters
    ----------
    skeleton, mesh
        As for :func:`reassign_to_nearest_node`.
    """
    skeleton = _with_connected_regions(skeleton, mesh)
    disjoint = edges_with_disjoint_regions(skeleton, mesh)
    if len(disjoint) == 0:
        return skeleton
    search = shortest_paths(edge_length_graph(mesh))
    while len(disjoint):
        candidate = _with_connecting_paths(skeleton, search, disjoint)
        both = np.stack([skeleton.node_of_vertex, candidate.node_of_vertex])
        candidate = _with_connected_regions(candidate, mesh, np.unique(both[:, both[0] != both[1]]))
        still_disjoint = edges_with_disjoint_regions(candidate, mesh)
        if len(still_disjoint) >= len(disjoint):
            break
        skeleton, disjoint = candidate, still_disjoint
    return skeleton


def _with_connected_regions(skeleton: Skeleton, mesh: Mesh, nodes: NDArray[np.int64] | None = None) -> Skeleton:
    """Reassign vertices outside the largest connected piece of their region to an adjacent region.

    The regions of nodes other than those given are known to be connected.
    """
    is_fixed = is_in_largest_piece(skeleton.node_of_vertex, mesh, nodes)
    return replace(skeleton, node_of_vertex=_grown(skeleton.nodes, skeleton.node_of_vertex, is_fixed, mesh))


def _grown(
    nodes: NDArray[np.float64], node_of_vertex: NDArray[np.int64], is_fixed: NDArray[np.bool_], mesh: Mesh
) -> NDArray[np.int64]:
    """Give every vertex that is not fixed to the region of an adjacent one, as far as edges lead."""
    node_of_vertex, is_fixed = np.array(node_of_vertex), np.array(is_fixed)
    i, j = mesh.edges.T
    from_start, from_end = np.flatnonzero(~is_fixed[i]), np.flatnonzero(~is_fixed[j])
    open_edges = np.concatenate([mesh.edges[from_start], mesh.edges[from_end, ::-1]])
    while True:
        vertex, adjacent = open_edges[is_fixed[open_edges[:, 1]]].T
        if len(vertex) == 0:
            return node_of_vertex
        node = node_of_vertex[adjacent]
        distances = vector_lengths(mesh.vertices[vertex] - nodes[node])
        order = np.lexsort((node, distances, vertex))
        reached, first = np.unique(vertex[order], return_index=True)
        node_of_vertex[reached] = node[order][first]
        is_fixed[reached] = True
        open_edges = open_edges[~is_fixed[open_edges[:, 0]]]


def _with_connecting_paths(skeleton: Skeleton, search: ShortestPaths, disjoint: NDArray[np.int64]) -> Skeleton:
    """Divide the shortest path between the two regions of each disjoint edge between its nodes, half to each."""
    node_of_vertex = np.array(skeleton.node_of_vertex)
    nodes, vertices = _around(skeleton, disjoint)
    kinds, is_near = np.zeros(len(node_of_vertex), dtype=np.int8), np.zeros(len(skeleton.nodes), dtype=bool)
    for (first, last), near, local in zip(disjoint.tolist(), nodes, vertices, strict=True):
        is_near[near] = True
        local = np.sort(local[is_near[node_of_vertex[local]]])
        is_near[near] = False
        node = node_of_vertex[local]
        kinds[local] = np.where(node == last, 2, 1)
        # the path is empty where an earlier one has taken over a whole region
        inner = search.nearest_goal(local[node == first], kinds)[1][1:-1]
        kinds[local] = 0
        node_of_vertex[inner[: len(inner) // 2]] = last
        node_of_vertex[inner[len(inner) // 2 :]] = first
    return replace(skeleton, node_of_vertex=node_of_vertex)


def _around(skeleton: Skeleton, edges: NDArray[np.int64]) -> tuple[list[NDArray[np.int64]], list[NDArray[np.int64]]]:
    """For each edge, the nodes within N_RINGS edges of it, and the vertices of their regions."""
    k = len(skeleton.nodes)
    graph = weighted_graph(skeleton.edges, np.ones(len(skeleton.edges)), k)
    graph = graph + graph.T
    reached = csr_array((np.ones(edges.size), edges.ravel(), 2 * np.arange(len(edges) + 1)), shape=(len(edges), k))
    for _ in range(N_RINGS):
        reached = reached + reached @ graph
    nodes, cuts = reached.indices.astype(np.int64), reached.indptr
    by_node = stable_order(skeleton.node_of_vertex)
    begins = np.searchsorted(skeleton.node_of_vertex[by_node], np.arange(k + 1))
    counts = begins[nodes + 1] - begins[nodes]
    ends = np.append(0, np.cumsum(counts))
    vertices = by_node[np.arange(ends[-1]) + np.repeat(begins[nodes] - ends[:-1], counts)]
    return split_at(nodes, cuts[1:-1]), split_at(vertices, ends[cuts[1:-1]])
