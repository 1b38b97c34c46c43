"""Stiffness matrices put together from weights of corners, or of pairs of vertices."""

from __future__ import annotations

__all__ = ["diagonal_matrix", "stiffness_of_corner_weights", "stiffness_of_pairs", "symmetric_matrix"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel._kernels.assembly import symmetric


def diagonal_matrix(values: NDArray[Any]) -> csc_array:
    """The matrix with these values on its diagonal."""
    n = len(values)
    return csc_array((np.asarray(values, dtype=np.float64), np.arange(n), np.arange(n + 1)), shape=(n, n))


def symmetric_matrix(faces: NDArray[np.int64], edge_entries: NDArray[np.float64], diagonal: NDArray[Any]) -> csc_array:
    """The matrix with ``edge_entries[f, k]`` added at both places of the edge opposite corner k of face f."""
    n = len(diagonal)
    entries = np.ascontiguousarray(edge_entries, dtype=np.float64)
    return csc_array(symmetric(faces, entries, np.asarray(diagonal, dtype=np.float64)), shape=(n, n))


def stiffness_of_corner_weights(n: int, faces: NDArray[np.int64], weights: NDArray[np.float64]) -> csc_array:
    """S of n vertices: ``weights[f, k]`` is added to the weight of the edge opposite corner k of face f."""
    ends = weights[:, [1, 2, 0]] + weights[:, [2, 0, 1]]
    return symmetric_matrix(faces, -weights, np.bincount(faces.ravel(), weights=ends.ravel(), minlength=n))


def stiffness_of_pairs(n: int, i: NDArray[np.int64], j: NDArray[np.int64], weights: NDArray[np.float64]) -> csc_array:
    """S of n vertices with a weight for each pair (i, j), named once; a vertex paired with itself has none."""
    weights = np.where(i == j, 0.0, weights)
    ends = np.bincount(i, weights, n) + np.bincount(j, weights, n)
    upper = coo_array((-weights, (i, j)), shape=(n, n)).tocsc()
    return (upper + upper.T + diagonal_matrix(ends)).tocsc()
