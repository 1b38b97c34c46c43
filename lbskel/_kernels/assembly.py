"""Assembly of sparse symmetric matrices from one off-diagonal entry for each corner of each face.

Entries are sorted into buckets by row, and from these into buckets by column, in which the rows are then ascending.
Entries of the same row and column are summed in the order of the faces. Both entries of an edge are summed in the same
order, so the result is exactly symmetric.
"""

from __future__ import annotations

__all__ = ["assemble_symmetric"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython


@cython.locals(face=cython.Py_ssize_t, k=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
@cython.locals(entry=cython.Py_ssize_t, size=cython.Py_ssize_t, total=cython.double)
def assemble_symmetric(
    F: cython.const[cython.longlong][:, ::1],
    entries: cython.const[cython.double][:, ::1],
    diagonal: cython.const[cython.double][::1],
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """Sparse matrix with a given diagonal and with ``entries[f, k]`` added at the edge opposite corner k of face f.

    Parameters
    ----------
    F : (m, 3) array of int
    entries : (m, 3) array of float
        Added at (i, j) and at (j, i), where i and j are the ends of the edge.
    diagonal : (n,) array of float

    Returns
    -------
    tuple
        The nonzero values, the row of each, and the (n + 1,) offset of each column, as in scipy's CSC format.
    """
    n: cython.Py_ssize_t = diagonal.shape[0]
    m: cython.Py_ssize_t = F.shape[0]
    offsets: cython.longlong[::1] = np.zeros(n + 1, dtype=np.int64)
    with cython.nogil:
        for i in range(n):
            offsets[i + 1] = 1
        for face in range(m):
            for k in range(3):
                offsets[F[face, k] + 1] += 2  # each vertex of a face is an end of two of its edges
        for i in range(n):
            offsets[i + 1] += offsets[i]
    fill: cython.longlong[::1] = np.array(offsets[:n])
    columns: cython.int[::1] = np.empty(offsets[n], dtype=np.int32)
    by_row: cython.double[::1] = np.empty(offsets[n])
    with cython.nogil:
        for i in range(n):
            columns[fill[i]], by_row[fill[i]] = i, diagonal[i]
            fill[i] += 1
        for face in range(m):
            for k in range(3):
                i, j = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
                columns[fill[i]], by_row[fill[i]] = j, entries[face, k]
                fill[i] += 1
                columns[fill[j]], by_row[fill[j]] = i, entries[face, k]
                fill[j] += 1
    rows_array, values_array = np.empty(offsets[n], dtype=np.int32), np.empty(offsets[n])
    rows: cython.int[::1] = rows_array
    values: cython.double[::1] = values_array
    starts_array = np.zeros(n + 1, dtype=np.int32)
    starts: cython.int[::1] = starts_array
    fill[:] = offsets[:n]
    with cython.nogil:
        for i in range(n):
            for entry in range(offsets[i], offsets[i + 1]):
                j = columns[entry]
                rows[fill[j]], values[fill[j]] = i, by_row[entry]
                fill[j] += 1
        size = 0
        for j in range(n):
            entry = offsets[j]
            while entry < offsets[j + 1]:
                i, total = rows[entry], 0.0
                while entry < offsets[j + 1] and rows[entry] == i:
                    total += values[entry]
                    entry += 1
                if total != 0:
                    rows[size], values[size] = i, total
                    size += 1
            starts[j + 1] = size
    return values_array[:size], rows_array[:size], starts_array
