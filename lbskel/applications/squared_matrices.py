"""Products such as S^T S and S M^-1 S, with a bound on their memory: a row of k entries becomes a dense block of k x k.

Such a row belongs to the center of a fan of k triangles, as at a closed hole or in a cap of a CAD model. The
factorization takes k^3 steps.
"""

from __future__ import annotations

__all__ = ["matrix_product"]

import numpy as np
from scipy.sparse import csc_array

from lbskel.errors import MeshError

# Upper bound on the neighbors of a vertex; it bounds the memory. By the bytes per square in benchmarks/results/fans.md,
# two such vertices, as in the caps of a tube, take 7 GB to smooth and 9 GB to quantize
MAX_NEIGHBORS = 5_000


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
        If a vertex has so many neighbors that memory might run out; the one with the most is named.
    """
    n_neighbors = np.diff(B.tocsr().indptr) // dimensions - 1
    longest = int(n_neighbors.argmax()) if len(n_neighbors) else 0
    if len(n_neighbors) and n_neighbors[longest] > MAX_NEIGHBORS:
        raise MeshError(
            f"vertex {longest // dimensions} has {n_neighbors[longest]:,} neighbors, more than {MAX_NEIGHBORS:,}: the "
            "squared matrix might not fit in memory; divide the fan of triangles by the preprocessing step "
            "remesh_isotropic, or take a method that squares no matrix: 'implicit' to smooth, 'harmonic' to edit"
        )
    product: csc_array = (A @ B).tocsc()
    return product
