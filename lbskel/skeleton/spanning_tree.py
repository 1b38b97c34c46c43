"""The skeleton as a tree: every cycle is cut where the shape is thinnest along it.

The edges that stay are those of a maximum spanning tree (Kruskal 1956,
https://doi.org/10.1090/S0002-9939-1956-0078686-7) with the radius of an edge as its weight, the smaller radius of its
two nodes. Every other edge is the thinnest of the cycle that it closes; of equally thin edges the longest is cut.
"""

from __future__ import annotations

__all__ = ["cycle_edges", "to_tree"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree

from lbskel.geometry.graphs import weighted_graph
from lbskel.skeleton.short_loops import with_opened_loops
from lbskel.skeleton.skeleton import Skeleton


def to_tree(skeleton: Skeleton) -> Skeleton:
    """Cut every cycle at its thinnest edge; nodes, radii and the vertex map stay as they are.

    Parameters
    ----------
    skeleton : Skeleton
        Of one component or several; each becomes a tree.

    Returns
    -------
    Skeleton
        If a cycle was cut, its report counts them in ``cycles_cut``; :func:`lbskel.score` does not count these as
        missing.

    Examples
    --------
    >>> from lbskel import Skeleton, to_tree
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> ring = Skeleton(square, [[0, 1], [1, 2], [2, 3], [0, 3]], [3.0, 3.0, 1.0, 2.0])
    >>> to_tree(ring).edges.tolist()  # of the two edges at the thinnest node the last, since both are equally long
    [[0, 1], [0, 3], [1, 2]]
    """
    tree = replace(skeleton, edges=skeleton.edges[~cycle_edges(skeleton)])
    return with_opened_loops(skeleton, tree, "cycles_cut")


def cycle_edges(skeleton: Skeleton) -> NDArray[np.bool_]:
    """(e,) whether :func:`to_tree` removes each edge; as many are removed as there are independent cycles.

    The thinnest edge of a cycle is removed: the one with the smallest radius at either of its nodes, of several the
    longest, then the last. An unknown radius counts as larger than all known ones.

    Parameters
    ----------
    skeleton : Skeleton
    """
    k, n_edges = len(skeleton.nodes), len(skeleton.edges)
    known = np.where(np.isnan(skeleton.radii), np.inf, skeleton.radii)
    radius = known[skeleton.edges].min(axis=1)
    # ranks replace radii as weights: they are positive and all different, so that the tree is unique
    rank = np.empty(n_edges, dtype=np.int64)
    rank[np.lexsort((skeleton.edge_lengths, -radius))] = np.arange(1, n_edges + 1)
    return ~np.isin(rank, minimum_spanning_tree(weighted_graph(skeleton.edges, rank, k)).data)
