"""Skeletons whose tubes make one surface, from tracings of neurons, whose radii and branches do not.

Tracings (SWC) have radii of zero, radii that jump, nodes much closer than their radii, twigs inside thicker neurites,
and neurites that touch. :func:`tubular` says what is changed; the result is the truth for its own surface.
"""

from __future__ import annotations

__all__ = ["tubular"]

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.geometry.graphs import weighted_graph
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

# Least radius, relative to the median; a guess.
MIN_RADIUS = 0.25
# Least and largest distance of neighboring nodes of a branch, in radii; guesses.
MIN_SPACING, MAX_SPACING = 1.0, 1.5
# Largest change of the radius, relative to the distance of two nodes; a cone of slope 1 is a plane.
MAX_SLOPE = 0.7
# Least distance of two axes in sums of their radii, where the path between them is longer than MIN_PATH such sums. At
# 1.5 a gap of half the sum is left, and blended tubes do not close it. Guesses.
CLEARANCE, MIN_PATH = 1.5, 5.0
# Most times that radii are adapted to each other and branches removed; a guess.
MAX_ROUNDS = 20


def tubular(skeleton: Skeleton) -> Skeleton:
    """Change radii and remove what tubes of these radii would hide, so that the tubes make one surface.

    Radii that are not known, or below a quarter of the median, are raised to that quarter. Of two nodes of a branch
    within one radius, the thinner one is dropped; long edges are divided. Radii are lowered until none is larger than
    that of a neighbor plus 0.7 times their distance, and until two axes that do not meet nearby are at least 1.5 times
    the sum of their radii apart. If that takes less than the least radius, the end branch there is removed, the shorter
    one of two. End branches are removed whose ball at the tip stays within 1.5 radii of their junction.

    Parameters
    ----------
    skeleton : Skeleton

    Raises
    ------
    MeshError
        If no radius is known and positive.
    """
    known = skeleton.radii[np.isfinite(skeleton.radii) & (skeleton.radii > 0)]
    if not len(known):
        raise MeshError("no radius of the skeleton is known and positive: give it radii")
    floor = MIN_RADIUS * float(np.median(known))
    raised = np.maximum(np.nan_to_num(skeleton.radii, nan=0.0), floor)
    current = _even(Skeleton(skeleton.nodes, skeleton.edges, raised))
    for _ in range(MAX_ROUNDS):
        radii, hidden = _kept_apart(current, _with_bounded_slope(current, current.radii), floor)
        radii = _with_bounded_slope(current, radii)
        if not hidden.any() and np.array_equal(radii, current.radii):
            break
        current = _without_nodes(Skeleton(current.nodes, current.edges, radii), hidden)
    return current


def _even(skeleton: Skeleton) -> Skeleton:
    """Drop the thinner one of two nodes that are too near on a branch, and divide long edges."""
    nodes, radii = list(skeleton.nodes), list(skeleton.radii)
    edges: list[tuple[int, int]] = []
    for branch in skeleton.branches:
        kept = [int(branch[0])]
        for node in branch[1:].tolist():
            is_last = node == branch[-1]
            while len(kept) > 1 and _is_crowded(skeleton, node, kept[-1]):
                if not is_last and skeleton.radii[node] <= skeleton.radii[kept[-1]]:
                    break
                kept.pop()
            if is_last or not _is_crowded(skeleton, node, kept[-1]):
                kept.append(node)
        for i, j in pairwise(kept):
            length = np.linalg.norm(skeleton.nodes[j] - skeleton.nodes[i])
            n = int(np.ceil(length / (MAX_SPACING * min(skeleton.radii[i], skeleton.radii[j]))))
            chain = [i, *range(len(nodes), len(nodes) + n - 1), j]
            for share in np.arange(1, n) / n:
                nodes.append((1 - share) * skeleton.nodes[i] + share * skeleton.nodes[j])
                radii.append((1 - share) * skeleton.radii[i] + share * skeleton.radii[j])
            edges += pairwise(chain)
    evened = Skeleton(np.array(nodes), np.array(edges), np.array(radii))
    return _without_nodes(evened, evened.degrees == 0)


