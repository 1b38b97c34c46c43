"""Graphs of several components joined to one where the caller wants that: by edges as few and as short as may be.

The edges are those of the shortest tree between the components, Kruskal 1956,
https://doi.org/10.1090/S0002-9939-1956-0078686-7, among the edges of the Delaunay tetrahedra of the nodes, which hold
the shortest tree of points (Shamos, Hoey 1975, https://doi.org/10.1109/SFCS.1975.8).
"""

from __future__ import annotations

__all__ = ["join_components"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import Delaunay

from lbskel.errors import UnknownChoice
from lbskel.geometry.graphs import weighted_graph
from lbskel.skeleton.skeleton import Skeleton

FEW = 100  # nodes, of which every pair is looked at


def join_components(skeleton: Skeleton, *, reach: float | None = None) -> Skeleton:
    """The skeleton with edges between nodes of different components until it is one graph; cycles stay what they are.

    Parameters
    ----------
    skeleton : Skeleton
    reach : float, optional
        The longest such edge, as a multiple of the sum of its nodes' radii; components further apart stay apart.

    Raises
    ------
    UnknownChoice
        If the reach is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from lbskel import Skeleton, join_components
    >>> apart = Skeleton(np.array([[0, 0, 0], [1, 0, 0], [3, 0, 0], [4, 0, 0]]), np.array([[0, 1], [2, 3]]), np.ones(4))
    >>> join_components(apart).edges.tolist()
    [[0, 1], [1, 2], [2, 3]]
    >>> join_components(apart, reach=0.5).n_components
    2
    """
    if reach is not None and not reach > 0:
        raise UnknownChoice(f"reach must be positive, not {reach}")
    label, n = skeleton.component_of_node, skeleton.n_components
    if n == 1:
        return skeleton
    i, j = _near_pairs(skeleton.nodes).T
    far = np.linalg.norm(skeleton.nodes[i] - skeleton.nodes[j], axis=1)
    may_be = label[i] != label[j]
    if reach is not None:
        may_be &= far <= reach * (skeleton.radii[i] + skeleton.radii[j])
    i, j, far = i[may_be], j[may_be], far[may_be]
    order = np.lexsort((j, i, far))
    ends = np.sort(np.stack([label[i], label[j]], axis=1)[order], axis=1)
    key, first = np.unique(ends @ [n, 1], return_index=True)  # the shortest edge of each two components
    # ranks in place of lengths: none is zero, which would mean no edge
    tree = minimum_spanning_tree(weighted_graph(ends[first], first + 1.0, n)).tocoo()
    chosen = order[first[np.searchsorted(key, tree.row.astype(np.int64) * n + tree.col)]]
    return replace(skeleton, edges=np.concatenate([skeleton.edges, np.stack([i[chosen], j[chosen]], axis=1)]))


def _near_pairs(nodes: NDArray[np.float64]) -> NDArray[np.int64]:
    """(p, 2) pairs of nodes among which are those of the shortest tree that spans them."""
    if len(nodes) <= FEW:
        return np.stack(np.triu_indices(len(nodes), 1), axis=1)
    unit = (nodes - nodes.mean(axis=0)) / (np.abs(nodes - nodes.mean(axis=0)).max() or 1.0)
    corners = Delaunay(unit, qhull_options="QJ").simplices  # joggled, for nodes in a plane or on a line
    pairs = np.concatenate([corners[:, [a, b]] for a in range(4) for b in range(a + 1, 4)])
    return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int64)
