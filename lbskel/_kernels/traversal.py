"""Traversals that follow one another: faces from a first one across their edges, the branches of a graph."""

from __future__ import annotations

__all__ = ["breadth_first_faces", "pair_half_edges", "sums_along_paths", "walk_branches"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython


@cython.locals(side=cython.Py_ssize_t, edge=cython.longlong)
def pair_half_edges(
    edge_of_half_edge: cython.const[cython.longlong][::1], faces_per_edge: cython.const[cython.longlong][::1]
) -> NDArray[np.int64]:
    """(h,) the other half-edge at an edge of two faces; -1 at other edges.

    Parameters
    ----------
    edge_of_half_edge : (h,) array of int
    faces_per_edge : (e,) array of int
        How many half-edges each edge has.
    """
    array = np.full(edge_of_half_edge.shape[0], -1, dtype=np.int64)
    twins: cython.longlong[::1] = array
    first: cython.longlong[::1] = np.full(faces_per_edge.shape[0], -1, dtype=np.int64)
    with cython.nogil:
        for side in range(edge_of_half_edge.shape[0]):
            edge = edge_of_half_edge[side]
            if faces_per_edge[edge] != 2:
                continue
            if first[edge] < 0:
                first[edge] = side
            else:
                twins[side], twins[first[edge]] = first[edge], side
    return array


@cython.locals(
    at=cython.Py_ssize_t,
    end=cython.Py_ssize_t,
    turn=cython.Py_ssize_t,
    m=cython.Py_ssize_t,
    side=cython.longlong,
)
def breadth_first_faces(
    twins: cython.const[cython.longlong][::1], starts: cython.const[cython.longlong][::1]
) -> NDArray[np.int64]:
    """Enter the faces of a surface across their edges, breadth first.

    Parameters
    ----------
    twins : (3 m,) array of int
        As of :func:`pair_half_edges`; half-edge ``k * m + f`` is opposite corner k of face f.
    starts : (p,) array of int
        Half-edges of different faces, at which to begin.

    Returns
    -------
    (k,) array of int
        The half-edge by which each face is entered, in the order in which they are; the other neighbors of a face
        follow in the sense of its orientation from there.
    """
    m = twins.shape[0] // 3
    array = np.empty(m, dtype=np.int64)
    entered: cython.longlong[::1] = array
    is_entered: cython.schar[::1] = np.zeros(m, dtype=np.int8)
    at, end = 0, 0
    with cython.nogil:
        for turn in range(starts.shape[0]):
            side = starts[turn]
            if not is_entered[side % m]:
                is_entered[side % m] = 1
                entered[end] = side
                end += 1
        while at < end:
            for turn in range(3):
                side = twins[(entered[at] + turn * m) % (3 * m)]
                if side >= 0 and not is_entered[side % m]:
                    is_entered[side % m] = 1
                    entered[end] = side
                    end += 1
            at += 1
    return array[:end]


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(low=cython.longlong, high=cython.longlong, middle=cython.longlong)
def _position(
    first: cython.const[cython.longlong][::1],
    neighbors: cython.const[cython.longlong][::1],
    node: cython.longlong,
    neighbor: cython.longlong,
) -> cython.longlong:
    """Where a neighbor of a node stands in the list of all, in which those of a node ascend."""
    low, high = first[node], first[node + 1] - 1
    while low < high:
        middle = (low + high) // 2
        if neighbors[middle] < neighbor:
            low = middle + 1
        else:
            high = middle
    return low


@cython.locals(
    start=cython.Py_ssize_t,
    at=cython.longlong,
    step=cython.longlong,
    node=cython.longlong,
    following=cython.longlong,
    k=cython.Py_ssize_t,
    n_nodes=cython.Py_ssize_t,
    n_walks=cython.Py_ssize_t,
    is_loop=cython.Py_ssize_t,
)
def walk_branches(
    first: cython.const[cython.longlong][::1], neighbors: cython.const[cython.longlong][::1]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Walk along the paths of a graph whose inner nodes have two neighbors.

    Paths between nodes with another number of neighbors come first, by their first nodes; then the loops without one,
    which repeat their first node.

    Parameters
    ----------
    first, neighbors : (k + 1,) and (2 e,) arrays of int
        Adjacency: the neighbors of node k are ``neighbors[first[k]:first[k + 1]]``, in ascending order.

    Returns
    -------
    nodes : (e + b,) array of int
        Those of all b paths, one after the other.
    begins : (b + 1,) array of int
        Where each begins, and the end of the last.
    """
    k = first.shape[0] - 1
    nodes_array = np.empty(neighbors.shape[0], dtype=np.int64)  # e + b, and no path is without an edge
    begins_array = np.zeros(neighbors.shape[0] // 2 + 1, dtype=np.int64)
    nodes: cython.longlong[::1] = nodes_array
    begins: cython.longlong[::1] = begins_array
    is_used: cython.schar[::1] = np.zeros(neighbors.shape[0], dtype=np.int8)
    n_nodes, n_walks = 0, 0
    with cython.nogil:
        for is_loop in range(2):
            for start in range(k):
                if (first[start + 1] - first[start] == 2) != (is_loop == 1):
                    continue
                for at in range(first[start], first[start + 1]):
                    if is_used[at]:
                        continue
                    nodes[n_nodes] = start
                    n_nodes += 1
                    node, step = start, at
                    while True:
                        following = neighbors[step]
                        is_used[step] = 1
                        step = _position(first, neighbors, following, node)
                        is_used[step] = 1
                        nodes[n_nodes] = following
                        n_nodes += 1
                        if following == start or first[following + 1] - first[following] != 2:
                            break
                        step = 2 * first[following] + 1 - step  # the other of two
                        node = following
                    n_walks += 1
                    begins[n_walks] = n_nodes
    return nodes_array[:n_nodes], begins_array[: n_walks + 1]


@cython.locals(path=cython.Py_ssize_t, i=cython.Py_ssize_t, total=cython.double)
def sums_along_paths(
    steps: cython.const[cython.double][::1], begins: cython.const[cython.longlong][::1]
) -> NDArray[np.float64]:
    """(n,) sum of the steps of a path up to each of its nodes, 0 at the first.

    Parameters
    ----------
    steps : (n,) array of float
        From the node before to each node of paths laid end to end; those to the first nodes do not count.
    begins : (p + 1,) array of int
        Where each path begins, and the end of the last.
    """
    array = np.zeros(steps.shape[0])
    sums: cython.double[::1] = array
    with cython.nogil:
        for path in range(begins.shape[0] - 1):
            total = 0.0
            for i in range(begins[path] + 1, begins[path + 1]):
                total += steps[i]
                sums[i] = total
    return array
