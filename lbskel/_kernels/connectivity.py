# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Along the edges of a surface: what hangs together, fans round vertices, sums over neighbors, nearer nodes."""

from __future__ import annotations

__all__ = ["fans", "nearer_nodes", "pieces", "sums_beside"]

import cython
import numpy as np
from numpy.typing import NDArray


@cython.locals(edge=cython.Py_ssize_t, i=cython.longlong, j=cython.longlong)
def pieces(
    edges: cython.const[cython.longlong][:, ::1], labels: cython.const[cython.longlong][::1]
) -> NDArray[np.int64]:
    """(n,) the least vertex that each hangs together with by edges between vertices of its own label, if not negative.

    By union and find: Tarjan 1975, "Efficiency of a good but not linear set union algorithm",
    https://doi.org/10.1145/321879.321884.
    """
    n: cython.Py_ssize_t = labels.shape[0]
    array = np.arange(n)
    least: cython.longlong[::1] = array
    for edge in range(edges.shape[0]):
        i, j = edges[edge, 0], edges[edge, 1]
        if labels[i] != labels[j] or labels[i] < 0:
            continue
        while least[i] != i:
            least[i] = least[least[i]]
            i = least[i]
        while least[j] != j:
            least[j] = least[least[j]]
            j = least[j]
        least[max(i, j)] = min(i, j)
    for edge in range(n):  # in ascending order that before is done
        least[edge] = least[least[edge]]
    return array


@cython.locals(side=cython.Py_ssize_t, at=cython.Py_ssize_t, edge=cython.longlong)
def fans(
    F: cython.const[cython.longlong][:, ::1],
    edge_of_side: cython.const[cython.longlong][::1],
    n_edges: cython.Py_ssize_t,
) -> int:
    """How many fans of faces there are about corners: one for each vertex, or more where a surface is pinched there.

    Every edge has two sides; -1 where not all of them run opposite ways. Side k lies opposite corner k // m of face
    k % m, as in ``Mesh.half_edges``.
    """
    m: cython.Py_ssize_t = F.shape[0]
    count: cython.Py_ssize_t = 0
    twins: cython.longlong[::1] = np.empty(3 * m, dtype=np.int64)
    first: cython.longlong[::1] = np.full(n_edges, -1, dtype=np.int64)
    is_seen: cython.schar[::1] = np.zeros(3 * m, dtype=np.int8)
    for side in range(3 * m):
        edge = edge_of_side[side]
        if first[edge] < 0:
            first[edge] = side
            continue
        at = first[edge]
        if F[side % m, (side // m + 1) % 3] == F[at % m, (at // m + 1) % 3]:
            return -1
        twins[side], twins[at] = at, side
    for side in range(3 * m):
        if is_seen[side]:
            continue
        count += 1
        at = side
        while not is_seen[at]:
            is_seen[at] = 1
            at = (twins[(at + m) % (3 * m)] + m) % (3 * m)  # across the side that leaves the corner
    return count


@cython.locals(
    vertex=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    at=cython.Py_ssize_t,
    nearest=cython.Py_ssize_t,
    dx=cython.double,
    dy=cython.double,
    dz=cython.double,
    far=cython.double,
    least=cython.double,
)
def nearer_nodes(
    vertices: cython.const[cython.double][:, ::1],
    node_of_vertex: cython.const[cython.longlong][::1],
    nodes: cython.const[cython.double][:, ::1],
    first: cython.const[cython.longlong][::1],
    beside: cython.const[cython.longlong][::1],
) -> NDArray[np.int64]:
    """(n,) the node of each vertex handed on to the nearest of it and those beside it, until it is the node itself.

    The nodes beside node k are those from ``beside[first[k]]`` on, before ``beside[first[k + 1]]``.
    """
    if node_of_vertex.shape[0] != vertices.shape[0]:
        raise ValueError("there must be a node for each vertex")
    array = np.array(node_of_vertex)
    result: cython.longlong[::1] = array
    for vertex in range(vertices.shape[0]):
        nearest = result[vertex]
        dx, dy = nodes[nearest, 0] - vertices[vertex, 0], nodes[nearest, 1] - vertices[vertex, 1]
        dz = nodes[nearest, 2] - vertices[vertex, 2]
        least = dx * dx + dy * dy + dz * dz
        node = -1
        while nearest != node:
            node = nearest
            for at in range(first[node], first[node + 1]):
                dx, dy = nodes[beside[at], 0] - vertices[vertex, 0], nodes[beside[at], 1] - vertices[vertex, 1]
                dz = nodes[beside[at], 2] - vertices[vertex, 2]
                far = dx * dx + dy * dy + dz * dz
                if far < least:
                    nearest, least = beside[at], far
        result[vertex] = nearest
    return array


@cython.locals(edge=cython.Py_ssize_t, axis=cython.Py_ssize_t, i=cython.longlong, j=cython.longlong)
def sums_beside(
    edges: cython.const[cython.longlong][:, ::1], values: cython.const[cython.double][:, ::1]
) -> NDArray[np.float64]:
    """(n, k) the sums of (n, k) values over the neighbors of each vertex."""
    array = np.zeros((values.shape[0], values.shape[1]))
    result: cython.double[:, ::1] = array
    for edge in range(edges.shape[0]):
        i, j = edges[edge, 0], edges[edge, 1]
        for axis in range(values.shape[1]):
            result[i, axis] += values[j, axis]
            result[j, axis] += values[i, axis]
    return array
