"""Joining the components of a skeleton to one graph by the shortest possible edges, which its report lists.

The added edges are those of the minimum spanning tree between the components (Kruskal 1956,
https://doi.org/10.1090/S0002-9939-1956-0078686-7). Candidates are the shortest edges to the largest component,
and those of the Delaunay tetrahedra of the other nodes, which contain their Euclidean minimum spanning tree (Shamos,
Hoey 1975, https://doi.org/10.1109/SFCS.1975.8).
"""

from __future__ import annotations

__all__ = [
    "join_components",
    "join_pieces",
    "joining_by_report",
    "with_present_joining_edges",
    "without_joining_edges",
]

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import Delaunay, cKDTree

from lbskel.errors import UnknownChoice, is_number
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.normals import normalized, row_dots, vector_lengths
from lbskel.geometry.sorting import is_among
from lbskel.skeleton.skeleton import Skeleton

# Upper bounds on an edge that joins pieces of one shape: its length, in sums of the radii of its ends, and its angle to
# the branch that it continues, in degrees; guesses
JOIN_REACH, JOIN_ANGLE = 10.0, 60.0
# Lower bound on the cosine between such an edge and the normal of a cut that it leaves. benchmarks/results/bounds.md:
# 0.1 to 0.7 are alike; with 0 twice as many edges between pieces of cropped trees are false
MIN_OUTWARDS = 0.2
N_NODES = 4  # nodes at the end of a branch that give its direction; a guess
N_NEAREST = 16  # nodes of the largest component that each other node may be joined to; a guess
# Number of nodes up to which all pairs are candidates; a guess. Above, an edge past nodes that are nearer, but may not
# be joined, is not found
MAX_NODES_ALL_PAIRS = 100


