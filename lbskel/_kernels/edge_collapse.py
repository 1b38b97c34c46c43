"""Short edges of a mesh, and the choice of edges that can be collapsed at once without a change of topology."""

from __future__ import annotations

__all__ = ["independent_collapses", "short_edges"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt


@cython.locals(n=cython.Py_ssize_t, face=cython.Py_ssize_t, corner=cython.Py_ssize_t, axis=cython.Py_ssize_t)
@cython.locals(
    i=cython.longlong, j=cython.longlong, difference=cython.double, squared=cython.double, limit=cython.double
)
def short_edges(
    V: cython.const[cython.double][:, ::1],
    F: cython.const[cython.longlong][:, ::1],
    limits: cython.const[cython.double][::1],
    both_directions: cython.bint,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """(k, 2) edges shorter than the limits at both ends, (k,) their numbers among all edges, and (k,) their lengths.

    Parameters
    ----------
    V : (n, 3) array of float
    F : (m, 3) array of int
    limits : (n,) array of float
        Length limit at each vertex.
    both_directions : bool
        Whether every half-edge counts, so that edges occur more than once; else only those from the lower vertex to
        the higher, which is every edge of a closed oriented manifold once.
    """
    n = 0
    count: cython.longlong = 0
    edges_array = np.empty((3 * F.shape[0], 2), dtype=np.int64)
    numbers_array, lengths_array = np.empty(len(edges_array), dtype=np.int64), np.empty(len(edges_array))
    edges: cython.longlong[:, ::1] = edges_array
    numbers: cython.longlong[::1] = numbers_array
    lengths: cython.double[::1] = lengths_array
    with cython.nogil:
        for corner in range(3):
            for face in range(F.shape[0]):
                i, j = F[face, (corner + 1) % 3], F[face, (corner + 2) % 3]
                if i > j and not both_directions:  # the other half-edge of the same edge
                    continue
                squared = 0.0
                for axis in range(3):
                    difference = V[i, axis] - V[j, axis]
                    squared += difference * difference
                limit = min(limits[i], limits[j])
                if squared < limit * limit:
                    edges[n, 0], edges[n, 1], numbers[n], lengths[n] = i, j, count, sqrt(squared)
                    n += 1
                count += 1
    return edges_array[:n], numbers_array[:n], lengths_array[:n]


@cython.locals(
    slot=cython.Py_ssize_t,
    edge=cython.Py_ssize_t,
    _round=cython.Py_ssize_t,
    common=cython.Py_ssize_t,
    vertex=cython.Py_ssize_t,
)
def independent_collapses(
    F: cython.const[cython.longlong][:, ::1],
    n: cython.Py_ssize_t,
    i: cython.const[cython.longlong][::1],
    j: cython.const[cython.longlong][::1],
    rounds: cython.Py_ssize_t,
) -> NDArray[np.bool_]:
    """(k,) whether each edge is chosen for collapse.

    A candidate is an edge whose ends have no other common neighbors than the third corners of its faces, which is the
    link condition for vertices, and each of these corners has another face at one of the ends, so that it keeps one.
    In each round, the candidates are chosen that precede every other candidate at their ends and at the neighbors of
    these; candidates with an end in the neighborhood of a chosen edge are then dropped.

    Parameters
    ----------
    F : (m, 3) array of int
    n : int
        Number of vertices.
    i, j : (k,) array of int
        Ends of the edges, in order of preference.
    rounds : int
        Number of rounds.
    """
    n_edges: cython.Py_ssize_t = i.shape[0]
    n_candidates: cython.Py_ssize_t = 0
    m: cython.Py_ssize_t = F.shape[0]
    first: cython.longlong[::1] = np.zeros(n + 2, dtype=np.int64)
    neighbors: cython.longlong[::1] = np.empty(6 * m, dtype=np.int64)
    mark: cython.longlong[::1] = np.full(n, -1, dtype=np.int64)
    candidates: cython.longlong[::1] = np.empty(n_edges, dtype=np.int64)
    chosen_array = np.zeros(n_edges, dtype=np.int8)
    chosen: cython.schar[::1] = chosen_array
    with cython.nogil:
        _adjacency(F, n, first, neighbors)
        for edge in range(n_edges):
            if _can_collapse(first, neighbors, mark, i[edge], j[edge], 3 * edge):
                candidates[n_candidates] = edge
                n_candidates += 1
        for _round in range(rounds):
            for vertex in range(n):
                mark[vertex] = n_edges
            for slot in range(n_candidates - 1, -1, -1):
                mark[i[candidates[slot]]] = mark[j[candidates[slot]]] = candidates[slot]
            for slot in range(n_candidates):
                edge = candidates[slot]
                chosen[edge] = _is_first(first, neighbors, mark, i[edge], edge) and _is_first(
                    first, neighbors, mark, j[edge], edge
                )
            for vertex in range(n):
                mark[vertex] = 0
            for slot in range(n_candidates):
                edge = candidates[slot]
                if chosen[edge]:
                    _block(first, neighbors, mark, i[edge])
                    _block(first, neighbors, mark, j[edge])
            common, n_candidates = n_candidates, 0
            for slot in range(common):
                edge = candidates[slot]
                if mark[i[edge]] == 0 and mark[j[edge]] == 0:
                    candidates[n_candidates] = edge
                    n_candidates += 1
    return chosen_array.astype(bool)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(face=cython.Py_ssize_t, corner=cython.Py_ssize_t, vertex=cython.Py_ssize_t)
def _adjacency(
    F: cython.const[cython.longlong][:, ::1],
    n: cython.Py_ssize_t,
    first: cython.longlong[::1],
    neighbors: cython.longlong[::1],
) -> cython.void:
    """Write the other corners of each face at vertex i to ``neighbors[first[i]:first[i + 1]]``, two for each face.

    ``first`` has n + 2 entries.
    """
    for face in range(F.shape[0]):
        for corner in range(3):
            first[F[face, corner] + 2] += 2
    for vertex in range(n):
        first[vertex + 2] += first[vertex + 1]
    for face in range(F.shape[0]):
        for corner in range(3):
            vertex = F[face, corner]
            neighbors[first[vertex + 1]] = F[face, (corner + 1) % 3]
            neighbors[first[vertex + 1] + 1] = F[face, (corner + 2) % 3]
            first[vertex + 1] += 2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t)
def _can_collapse(
    first: cython.longlong[::1],
    neighbors: cython.longlong[::1],
    mark: cython.longlong[::1],
    i: cython.longlong,
    j: cython.longlong,
    free: cython.longlong,
) -> cython.bint:
    """Whether the third corners of the faces at an edge are its only common neighbors, and all keep another face.

    ``mark`` may hold any numbers below ``free``; afterwards it holds numbers up to ``free + 2``.
    """
    for slot in range(first[i], first[i + 1]):
        mark[neighbors[slot]] = free
    for slot in range(first[i], first[i + 1], 2):
        if neighbors[slot] == j:
            mark[neighbors[slot + 1]] = free + 1
        elif neighbors[slot + 1] == j:
            mark[neighbors[slot]] = free + 1
    for slot in range(first[j], first[j + 1]):
        if mark[neighbors[slot]] == free:
            return False
    _mark_kept(first, neighbors, mark, i, j, free + 1)
    _mark_kept(first, neighbors, mark, j, i, free + 1)
    keeps_all: cython.bint = True
    for slot in range(first[i], first[i + 1]):
        keeps_all = keeps_all and mark[neighbors[slot]] != free + 1
    return keeps_all


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t, side=cython.Py_ssize_t)
def _mark_kept(
    first: cython.longlong[::1],
    neighbors: cython.longlong[::1],
    mark: cython.longlong[::1],
    vertex: cython.longlong,
    other: cython.longlong,
    apex: cython.longlong,
) -> cython.void:
    """Raise the mark ``apex`` by one at the corners of the faces at a vertex that do not have the other vertex."""
    for slot in range(first[vertex], first[vertex + 1], 2):
        if neighbors[slot] != other and neighbors[slot + 1] != other:
            for side in range(2):
                if mark[neighbors[slot + side]] == apex:
                    mark[neighbors[slot + side]] = apex + 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t)
def _is_first(
    first: cython.longlong[::1],
    neighbors: cython.longlong[::1],
    smallest: cython.longlong[::1],
    vertex: cython.Py_ssize_t,
    edge: cython.Py_ssize_t,
) -> cython.bint:
    """Whether no candidate at a vertex or at its neighbors precedes this edge."""
    for slot in range(first[vertex], first[vertex + 1]):
        if smallest[neighbors[slot]] < edge:
            return False
    return smallest[vertex] == edge


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t)
def _block(
    first: cython.longlong[::1], neighbors: cython.longlong[::1], mark: cython.longlong[::1], vertex: cython.Py_ssize_t
) -> cython.void:
    """Mark a vertex and its neighbors as touched by a collapse."""
    mark[vertex] = 1
    for slot in range(first[vertex], first[vertex + 1]):
        mark[neighbors[slot]] = 1
