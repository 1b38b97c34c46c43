"""Weighted graphs for scipy.sparse.csgraph, which before scipy 1.17 accepts only 32-bit indices."""

from __future__ import annotations

__all__ = ["weighted_graph"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array


def weighted_graph(edges: NDArray[np.int64], weights: NDArray[Any], n_nodes: int) -> csr_array:
    """(n, n) adjacency matrix with 32-bit indices; weights of repeated edges are summed.

    Parameters
    ----------
    edges : (e, 2) array of int
        Each gives one entry, from its first node to its second.
    weights : (e,) array
        Zero means no edge.
    n_nodes : int
    """
    rows, columns = edges.T.astype(np.int32)
    return coo_array((weights, (rows, columns)), shape=(n_nodes, n_nodes)).tocsr()
