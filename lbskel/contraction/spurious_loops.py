"""Spurious loops: cycles of a graph that run around no tunnel of the surface, and the edges that open them."""

from __future__ import annotations

__all__ = ["spurious_loop_edges"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from lbskel.geometry.graphs import weighted_graph

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
    row_of_edge = {(int(low), int(high)): row for row, (low, high) in enumerate(edges)}
    potential = np.zeros((k, cochain.shape[1]), dtype=np.int64)
    in_tree = np.zeros(len(edges), dtype=bool)
    for node in order[1:]:
        up = int(parent[node])
        row = row_of_edge[min(up, int(node)), max(up, int(node))]
        in_tree[row] = True
        potential[node] = potential[up] + (cochain[row] if up < node else -cochain[row])
    loop_sums = cochain + potential[edges[:, 0]] - potential[edges[:, 1]]
    off_tree = np.flatnonzero(~in_tree)
    kept: list[NDArray[np.int64]] = []
    spurious = []
    for row in off_tree[np.argsort(-length[off_tree], kind="stable")]:
        if np.linalg.matrix_rank(np.array([*kept, loop_sums[row]])) > len(kept):
            kept.append(loop_sums[row])
        else:
            spurious.append(int(row))
    return spurious
