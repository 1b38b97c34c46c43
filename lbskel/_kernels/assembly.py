# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Sparse symmetric matrices put together from what the edges of each face add.

All is put in buckets by row, and from those into others by column, where rows then stand in ascending order. What
belongs to one place is added in the order of the faces, at both places of an edge alike, so that the two are equal.
"""

from __future__ import annotations

__all__ = ["symmetric"]

import cython
import numpy as np
from numpy.typing import NDArray


@cython.locals(face=cython.Py_ssize_t, k=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
@cython.locals(at=cython.Py_ssize_t, size=cython.Py_ssize_t, total=cython.double)
def symmetric(
    F: cython.const[cython.longlong][:, ::1],
    entries: cython.const[cython.double][:, ::1],
    diagonal: cython.const[cython.double][::1],
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """The values that are not zero, the row of each, and where each column begins.

    To the diagonal ``entries[f, k]`` is added at both places of the edge opposite corner k of face f.
    """
    n: cython.Py_ssize_t = diagonal.shape[0]
    m: cython.Py_ssize_t = F.shape[0]
    begins: cython.longlong[::1] = np.zeros(n + 1, dtype=np.int64)
    for i in range(n):
        begins[i + 1] = 1
    for face in range(m):
        for k in range(3):
            begins[F[face, k] + 1] += 2  # an edge to either side
    for i in range(n):
        begins[i + 1] += begins[i]
    ends: cython.longlong[::1] = np.array(begins[:n])
    columns: cython.int[::1] = np.empty(begins[n], dtype=np.int32)
    by_row: cython.double[::1] = np.empty(begins[n])
    for i in range(n):
        columns[ends[i]], by_row[ends[i]] = i, diagonal[i]
        ends[i] += 1
    for face in range(m):
        for k in range(3):
            i, j = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
            columns[ends[i]], by_row[ends[i]] = j, entries[face, k]
            ends[i] += 1
            columns[ends[j]], by_row[ends[j]] = i, entries[face, k]
            ends[j] += 1
    rows_array, values_array = np.empty(begins[n], dtype=np.int32), np.empty(begins[n])
    rows: cython.int[::1] = rows_array
    values: cython.double[::1] = values_array
    ends[:] = begins[:n]
    for i in range(n):
        for at in range(begins[i], begins[i + 1]):
            j = columns[at]
            rows[ends[j]], values[ends[j]] = i, by_row[at]
            ends[j] += 1
    starts_array = np.zeros(n + 1, dtype=np.int32)
    starts: cython.int[::1] = starts_array
    size = 0
    for j in range(n):
        at = begins[j]
        while at < begins[j + 1]:
            i, total = rows[at], 0.0
            while at < begins[j + 1] and rows[at] == i:
                total += values[at]
                at += 1
            if total != 0:
                rows[size], values[size] = i, total
                size += 1
        starts[j + 1] = size
    return values_array[:size], rows_array[:size], starts_array
