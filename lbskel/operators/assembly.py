"""Assembly of stiffness matrices from weights of triangle corners or of pairs of vertices."""

from __future__ import annotations

__all__ = ["diagonal_matrix", "stiffness_of_corner_weights", "stiffness_of_pairs", "symmetric_matrix"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel._kernels.assembly import assemble_symmetric


def diagonal_matrix(values: NDArray[Any]) -> csc_array:
    """Build the (n, n) matrix with these (n,) values on its diagonal."""
    n = len(values)
    return csc_array((np.asarray(values, dtype=np.float64), np.arange(n), np.arange(n + 1)), shape=(n, n))


def symmetric_matrix(faces: NDArray[np.int64], edge_entries: NDArray[np.float64], diagonal: NDArray[Any]) -> csc_array:
    """Build a symmetric matrix from its diagonal and contributions of edges.

    Parameters
    ----------
    faces : (m, 3) array of int
    edge_entries : (m, 3) array of float
        ``edge_entries[f, k]`` is added to both off-diagonal entries of the edge opposite corner k of face f.
    diagonal : (n,) array
    """
    n = len(diagonal)
    entries = np.ascontiguousarray(edge_entries, dtype=np.float64)
    return csc_array(assemble_symmetric(faces, entries, np.asarray(diagonal, dtype=np.float64)), shape=(n, n))


def stiffness_of_corner_weights(n: int, faces: NDArray[np.int64], weights: NDArray[np.float64]) -> csc_array:
    """Build the stiffness of n vertices whose edge weights are sums over the corners opposite each edge.

    Parameters
    ----------
    n : int
    faces : (m, 3) array of int
    weights : (m, 3) array of float
        ``weights[f, k]`` is added to the weight of the edge opposite corner k of face f.
    """
    a, b, c = weights.T
    row_sums = np.stack([b + c, c + a, a + b], axis=1)
    return symmetric_matrix(faces, -weights, np.bincount(faces.ravel(), weights=row_sums.ravel(), minlength=n))


def stiffness_of_pairs(n: int, i: NDArray[np.int64], j: NDArray[np.int64], weights: NDArray[np.float64]) -> csc_array:
    """Build the stiffness of n vertices from one weight per unordered pair (i, j); pairs with i = j are ignored.

    Parameters
    ----------
    n : int
    i, j : (p,) array of int
    weights : (p,) array of float
    """
    weights = np.where(i == j, 0.0, weights)
    row_sums = np.bincount(i, weights, n) + np.bincount(j, weights, n)
    upper = coo_array((-weights, (i, j)), shape=(n, n)).tocsc()
    return (upper + upper.T + diagonal_matrix(row_sums)).tocsc()