def _is_crowded(skeleton: Skeleton, i: int, j: int) -> bool:
    """Return whether one of two nodes lies inside the ball around the other."""
    distance = np.linalg.norm(skeleton.nodes[i] - skeleton.nodes[j])
    return bool(distance < MIN_SPACING * max(skeleton.radii[i], skeleton.radii[j]))


def _without_nodes(skeleton: Skeleton, removed: NDArray[np.bool_]) -> Skeleton:
    """Remove nodes and their edges."""
    row = np.cumsum(~removed) - 1
    kept = skeleton.edges[~removed[skeleton.edges].any(axis=1)]
    return Skeleton(skeleton.nodes[~removed], row[kept], skeleton.radii[~removed])


def _with_bounded_slope(skeleton: Skeleton, radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower radii until no edge has a larger slope than allowed."""
    i, j = skeleton.edges.T
    while True:
        lowered = radii.copy()
        np.minimum.at(lowered, i, radii[j] + MAX_SLOPE * skeleton.edge_lengths)
        np.minimum.at(lowered, j, radii[i] + MAX_SLOPE * skeleton.edge_lengths)
        if np.array_equal(lowered, radii):
            return radii
        radii = lowered


def _kept_apart(
    skeleton: Skeleton, radii: NDArray[np.float64], floor: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Lower radii where axes come near, and mark the nodes of end branches that are hidden in others."""
    branch_of_tip = {int(branch[-1]): branch for branch in skeleton.end_branches}
    end_of_node = np.full(len(radii), -1)  # the tip of the end branch that a node is on
    for tip, branch in branch_of_tip.items():
        end_of_node[branch[1:]] = tip
    hidden = np.zeros(len(radii), dtype=bool)
    for branch in branch_of_tip.values():
        reach = np.linalg.norm(skeleton.nodes[branch[-1]] - skeleton.nodes[branch[0]]) + radii[branch[-1]]
        hidden[branch[1:]] = reach < MIN_BRANCH_RATIO * radii[branch[0]]
    lowered = radii.copy()
    for i, j, share in _near_pairs(skeleton, radii):
        if hidden[i] or hidden[j]:
            continue
        for node in (i, j):
            lowered[node] = min(lowered[node], max(share * radii[node], floor))
        if share * min(radii[i], radii[j]) < floor:
            ends = [branch_of_tip[int(end)] for end in end_of_node[[i, j]] if end >= 0]
            for branch in sorted(ends, key=len)[:1]:
                hidden[branch[1:]] = True
    return lowered, hidden


def _near_pairs(skeleton: Skeleton, radii: NDArray[np.float64]) -> list[tuple[int, int, float]]:
    """List the pairs of nodes that are too near in space but not along the graph, with the factor on their radii."""
    tree = cKDTree(skeleton.nodes)
    nearby = tree.query_ball_point(skeleton.nodes, 2 * CLEARANCE * radii)  # of the thicker node of a pair
    i = np.repeat(np.arange(len(nearby)), [len(found) for found in nearby])
    j = np.concatenate([np.asarray(found, dtype=np.int64) for found in nearby])
    total = radii[i] + radii[j]
    apart = np.linalg.norm(skeleton.nodes[i] - skeleton.nodes[j], axis=1)
    chosen = (apart < CLEARANCE * total) & (radii[i] >= radii[j]) & (i != j)
    i, j, total, apart = i[chosen], j[chosen], total[chosen], apart[chosen]
    graph = weighted_graph(skeleton.edges, skeleton.edge_lengths, len(radii))
    near: list[tuple[int, int, float]] = []
    for block in np.array_split(np.unique(i), len(i) // 2000 + 1):
        along = dijkstra(graph, directed=False, indices=block, limit=2 * MIN_PATH * radii[block].max(initial=0.0))
        rows = np.flatnonzero(np.isin(i, block))
        path = along[np.searchsorted(block, i[rows]), j[rows]]
        rows = rows[path > MIN_PATH * total[rows]]
        near += zip(i[rows].tolist(), j[rows].tolist(), (apart / (CLEARANCE * total))[rows].tolist(), strict=True)
    return near
