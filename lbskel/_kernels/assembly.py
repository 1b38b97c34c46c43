"""Assembly of sparse symmetric matrices from one off-diagonal entry for each corner of each face.

Entries above the diagonal are sorted into buckets by row, and from these into buckets by column, in which the rows are
then ascending. Entries of the same row and column are summed in the order of the faces, and each sum is written on both
sides of the diagonal, so the result is exactly symmetric.
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
    middle: cython.double[::1] = np.array(diagonal)
    by_row: cython.longlong[::1] = np.zeros(n + 2, dtype=np.int64)  # where the entries of each row begin
    by_column: cython.longlong[::1] = np.zeros(n + 2, dtype=np.int64)
    with cython.nogil:
        for face in range(m):
            for k in range(3):
                i, j = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
                if i == j:  # both entries are on the diagonal
                    middle[i] += entries[face, k]
                    middle[i] += entries[face, k]
                else:
                    by_row[min(i, j) + 2] += 1
                    by_column[max(i, j) + 2] += 1
        for i in range(n):
            by_row[i + 2] += by_row[i + 1]
            by_column[i + 2] += by_column[i + 1]
    columns: cython.int[::1] = np.empty(by_row[n + 1], dtype=np.int32)
    rows: cython.int[::1] = np.empty(by_row[n + 1], dtype=np.int32)
    row_values: cython.double[::1] = np.empty(by_row[n + 1])
    values: cython.double[::1] = np.empty(by_row[n + 1])
    starts_array = np.zeros(n + 1, dtype=np.int32)
    starts: cython.int[::1] = starts_array
    with cython.nogil:
        for face in range(m):
            for k in range(3):
                i, j = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
                if i != j:
                    entry = by_row[min(i, j) + 1]
                    columns[entry], row_values[entry] = max(i, j), entries[face, k]
                    by_row[min(i, j) + 1] += 1
        for i in range(n):
            for entry in range(by_row[i], by_row[i + 1]):
                j = columns[entry]
                rows[by_column[j + 1]], values[by_column[j + 1]] = i, row_values[entry]
                by_column[j + 1] += 1
        for j in range(n):  # sum equal entries in place, and count those of each column of the result
            size = entry = by_column[j]
            while entry < by_column[j + 1]:
                i, total = rows[entry], 0.0
                while entry < by_column[j + 1] and rows[entry] == i:
                    total += values[entry]
                    entry += 1
                if total != 0:
                    rows[size], values[size] = i, total
                    size += 1
                    starts[i + 1] += 1
            starts[j + 1] += size - by_column[j] + (middle[j] != 0)
            by_row[j] = size  # where the sums of the column end
        for j in range(n):
            starts[j + 1] += starts[j]
    result_rows_array, result_array = np.empty(starts[n], dtype=np.int32), np.empty(starts[n])
    result_rows: cython.int[::1] = result_rows_array
    result: cython.double[::1] = result_array
    fill: cython.int[::1] = np.array(starts_array)
    with cython.nogil:
        for j in range(n):  # the entries of column i below the diagonal are those of row i in later columns
            for entry in range(by_column[j], by_row[j]):
                i = rows[entry]
                result_rows[fill[j]], result[fill[j]] = i, values[entry]
                result_rows[fill[i]], result[fill[i]] = j, values[entry]
                fill[j] += 1
                fill[i] += 1
            if middle[j] != 0:
                result_rows[fill[j]], result[fill[j]] = j, middle[j]
                fill[j] += 1
    return result_array, result_rows_array, starts_array
