"""Spurious loops: cycles of a graph that run around no tunnel of the surface, and the edges that open them."""

from __future__ import annotations

__all__ = ["PRIME", "null_loop_edges", "spurious_loop_edges"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from lbskel._kernels.linking import sums_from_root
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.graphs import weighted_graph

# Independence is tested modulo this prime, below 2^20: sums of up to 8,192 products of two numbers are exact in double
# precision
PRIME = 1_048_573
TREE_LENGTH_SHIFT = 1e-12  # added to lengths, in diameter bounds: zero would mean no edge in a sparse matrix


def spurious_loop_edges(
    P: NDArray[np.float64], edges: NDArray[np.int64], cochain: NDArray[np.int64], *, deadline: Deadline = NEVER
) -> list[int]:
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
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    list of int
        Rows of ``edges``.
    """
    off_tree, length, sums = _loop_sums(P, edges, cochain)
    longest_first = np.argsort(-length[off_tree], kind="stable")
    is_kept = _independent_rows(sums[longest_first] % PRIME, deadline)
    return [int(row) for row in off_tree[longest_first[~is_kept]]]


def null_loop_edges(P: NDArray[np.float64], edges: NDArray[np.int64], cochain: NDArray[np.int64]) -> list[int]:
    """Find the edges outside a minimum spanning tree that close a loop whose sum is zero.

    Parameters
    ----------
    P, edges, cochain
        As for :func:`spurious_loop_edges`; one column is enough if it tells loops around tunnels from others.

    Returns
    -------
    list of int
        Rows of ``edges``; there may be further ones whose loops are sums of others.
    """
    off_tree, _, sums = _loop_sums(P, edges, cochain)
    return [int(row) for row in off_tree[~sums.any(axis=1)]]


def _loop_sums(
    P: NDArray[np.float64], edges: NDArray[np.int64], cochain: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Find the edges outside a minimum spanning tree, the lengths of all, and the sum of the loop that each closes."""
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
    return off_tree, length, loop_sums[off_tree]


def _independent_rows(rows: NDArray[np.int64], deadline: Deadline) -> NDArray[np.bool_]:
    """(r,) whether each row is independent of those before it, modulo the prime: Gauss and Jordan's elimination."""
    r, c = rows.shape
    is_independent = np.zeros(r, dtype=bool)
    rows = rows.astype(np.float64)
    reduced, pivots = np.zeros((min(r, c), c)), np.empty(0, dtype=np.int64)
    for i in range(r):
        deadline.check()
        n = len(pivots)
        row = np.mod(rows[i] - np.mod(rows[i][pivots] @ reduced[:n], PRIME), PRIME)
        if not row.any():
            continue
        pivot = int(np.flatnonzero(row)[0])
        row = np.mod(row * pow(int(row[pivot]), -1, PRIME), PRIME)
        reduced[:n] = np.mod(reduced[:n] - reduced[:n, [pivot]] * row, PRIME)
        reduced[n], pivots, is_independent[i] = row, np.append(pivots, pivot), True
    return is_independent
