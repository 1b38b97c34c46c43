"""Traversals along the edges of a surface: components, umbrellas of vertices, neighbor sums, nearest nodes."""

from __future__ import annotations

__all__ = ["component_roots", "count_umbrellas", "descend_to_nearest_node", "neighbor_sums"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython


@cython.locals(edge=cython.Py_ssize_t, i=cython.longlong, j=cython.longlong)
def component_roots(
    edges: cython.const[cython.longlong][:, ::1], labels: cython.const[cython.longlong][::1]
) -> NDArray[np.int64]:
    """(n,) smallest vertex index in the connected region of each vertex.

    Regions are connected by edges between vertices of equal label; a vertex with a negative label is its own region.
    Union and find: Tarjan 1975, "Efficiency of a good but not linear set union algorithm",
    https://doi.org/10.1145/321879.321884.

    Parameters
    ----------
    edges : (e, 2) array of int
    labels : (n,) array of int
    """
    n: cython.Py_ssize_t = labels.shape[0]
    array = np.arange(n)
    parent: cython.longlong[::1] = array
    with cython.nogil:
        for edge in range(edges.shape[0]):
            i, j = edges[edge, 0], edges[edge, 1]
            if labels[i] != labels[j] or labels[i] < 0:
                continue
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            while parent[j] != j:
                parent[j] = parent[parent[j]]
                j = parent[j]
            parent[max(i, j)] = min(i, j)
        for i in range(n):  # a parent has a smaller index, so in ascending order it already points to its root
            parent[i] = parent[parent[i]]
    return array


@cython.locals(side=cython.Py_ssize_t, at=cython.Py_ssize_t, edge=cython.longlong)
def count_umbrellas(
    F: cython.const[cython.longlong][:, ::1],
    edge_of_side: cython.const[cython.longlong][::1],
    n_edges: cython.Py_ssize_t,
) -> int:
    """Count umbrellas, or return -1 where the two faces at some edge are not oriented alike.

    An umbrella is a cycle of faces around one vertex, each adjacent to the next: a manifold vertex has one, a vertex
    at which surfaces are pinched together has more.

    Parameters
    ----------
    F : (m, 3) array of int
        Faces of a surface without boundary, of which each edge has exactly two faces.
    edge_of_side : (3 m,) array of int
        Edge of each half-edge. Half-edge k lies opposite corner k // m of face k % m, as in ``Mesh.half_edges``.
    n_edges : int
    """
    m: cython.Py_ssize_t = F.shape[0]
    count: cython.Py_ssize_t = 0
    twins: cython.longlong[::1] = np.empty(3 * m, dtype=np.int64)
    first: cython.longlong[::1] = np.full(n_edges, -1, dtype=np.int64)
    is_seen: cython.schar[::1] = np.zeros(3 * m, dtype=np.int8)
    with cython.nogil:
        for side in range(3 * m):
            edge = edge_of_side[side]
            if first[edge] < 0:
                first[edge] = side
                continue
            at = first[edge]
            if F[side % m, (side // m + 1) % 3] == F[at % m, (at // m + 1) % 3]:
                count = -1
                break
            twins[side], twins[at] = at, side
        for side in range(3 * m if count == 0 else 0):
            if is_seen[side]:
                continue
            count += 1
            at = side
            while not is_seen[at]:
                is_seen[at] = 1
                at = (twins[(at + m) % (3 * m)] + m) % (3 * m)  # the next face: across the half-edge that leaves
    return count


@cython.locals(
    vertex=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    at=cython.Py_ssize_t,
    nearest=cython.Py_ssize_t,
    dx=cython.double,
    dy=cython.double,
    dz=cython.double,
    squared=cython.double,
    smallest=cython.double,
)
def descend_to_nearest_node(
    vertices: cython.const[cython.double][:, ::1],
    node_of_vertex: cython.const[cython.longlong][::1],
    nodes: cython.const[cython.double][:, ::1],
    first: cython.const[cython.longlong][::1],
    neighbors: cython.const[cython.longlong][::1],
) -> NDArray[np.int64]:
    """(n,) node of each vertex after steps to the adjacent node nearest to the vertex, until no neighbor is nearer.

    Parameters
    ----------
    vertices : (n, 3) array of float
    node_of_vertex : (n,) array of int
        Nodes to begin with.
    nodes : (k, 3) array of float
    first, neighbors : (k + 1,) and (2 e,) arrays of int
        Adjacency: the neighbors of node k are ``neighbors[first[k]:first[k + 1]]``.
    """
    if node_of_vertex.shape[0] != vertices.shape[0]:
        raise ValueError("there must be a node for each vertex")
    array = np.array(node_of_vertex)
    result: cython.longlong[::1] = array
    with cython.nogil:
        for vertex in range(vertices.shape[0]):
            nearest = result[vertex]
            dx, dy = nodes[nearest, 0] - vertices[vertex, 0], nodes[nearest, 1] - vertices[vertex, 1]
            dz = nodes[nearest, 2] - vertices[vertex, 2]
            smallest = dx * dx + dy * dy + dz * dz
            node = -1
            while nearest != node:
                node = nearest
                for at in range(first[node], first[node + 1]):
                    dx, dy = (
                        nodes[neighbors[at], 0] - vertices[vertex, 0],
                        nodes[neighbors[at], 1] - vertices[vertex, 1],
                    )
                    dz = nodes[neighbors[at], 2] - vertices[vertex, 2]
                    squared = dx * dx + dy * dy + dz * dz
                    if squared < smallest:
                        nearest, smallest = neighbors[at], squared
            result[vertex] = nearest
    return array


@cython.locals(edge=cython.Py_ssize_t, axis=cython.Py_ssize_t, i=cython.longlong, j=cython.longlong)
def neighbor_sums(
    edges: cython.const[cython.longlong][:, ::1], values: cython.const[cython.double][:, ::1]
) -> NDArray[np.float64]:
    """(n, k) sum of the (n, k) values over the neighbors of each vertex, by its (e, 2) edges."""
    array = np.zeros((values.shape[0], values.shape[1]))
    result: cython.double[:, ::1] = array
    with cython.nogil:
        for edge in range(edges.shape[0]):
            i, j = edges[edge, 0], edges[edge, 1]
            for axis in range(values.shape[1]):
                result[i, axis] += values[j, axis]
                result[j, axis] += values[i, axis]
    return array
