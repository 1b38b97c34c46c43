"""Weighted graphs for scipy.sparse.csgraph, which before scipy 1.17 accepts only 32-bit indices, and for kernels."""

from __future__ import annotations

__all__ = [
    "connected_labels",
    "edge_length_graph",
    "positive_edge_lengths",
    "shortest_edges",
    "shortest_paths",
    "weighted_graph",
]

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import unique_inverse

# Lengths of edges are multiples of this power of two, relative to that nearest to the diameter bound: sums of them are
# exact, so that no rounding error chooses between paths of equal length, as there are on a mesh of voxels. The step is
# that of ROUNDING in lbskel.preprocess.simplification, swept in benchmarks/results/voxels.md; by hand, of eight bodies
# of voxels at random all have one skeleton in two poses with it, and one has without
LENGTH_EXPONENT = -30
TINY = float(np.finfo(np.float64).tiny)


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


def connected_labels(edges: NDArray[np.int64], n_nodes: int) -> NDArray[np.int64]:
    """(n,) number of the connected component of each node.

    Parameters
    ----------
    edges : (e, 2) array of int
        In either direction.
    n_nodes : int
    """
    graph = weighted_graph(edges, np.ones(len(edges)), n_nodes)
    labels: NDArray[np.int64] = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels


def positive_edge_lengths(mesh: Mesh) -> NDArray[np.float64]:
    """(k,) length of each edge of a mesh, rounded to a multiple of one length, at least that: graphs drop length 0.

    Parameters
    ----------
    mesh : Mesh
    """
    exponent = round(math.log2(max(mesh.diameter_bound, TINY))) + LENGTH_EXPONENT
    step = max(math.ldexp(1.0, exponent), TINY)
    return np.asarray(np.maximum(np.rint(mesh.edge_lengths / step), 1.0) * step)


def edge_length_graph(mesh: Mesh) -> csr_array:
    """(n, n) symmetric adjacency matrix of the vertices of a mesh with :func:`positive_edge_lengths`.

    Parameters
    ----------
    mesh : Mesh
    """
    graph = weighted_graph(mesh.edges, positive_edge_lengths(mesh), len(mesh.vertices))
    return graph + graph.T


def shortest_edges(edges: NDArray[np.int64], lengths: NDArray[np.float64], n_nodes: int) -> csr_array:
    """(n, n) symmetric adjacency matrix with the least length of parallel edges; loops are left out.

    Parameters
    ----------
    edges : (e, 2) array of int
        In either direction.
    lengths : (e,) array of float
        Positive.
    n_nodes : int
    """
    pairs, pair_of_edge = unique_inverse(np.minimum(*edges.T) * n_nodes + np.maximum(*edges.T))
    least = np.full(len(pairs), np.inf)
    np.minimum.at(least, pair_of_edge, lengths)
    ends = np.stack([pairs // n_nodes, pairs % n_nodes], axis=1)
    is_pair = ends[:, 0] < ends[:, 1]
    graph = weighted_graph(ends[is_pair], least[is_pair], n_nodes)
    return graph + graph.T


def shortest_paths(graph: csr_array) -> ShortestPaths:
    """Prepare searches for shortest paths in a graph.

    Parameters
    ----------
    graph : (n, n) sparse array
        Lengths of the edges from the node of a row to that of a column; none is negative.
    """
    return ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)
