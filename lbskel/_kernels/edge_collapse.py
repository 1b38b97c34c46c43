# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Short edges, and which of them collapse together: those that keep the topology and come first where they touch."""

from __future__ import annotations

__all__ = ["independent_collapses", "short_edges"]

import cython
import numpy as np
from cython.cimports.libc.math import sqrt
from numpy.typing import NDArray


@cython.locals(n=cython.Py_ssize_t, face=cython.Py_ssize_t, corner=cython.Py_ssize_t, axis=cython.Py_ssize_t)
@cython.locals(i=cython.longlong, j=cython.longlong, far=cython.double, squared=cython.double, limit=cython.double)
def short_edges(
    V: cython.const[cython.double][:, ::1],
    F: cython.const[cython.longlong][:, ::1],
    limits: cython.const[cython.double][::1],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """(k, 2) edges of a closed manifold shorter than the limits at both ends, their places among all, and lengths."""
    n = 0
    count: cython.longlong = 0
    edges_array = np.empty((3 * F.shape[0] // 2 + 1, 2), dtype=np.int64)
    places_array, lengths_array = np.empty(len(edges_array), dtype=np.int64), np.empty(len(edges_array))
    edges: cython.longlong[:, ::1] = edges_array
    places: cython.longlong[::1] = places_array
    lengths: cython.double[::1] = lengths_array
    for corner in range(3):
        for face in range(F.shape[0]):
            i, j = F[face, (corner + 1) % 3], F[face, (corner + 2) % 3]
            if i > j:  # the other side of the same edge
                continue
            squared = 0.0
            for axis in range(3):
                far = V[i, axis] - V[j, axis]
                squared += far * far
            limit = min(limits[i], limits[j])
            if squared < limit * limit:
                edges[n, 0], edges[n, 1], places[n], lengths[n] = i, j, count, sqrt(squared)
                n += 1
            count += 1
    return edges_array[:n], places_array[:n], lengths_array[:n]


@cython.locals(
    at=cython.Py_ssize_t,
    edge=cython.Py_ssize_t,
    _turn=cython.Py_ssize_t,
    common=cython.Py_ssize_t,
    vertex=cython.Py_ssize_t,
)
def independent_collapses(
    F: cython.const[cython.longlong][:, ::1],
    n: cython.Py_ssize_t,
    i: cython.const[cython.longlong][::1],
    j: cython.const[cython.longlong][::1],
    selections: cython.Py_ssize_t,
) -> NDArray[np.bool_]:
    """Whether each edge is chosen, of a closed manifold with n vertices.

    Edges count whose ends have just two neighbors in common. Those go that come before all others at their ends and
    at the neighbors of these; then, so many times, the same of the edges that are left beside none that went.
    """
    n_edges: cython.Py_ssize_t = i.shape[0]
    n_left: cython.Py_ssize_t = 0
    m: cython.Py_ssize_t = F.shape[0]
    first: cython.longlong[::1] = np.zeros(n + 2, dtype=np.int64)
    beside: cython.longlong[::1] = np.empty(3 * m, dtype=np.int64)
    mark: cython.longlong[::1] = np.full(n, -1, dtype=np.int64)
    left: cython.longlong[::1] = np.empty(n_edges, dtype=np.int64)
    chosen_array = np.zeros(n_edges, dtype=np.int8)
    chosen: cython.schar[::1] = chosen_array
    _neighbors(F, n, first, beside)
    for edge in range(n_edges):
        for at in range(first[i[edge]], first[i[edge] + 1]):
            mark[beside[at]] = edge
        common = 0
        for at in range(first[j[edge]], first[j[edge] + 1]):
            common += mark[beside[at]] == edge
        if common == 2:
            left[n_left] = edge
            n_left += 1
    for _turn in range(selections):
        for vertex in range(n):
            mark[vertex] = n_edges
        for at in range(n_left - 1, -1, -1):
            mark[i[left[at]]] = mark[j[left[at]]] = left[at]
        for at in range(n_left):
            edge = left[at]
            chosen[edge] = _is_first(first, beside, mark, i[edge], edge) and _is_first(
                first, beside, mark, j[edge], edge
            )
        for vertex in range(n):
            mark[vertex] = 0
        for at in range(n_left):
            edge = left[at]
            if chosen[edge]:
                _block(first, beside, mark, i[edge])
                _block(first, beside, mark, j[edge])
        common, n_left = n_left, 0
        for at in range(common):
            edge = left[at]
            if mark[i[edge]] == 0 and mark[j[edge]] == 0:
                left[n_left] = edge
                n_left += 1
    return chosen_array.astype(bool)


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(face=cython.Py_ssize_t, corner=cython.Py_ssize_t, vertex=cython.Py_ssize_t)
def _neighbors(
    F: cython.const[cython.longlong][:, ::1],
    n: cython.Py_ssize_t,
    first: cython.longlong[::1],
    beside: cython.longlong[::1],
) -> cython.void:
    """Write the neighbors of each vertex in a row, and where those of the first and of each after it begin."""
    for face in range(F.shape[0]):
        for corner in range(3):
            first[F[face, corner] + 2] += 1
    for vertex in range(n):
        first[vertex + 2] += first[vertex + 1]
    for face in range(F.shape[0]):  # of a closed manifold each neighbor follows its vertex in just one face
        for corner in range(3):
            vertex = F[face, corner]
            beside[first[vertex + 1]] = F[face, (corner + 1) % 3]
            first[vertex + 1] += 1


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(at=cython.Py_ssize_t)
def _is_first(
    first: cython.longlong[::1],
    beside: cython.longlong[::1],
    least: cython.longlong[::1],
    vertex: cython.Py_ssize_t,
    edge: cython.Py_ssize_t,
) -> cython.bint:
    """Whether no edge comes before this one at a vertex and its neighbors."""
    for at in range(first[vertex], first[vertex + 1]):
        if least[beside[at]] < edge:
            return False
    return least[vertex] == edge


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(at=cython.Py_ssize_t)
def _block(
    first: cython.longlong[::1], beside: cython.longlong[::1], mark: cython.longlong[::1], vertex: cython.Py_ssize_t
) -> cython.void:
    """Mark a vertex and its neighbors."""
    mark[vertex] = 1
    for at in range(first[vertex], first[vertex + 1]):
        mark[beside[at]] = 1
