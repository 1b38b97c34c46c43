"""The order of a skeleton's branches as a rooted tree: parent, centrifugal and Strahler order, angles of children.

Strahler 1957, "Quantitative analysis of watershed geomorphology", https://doi.org/10.1029/TR038i006p00913: a branch
without children has order 1; any other has the largest order of its children, plus one if two of them have it.

The centrifugal order of a branch is the number of its ancestors: 0 for the branches that begin at the root or have it
inside, 1 for their children, and so on, as in NeuroM and L-Measure; other programs begin at 1.

The root is the first node, and in each further component its thickest tip. The parent of a branch is the branch by
which the shortest path from the root along the graph reaches its nearer end. So a branch that closes a cycle has a
parent but no children.
"""

from __future__ import annotations

__all__ = ["BranchOrder", "branch_order"]

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from lbskel.geometry.arrays import read_only
from lbskel.geometry.graphs import weighted_graph
from lbskel.skeleton.root import find_roots
from lbskel.skeleton.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class BranchOrder:
    """The branches of a skeleton from the root outwards.

    Parameters
    ----------
    paths : tuple of arrays of int
        The nodes of each branch, the end nearer to the root first.
    parents : (b,) array of int
        Row of the parent of each branch; -1 where a branch begins at the root or has the root inside.
    centrifugal : (b,) array of int
        Centrifugal order.
    strahler : (b,) array of int
        Strahler order.
    local_angles, remote_angles : (b,) array of float
        Angles in degrees between the two children at the end of a branch: between their first edges, and between the
        lines to their ends. NaN for a branch that does not have two children there.
    """

    paths: tuple[NDArray[np.int64], ...]
    parents: NDArray[np.int64]
    centrifugal: NDArray[np.int64]
    strahler: NDArray[np.int64]
    local_angles: NDArray[np.float64]
    remote_angles: NDArray[np.float64]


def branch_order(skeleton: Skeleton, *, roots: NDArray[np.int64] | None = None) -> BranchOrder:
    """Direct the branches of a skeleton away from its root, and order them.

    Parameters
    ----------
    skeleton : Skeleton
    roots : (c,) array of int, optional
        One node for each component, in place of the first node and the thickest tips.
    """
    distance, previous = _from_roots(skeleton, _default_roots(skeleton) if roots is None else roots)
    paths = tuple(path if distance[path[0]] <= distance[path[-1]] else path[::-1] for path in skeleton.branches)
    branch_of_step = {
        step: row for row, path in enumerate(paths) for way in (path, path[::-1]) for step in pairwise(way.tolist())
    }
    parents = np.full(len(paths), -1)
    for row, path in enumerate(paths):
        near = int(path[0])
        holds_root = bool((previous[path[1:-1]] < 0).any())
        if previous[near] >= 0 and not holds_root:
            parents[row] = branch_of_step[int(previous[near]), near]
    children: list[list[int]] = [[] for _ in paths]
    for row, parent in enumerate(parents.tolist()):
        if parent >= 0:
            children[parent].append(row)
    # a branch with the root inside has children at both ends
    at_end = [
        [paths[row] for row in own if paths[row][0] == path[-1]] for own, path in zip(children, paths, strict=True)
    ]
    angles = np.array([_angles(skeleton.nodes, own) for own in at_end]).reshape(-1, 2)
    orders = read_only(parents), _centrifugal(parents, children), _strahler(parents, children)
    return BranchOrder(paths, *orders, *(read_only(each) for each in angles.T.copy()))


def _default_roots(skeleton: Skeleton) -> NDArray[np.int64]:
    """(c,) the first node, and the thickest tip of each further component."""
    if not len(skeleton.nodes):
        return np.empty(0, dtype=np.int64)
    roots = find_roots(skeleton)
    roots[skeleton.component_of_node[roots] == skeleton.component_of_node[0]] = 0
    return roots


def _from_roots(skeleton: Skeleton, roots: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(k,) distance of each node from the root of its component along the graph, and (k,) the node before it, or -1."""
    k = len(skeleton.nodes)
    if k == 0:
        return np.empty(0), np.empty(0, dtype=np.int64)
    size = float(np.abs(skeleton.nodes).max())
    shift = np.finfo(np.float64).tiny + np.finfo(np.float64).eps * size  # csgraph takes a length of 0 for no edge
    graph = weighted_graph(skeleton.edges, skeleton.edge_lengths + shift, k)
    distance, previous, _ = dijkstra(graph, directed=False, indices=roots, min_only=True, return_predecessors=True)
    return distance, np.where(previous < 0, -1, previous)


def _centrifugal(parents: NDArray[np.int64], children: list[list[int]]) -> NDArray[np.int64]:
    """(b,) number of ancestors of each branch, from the root outwards."""
    orders = np.zeros(len(parents), dtype=np.int64)
    waiting = np.flatnonzero(parents < 0).tolist()
    while waiting:
        row = waiting.pop()
        orders[children[row]] = orders[row] + 1
        waiting.extend(children[row])
    return read_only(orders)


def _strahler(parents: NDArray[np.int64], children: list[list[int]]) -> NDArray[np.int64]:
    """(b,) Strahler orders, from the branches without children to the root."""
    orders = np.zeros(len(parents), dtype=np.int64)
    waiting = np.array([len(own) for own in children])
    ready = np.flatnonzero(waiting == 0).tolist()
    while ready:
        row = ready.pop()
        below = orders[children[row]]
        largest = below.max(initial=0)
        orders[row] = max(1, largest + (np.count_nonzero(below == largest) > 1))
        parent = int(parents[row])
        if parent >= 0:
            waiting[parent] -= 1
            if waiting[parent] == 0:
                ready.append(parent)
    return read_only(orders)


def _angles(nodes: NDArray[np.float64], children: list[NDArray[np.int64]]) -> tuple[float, float]:
    """Angle of the first edges, and of the chords, of two branches from one node; NaN if there are not two."""
    if len(children) != 2:
        return np.nan, np.nan
    first, last = (np.array([nodes[path[end]] - nodes[path[0]] for path in children]) for end in (1, -1))
    return _angle(*first), _angle(*last)


def _angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Angle between two vectors, in degrees; NaN if one of them is zero."""
    if not (a.any() and b.any()):
        return np.nan
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