def join_components(
    skeleton: Skeleton,
    *,
    reach: float | None = None,
    max_angle: float | None = None,
    is_joinable: ArrayLike | None = None,
) -> Skeleton:
    """Add edges between nodes of different components until the skeleton is connected; cycles are kept.

    With a reach or an angle, components stay separate if the edge that is allowed between them is none of the shortest
    ones: each node is tried with 16 nodes of the largest component, and with its neighbors in the Delaunay tetrahedra
    of the others, or with all of these if they are at most 100.

    Parameters
    ----------
    skeleton : Skeleton
    reach : float, optional
        Upper bound on the length of an added edge, as a multiple of the sum of the radii of its nodes. Components
        farther apart stay separate. By default every component is joined.
    max_angle : float, optional
        Upper bound, in degrees, on the angle between an added edge and the direction of the branch whose tip it leaves,
        at one of its ends at least. Edges between balls that touch may have any direction.
    is_joinable : (c,) array_like of bool, optional
        Which components may be joined, in the order of ``component_of_node``; all by default.

    Returns
    -------
    Skeleton
        If there was something to join, its report counts the added edges in ``pieces_joined`` and lists their ends in
        ``joining_edges``; :func:`lbskel.score` and later edits leave these out.

    Raises
    ------
    UnknownChoice
        If the reach or the angle is not positive, or ``is_joinable`` has another length.

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
    if reach is not None and not (is_number(reach) and reach > 0):
        raise UnknownChoice(f"reach must be positive, a multiple of the radii, not {reach!r}")
    if max_angle is not None and not (is_number(max_angle) and max_angle > 0):
        raise UnknownChoice(f"max_angle must be positive, in degrees, not {max_angle!r}")
    return _joined(skeleton, is_joinable, partial(_may_be_joined, skeleton, reach=reach, max_angle=max_angle))


def join_pieces(
    skeleton: Skeleton, is_joinable: NDArray[np.bool_], outwards: NDArray[np.float64] | None = None
) -> Skeleton:
    """Join components that may be pieces of one shape, by edges within JOIN_REACH and JOIN_ANGLE.

    Parameters
    ----------
    skeleton : Skeleton
    is_joinable : (c,) array of bool
        As for :func:`join_components`.
    outwards : (k, 3) array of float, optional
        Unit normal, out of the shape, of the cut that each node is at the center of; zero for other nodes. An edge
        leaves a cut outwards: those in one side of a cropped box do not face each other. Between two blocks of a volume
        it may have no length; one within the larger radius of its nodes may have any direction.
    """

    def is_allowed(i: NDArray[np.int64], j: NDArray[np.int64]) -> NDArray[np.bool_]:
        allowed = _may_be_joined(skeleton, i, j, reach=JOIN_REACH, max_angle=JOIN_ANGLE)
        if outwards is not None:
            ways = skeleton.nodes[j] - skeleton.nodes[i]
            is_short = vector_lengths(ways) <= np.maximum(skeleton.radii[i], skeleton.radii[j])
            for node, sign in ((i, 1), (j, -1)):
                cosines = sign * row_dots(normalized(ways), outwards[node])
                allowed &= is_short | (cosines >= MIN_OUTWARDS) | ~outwards[node].any(axis=1)
        return allowed

    return _joined(skeleton, is_joinable, is_allowed)


def _may_be_joined(
    skeleton: Skeleton, i: NDArray[np.int64], j: NDArray[np.int64], *, reach: float | None, max_angle: float | None
) -> NDArray[np.bool_]:
    """(p,) whether edges between nodes are within a reach, and an angle to the branch of one of them."""
    lengths, radii = vector_lengths(skeleton.nodes[i] - skeleton.nodes[j]), skeleton.radii[i] + skeleton.radii[j]
    allowed = np.full(len(i), True) if reach is None else lengths <= reach * radii
    if max_angle is not None:
        is_ahead = _continues_branch(skeleton, i, j, max_angle) | _continues_branch(skeleton, j, i, max_angle)
        allowed &= is_ahead | (lengths <= radii)
    return allowed


def _joined(
    skeleton: Skeleton,
    is_joinable: ArrayLike | None,
    is_allowed: Callable[[NDArray[np.int64], NDArray[np.int64]], NDArray[np.bool_]],
) -> Skeleton:
    """Add the shortest edges that are allowed between components."""
    component, n = skeleton.component_of_node, skeleton.n_components
    if n <= 1:
        return skeleton
    i, j = _candidate_pairs(skeleton.nodes, component).T
    is_used = component[i] != component[j]
    if is_joinable is not None:
        may_join = np.asarray(is_joinable, dtype=bool)
        if may_join.shape != (n,):
            raise UnknownChoice(f"is_joinable needs a value for each of {n} components, not shape {may_join.shape}")
        is_used &= may_join[component[i]] & may_join[component[j]]
    is_used &= is_allowed(i, j)
    i, j = i[is_used], j[is_used]
    order = np.lexsort((j, i, vector_lengths(skeleton.nodes[i] - skeleton.nodes[j])))
    joined = np.sort(np.stack([component[i], component[j]], axis=1)[order], axis=1)
    key, first = np.unique(joined @ [n, 1], return_index=True)  # the shortest edge between each pair of components
    # ranks replace lengths as weights, since csgraph takes a weight of zero for a missing edge
    tree = minimum_spanning_tree(weighted_graph(joined[first], first + 1.0, n)).tocoo()
    chosen = order[first[np.searchsorted(key, tree.row.astype(np.int64) * n + tree.col)]]
    added = np.stack([i[chosen], j[chosen]], axis=1)
    report = dict(skeleton.report)
    report["pieces_joined"] = report.get("pieces_joined", 0) + len(added)
    report["joining_edges"] = [*report.get("joining_edges", []), *skeleton.nodes[added].tolist()]
    return replace(skeleton, edges=np.concatenate([skeleton.edges, added]), report=report)


def joining_by_report(skeleton: Skeleton) -> NDArray[np.bool_] | None:
    """(e,) whether each edge was added to join bodies according to the report; None if it does not tell, or not all.

    Parameters
    ----------
    skeleton : Skeleton
    """
    added = np.reshape(skeleton.report.get("joining_edges", []), (-1, 2, 3))
    if len(added) != skeleton.report.get("pieces_joined"):
        return None
    are_edges, is_added = _edges_at(skeleton, added)
    return is_added if are_edges.all() else None


def _edges_at(skeleton: Skeleton, ends: NDArray[np.float64]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(p,) whether there is an edge between each of (p, 2, 3) pairs of places, and (e,) which edges these are."""
    if len(ends) == 0:
        return np.zeros(0, dtype=bool), np.zeros(len(skeleton.edges), dtype=bool)
    tree, numbers = cKDTree(skeleton.nodes), np.array([len(skeleton.nodes), 1])
    place = tree.query(skeleton.nodes)[1]  # one number for all nodes at a place: an edge may have no length
    distances, nearest = tree.query(ends)
    of_pairs, of_edges = (np.sort(each, axis=1) @ numbers for each in (nearest, place[skeleton.edges]))
    are_edges = (distances == 0).all(axis=1) & is_among(of_pairs, of_edges)
    return are_edges, is_among(of_edges, of_pairs[are_edges])


