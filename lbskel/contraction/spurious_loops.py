"""Spurious loops: cycles of a graph that run around no tunnel of the surface, and the edges that open them."""

from __future__ import annotations

__all__ = ["PRIME", "spurious_loop_edges"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from lbskel._kernels.linking import sums_from_root
from lbskel.geometry.graphs import weighted_graph

# Independence is tested modulo this prime, below 2^20: sums of up to 8,192 products of two numbers are exact in double
# precision
PRIME = 1_048_573
TREE_LENGTH_SHIFT = 1e-12  # added to lengths, in diameter bounds: zero would mean no edge in a sparse matrix


def spurious_loop_edges(P: NDArray[np.float64], edges: NDArray[np.int64], cochain: NDArray[np.int64]) -> list[int]:
    """Find edges to remove so that there are as many independent loops as independent tunnels.

    Each edge outside a minimum spanning tree closes one loop, which has a sum of the cochain. Loops are kept while
    their sums are linearly independent; those of longer edges come first, since a loop around no tunnel is small.

    Parameters
    ----------
    P : (k, 3) array of float
        Positions of the nodes, in diameter bounds.
    edges : (e, 2) array of int
        With ascending ends, each once; the graph is connected.
    cochain : (e, g) array of int
        Of each edge from its lower to its higher end.

    Returns
    -------
    list of int
        Rows of ``edges``.
    """
    k = len(P)
    length = np.linalg.norm(P[edges[:, 0]] - P[edges[:, 1]], axis=1)
    tree = minimum_spanning_tree(weighted_graph(edges, length + TREE_LENGTH_SHIFT, k))
    order, parent = breadth_first_order(tree, 0, directed=False)
    order, parent = order.astype(np.int64), parent.astype(np.int64)
    below = order[1:]
    keys = edges[:, 0] * k + edges[:, 1]
    by_key = np.argsort(keys)
    low, high = np.minimum(below, parent[below]), np.maximum(below, parent[below])
    rows = by_key[np.searchsorted(keys, low * k + high, sorter=by_key)]
    in_tree = np.zeros(len(edges), dtype=bool)
    in_tree[rows] = True
    steps = np.zeros((cochain.shape[1], k), dtype=np.int64)
    steps[:, below] = (np.where(parent[below] < below, 1, -1)[:, None] * cochain[rows]).T
    potentials = [sums_from_root(order, parent, step.view(np.uint64)).view(np.int64) for step in steps]
    potential = np.stack(potentials, axis=1)
    loop_sums = cochain + potential[edges[:, 0]] - potential[edges[:, 1]]
    off_tree = np.flatnonzero(~in_tree)
    longest_first = off_tree[np.argsort(-length[off_tree], kind="stable")]
    is_kept = _independent_rows(loop_sums[longest_first] % PRIME)
    return [int(row) for row in longest_first[~is_kept]]


def _independent_rows(rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(r,) whether each row is independent of those before it, modulo the prime: Gauss and Jordan's elimination."""
    r, c = rows.shape
    is_independent = np.zeros(r, dtype=bool)
    rows = rows.astype(np.float64)
    reduced, pivots = np.zeros((min(r, c), c)), np.empty(0, dtype=np.int64)
    for i in range(r):
        n = len(pivots)
        row = np.mod(rows[i] - np.mod(rows[i][pivots] @ reduced[:n], PRIME), PRIME)
        if not row.any():
            continue
        pivot = int(np.flatnonzero(row)[0])
        row = np.mod(row * pow(int(row[pivot]), -1, PRIME), PRIME)
        reduced[:n] = np.mod(reduced[:n] - reduced[:n, [pivot]] * row, PRIME)
        reduced[n], pivots, is_independent[i] = row, np.append(pivots, pivot), True
    return is_independent
