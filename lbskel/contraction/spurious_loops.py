"""Spurious loops: cycles of a graph that run around no tunnel of the surface, and the edges that open them."""

from __future__ import annotations

__all__ = ["PRIME", "null_loop_edges", "spurious_loop_edges"]

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from lbskel._kernels.linking import sums_from_root
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.normals import vector_lengths

# Independence is tested modulo this prime, below 2^20. Sums of this many products of two remainders are then below
# 2^52, so that they and their quotients by the prime are exact enough in double precision
PRIME, MAX_TERMS = 1_048_573, 4_096
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
        Value of each edge from its lower to its higher end.
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
    length = vector_lengths(P[edges[:, 0]] - P[edges[:, 1]])
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
    steps = np.zeros((k, cochain.shape[1]), dtype=np.int64)
    steps[below] = np.where(parent[below] < below, 1, -1)[:, None] * cochain[rows]
    columns = np.ascontiguousarray(steps.T).view(np.uint64)
    off_tree = np.flatnonzero(~in_tree)
    from_ends, to_ends = edges[off_tree].T
    sums = np.array(cochain[off_tree])
    for i, column in enumerate(columns):
        potential = sums_from_root(order, parent, column).view(np.int64)
        sums[:, i] += potential[from_ends] - potential[to_ends]
    return off_tree, length, sums


def _independent_rows(rows: NDArray[np.int64], deadline: Deadline) -> NDArray[np.bool_]:
    """(r,) whether each row is independent of those before it, modulo the prime: Gauss and Jordan's elimination.

    Rows are taken in blocks, so that most of the work is products of matrices.
    """
    (r, c), size = rows.shape, math.isqrt(len(rows)) + 1
    is_independent = np.zeros(r, dtype=bool)
    reduced, pivots = np.zeros((min(r, c), c)), np.empty(0, dtype=np.int64)
    for first in range(0, r, size):
        deadline.check()
        block = rows[first : first + size].astype(np.float64)
        block = _modulo(block - _product(block[:, pivots], reduced[: len(pivots)]))
        found, columns = _reduce(block)
        is_independent[first + found] = True
        n = len(pivots)
        reduced[:n] = _modulo(reduced[:n] - _product(reduced[:n, columns], block[found]))
        reduced[n : n + len(found)] = block[found]
        pivots = np.append(pivots, columns)
    return is_independent


def _reduce(block: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Reduce a block in place: its rows that are independent of those before them, and the columns of their pivots."""
    found, columns = [], []
    for i, row in enumerate(block):
        if not row.any():
            continue
        pivot = int(row.argmax())
        row[:] = _modulo(row * pow(int(row[pivot]), -1, PRIME))
        others = np.flatnonzero(block[:, pivot])
        others = others[others != i]
        block[others] = _modulo(block[others] - block[others, pivot, None] * row)
        found.append(i)
        columns.append(pivot)
    return np.array(found, dtype=np.int64), np.array(columns, dtype=np.int64)


def _product(A: NDArray[np.float64], B: NDArray[np.float64]) -> NDArray[np.float64]:
    """Multiply matrices modulo the prime, of MAX_TERMS columns and rows at a time."""
    total = np.zeros((len(A), B.shape[1]))
    for first in range(0, A.shape[1], MAX_TERMS):
        total = _modulo(total + _modulo(A[:, first : first + MAX_TERMS] @ B[first : first + MAX_TERMS]))
    return total


def _modulo(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Remainders modulo the prime of whole numbers below 2^52; their quotients are off by less than its inverse."""
    remainders: NDArray[np.float64] = numbers - PRIME * np.floor(numbers / PRIME)
    return remainders
