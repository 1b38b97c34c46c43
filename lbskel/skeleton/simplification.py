"""Few straight bones for many nodes: each branch of a skeleton as the shortest polyline that stays within a tolerance.

Of all polylines through some of a branch's nodes, whose segments pass every node left out within ``tolerance`` of its
radii, that with the fewest segments: a shortest path over the segments allowed (Imai, Iri 1988, "Polygonal
approximations of a curve", https://doi.org/10.1016/B978-0-444-70467-2.50011-4). Of equals, the one with the least sum
of squared distances. The simplification of meshes is another thing: :func:`lbskel.preprocess.simplify`.
"""

from __future__ import annotations

__all__ = ["simplify_branches"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.skeleton.skeleton import Skeleton

LONGEST = 128  # nodes that a bone may span, so that time grows with the number of nodes only


def simplify_branches(skeleton: Skeleton, *, tolerance: float = 0.5) -> Skeleton:
    """The fewest straight bones along every branch; junctions, tips, anchors and loops stay.

    Parameters
    ----------
    skeleton : Skeleton
    tolerance : float
        Largest distance from a node that is left out to its bone, in radii of the node.

    Returns
    -------
    Skeleton
        Some of the nodes, none of them moved; a loop keeps three at least. The vertices of a node that is left out go
        to the nearest one along the branch.

    Raises
    ------
    UnknownChoice
        If the tolerance is not positive.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> skeleton = lbskel.skeletonize(capsule(4.0, 0.5))
    >>> lbskel.simplify_branches(skeleton)
    Skeleton(2 nodes, 1 edges, 2 tips, 0 junctions, 0 cycles)
    """
    if not tolerance > 0:
        raise UnknownChoice(f"tolerance must be positive, not {tolerance}")
    target = np.arange(len(skeleton.nodes))
    edges, ends_seen = [np.empty((0, 2), dtype=np.int64)], set()
    for branch in sorted(skeleton.branches, key=len):  # a single edge between two junctions cannot make way
        ends = frozenset((int(branch[0]), int(branch[-1])))
        least = 3 if len(ends) == 1 else 2 if ends in ends_seen else 1
        ends_seen.add(ends)
        reach = tolerance * np.where(np.isin(branch, skeleton.anchors), np.nan, skeleton.radii[branch])
        kept = _fewest(skeleton.nodes[branch], reach, least)
        edges.append(np.stack([branch[kept[:-1]], branch[kept[1:]]], axis=1))
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(skeleton.nodes[branch], axis=0), axis=1)))
        middles = (along[kept[:-1]] + along[kept[1:]]) / 2
        nearest = kept[np.searchsorted(middles, along)]
        target[branch[1:-1]] = branch[nearest[1:-1]]
    kept_nodes, group = np.unique(target, return_inverse=True)
    return _of_nodes(skeleton, kept_nodes, group, np.concatenate(edges))


def _of_nodes(
    skeleton: Skeleton, kept: NDArray[np.int64], group: NDArray[np.int64], edges: NDArray[np.int64]
) -> Skeleton:
    """Some nodes of a skeleton with edges between them; each of the others in the group of one of them."""
    return replace(
        skeleton,
        nodes=skeleton.nodes[kept],
        edges=group[edges],
        radii=skeleton.radii[kept],
        node_of_vertex=group[skeleton.node_of_vertex],
        mean_radii=skeleton.mean_radii[kept] if len(skeleton.mean_radii) else skeleton.mean_radii,
        anchors=group[skeleton.anchors],
    )


def _fewest(P: NDArray[np.float64], reach: NDArray[np.float64], least: int) -> NDArray[np.int64]:
    """Indices of the points of the polyline with the fewest segments, but no fewer than ``least``.

    ``segments[s, i]`` and ``error[s, i]`` are those of the best way to point i in s segments, or in s or more where s
    is ``least``.
    """
    n = len(P)
    segments = np.full((least + 1, n), n)
    error = np.full((least + 1, n), np.inf)
    before = np.zeros((least + 1, n, 2), dtype=np.int64)
    segments[0, 0] = error[0, 0] = 0
    for i in range(n - 1):
        allowed, cost = _segments_from(P[i : i + LONGEST + 1], reach[i : i + LONGEST + 1])
        following = i + 1 + allowed
        for s in range(least + 1):
            if segments[s, i] == n:
                continue
            t = min(s + 1, least)
            fewer = segments[s, i] + 1 < segments[t, following]
            nearer = (segments[s, i] + 1 == segments[t, following]) & (error[s, i] + cost < error[t, following])
            at, own = following[fewer | nearer], cost[fewer | nearer]
            segments[t, at], error[t, at], before[t, at] = segments[s, i] + 1, error[s, i] + own, (s, i)
    kept, state = [n - 1], min(least, n - 1)
    while kept[-1] > 0:
        state, previous = before[state, kept[-1]].tolist()
        kept.append(previous)
    return np.array(kept[::-1])


def _segments_from(P: NDArray[np.float64], reach: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """To which of the points 1, 2, ... a segment from point 0 is allowed, counted from 0, and its squared distances.

    No segment passes a point whose reach is NaN.
    """
    Q = P[1:] - P[0]
    squared = (Q * Q).sum(axis=1)
    share = np.clip((Q @ Q.T) / np.where(squared > 0, squared, 1)[:, None], 0, 1)  # of segment j at point k
    apart = np.maximum(squared - share * (2 * (Q @ Q.T) - share * squared[:, None]), 0)
    between = np.tri(len(Q), k=-1, dtype=bool)
    is_near = apart <= reach[1:] ** 2
    allowed = np.flatnonzero((is_near | ~between).all(axis=1))
    return allowed, np.where(between, apart, 0).sum(axis=1)[allowed]
