"""Products such as S^T S and S M^-1 S, with a bound on their memory: a row of k entries becomes a dense block of k x k.

Such a row belongs to the center of a fan of k triangles, as at a closed hole or in a cap of a CAD model. The
factorization takes k^3 steps.
"""

from __future__ import annotations

__all__ = ["matrix_product"]

import numpy as np
from scipy.sparse import csc_array

from lbskel.errors import MeshError

# Row from which blocks are counted, in entries: a block of that size takes 0.2 GB. Meshes of any size whose rows are
# shorter, as those of nearly all are, have no bound but memory.
LONG_ROW = 1000
# Upper bound on the entries of blocks. As measured on fans of 1,000 to 4,000 triangles each takes 130 bytes while the
# matrix is factorized, and 200 where anchors are chosen: 6.5 and 10 GB. One vertex of 7,000 neighbors has as many.
MAX_ENTRIES = 50_000_000


def matrix_product(A: csc_array, B: csc_array, dimensions: int = 1) -> csc_array:
    """Multiply two matrices of which one is like the transpose of the other.

    Parameters
    ----------
    A, B : (m, m) csc_array
        Column r of A has about as many entries as row r of B.
    dimensions : int
        Number of rows for each vertex.

    Raises
    ------
    MeshError
        If rows are so long that memory might run out; the vertex of the longest is named.
    """
    rows = B.tocsr()
    lengths = np.diff(rows.indptr).astype(np.int64)
    is_long = lengths > dimensions * LONG_ROW
    if is_long.any():
        n_coupled = len(np.unique(rows[np.flatnonzero(is_long)].indices))  # their blocks may overlap
        n_entries = min(int((lengths[is_long] ** 2).sum()), n_coupled**2)
        if n_entries > MAX_ENTRIES:
            longest = int(lengths.argmax())
            raise MeshError(
                f"vertex {longest // dimensions} has {lengths[longest] // dimensions - 1:,} neighbors: the squared "
                f"matrix has {n_entries:,} entries where rows are as long, at most {MAX_ENTRIES:,}; divide the fan of "
                "triangles by the preprocessing step remesh_isotropic, or take a method that squares no matrix: "
                "'implicit' to smooth, 'harmonic' to edit"
            )
    product: csc_array = (A @ B).tocsc()
    return product