def with_present_joining_edges(before: Skeleton, after: Skeleton) -> Skeleton:
    """Leave out of the report of an edited skeleton the edges between bodies that the edit has removed.

    Parameters
    ----------
    before, after : Skeleton
        ``after`` has some of the nodes of ``before``, where they were.
    """
    is_joining = joining_by_report(before)
    if is_joining is None or not is_joining.any():
        return after
    ends = np.array(before.report["joining_edges"])
    present = ends[_edges_at(after, ends)[0]].tolist()
    return replace(after, report=after.report | {"pieces_joined": len(present), "joining_edges": present})


def without_joining_edges(edit: Callable[[Skeleton], Skeleton], skeleton: Skeleton) -> Skeleton:
    """Edit the branches of a skeleton, but neither its first node nor the edges that joined its bodies.

    The first node is the root of a tree, and may be within a branch, as the soma of a bipolar neuron is. What joins
    bodies lies outside of these.

    Parameters
    ----------
    edit : callable
        From a skeleton to one with the same anchors in the same order.
    skeleton : Skeleton
        Its report tells which edges joined bodies; where it does not, all edges are edited.
    """
    is_joining = joining_by_report(skeleton)
    if is_joining is None:
        is_joining = np.zeros(len(skeleton.edges), dtype=bool)
    if len(skeleton.nodes) == 0 or not (is_joining.any() or skeleton.degrees[0] == 2):
        return edit(skeleton)
    ends = skeleton.edges[is_joining]
    anchors = np.union1d(np.append(skeleton.anchors, 0), ends)
    held = replace(skeleton, edges=skeleton.edges[~is_joining], anchors=anchors)
    edited = edit(held)
    number = np.zeros(len(skeleton.nodes), dtype=np.int64)
    number[held.anchors] = edited.anchors
    return replace(edited, edges=np.concatenate([edited.edges, number[ends]]), anchors=number[skeleton.anchors])


def _continues_branch(
    skeleton: Skeleton, start: NDArray[np.int64], end: NDArray[np.int64], max_angle: float
) -> NDArray[np.bool_]:
    """(p,) whether edges from start to end leave a tip within ``max_angle`` degrees of the direction of its branch."""
    direction = np.zeros_like(skeleton.nodes)
    for branch in skeleton.branches:
        for ordered in (branch, branch[::-1]):
            if skeleton.degrees[ordered[-1]] == 1:
                direction[ordered[-1]] = skeleton.nodes[ordered[-1]] - skeleton.nodes[ordered[-N_NODES:][0]]
    across = skeleton.nodes[end] - skeleton.nodes[start]
    cosine = np.einsum("pi,pi->p", across, direction[start])
    lengths = vector_lengths(across) * vector_lengths(direction[start])
    continues: NDArray[np.bool_] = (cosine >= np.cos(np.radians(max_angle)) * lengths) & (lengths > 0)
    return continues


def _candidate_pairs(nodes: NDArray[np.float64], component: NDArray[np.int64]) -> NDArray[np.int64]:
    """(p, 2) pairs of nodes that contain the shortest edges between components.

    These are the edges from each node outside of the largest component to the nodes of that component nearest to it,
    several since the shortest may not be allowed, and those of the Delaunay tetrahedra of the nodes outside.
    """
    is_outside = component != np.bincount(component).argmax()
    inside, outside = np.flatnonzero(~is_outside), np.flatnonzero(is_outside)
    k = min(N_NEAREST, len(inside))
    nearest = cKDTree(nodes[inside]).query(nodes[outside], k=[*range(1, k + 1)])[1]
    to_largest = np.stack([inside[nearest.ravel()], np.repeat(outside, k)], axis=1)
    return np.concatenate([to_largest, outside[_close_pairs(nodes[outside])]]).astype(np.int64)


def _close_pairs(nodes: NDArray[np.float64]) -> NDArray[np.int64]:
    """(p, 2) pairs of nodes that contain the edges of their Euclidean minimum spanning tree."""
    if len(nodes) <= MAX_NODES_ALL_PAIRS:
        return np.stack(np.triu_indices(len(nodes), 1), axis=1).astype(np.int64)
    unit = (nodes - nodes.mean(axis=0)) / (np.abs(nodes - nodes.mean(axis=0)).max() or 1.0)
    tetrahedra = Delaunay(unit, qhull_options="QJ").simplices  # joggled, since nodes may be coplanar or collinear
    pairs = np.sort(np.concatenate([tetrahedra[:, [a, b]] for a in range(4) for b in range(a + 1, 4)]), axis=1)
    keys = np.unique(pairs.astype(np.int64) @ [len(nodes), 1])
    return np.stack([keys // len(nodes), keys % len(nodes)], axis=1)
