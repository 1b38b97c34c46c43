"""Simplifying branches: each branch as the polyline with the fewest segments that stays within a tolerance.

Among all polylines through some of a branch's nodes, whose segments pass every omitted node within ``tolerance`` times
its radius and stand for at most ``MAX_SPAN`` edges, the one with the fewest segments is a shortest path over the
allowed segments (Imai, Iri 1988, "Polygonal approximations of a curve",
https://doi.org/10.1016/B978-0-444-70467-2.50011-4). Ties are broken by the sum of squared distances. Meshes are
simplified by :func:`lbskel.preprocess.simplify`.
"""

from __future__ import annotations

__all__ = ["simplify_branches"]

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice, is_number
from lbskel.geometry.normals import vector_lengths
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.joining import without_joining_edges
from lbskel.skeleton.skeleton import Skeleton

MAX_SPAN = 128  # number of edges that a segment may stand for, so that time is linear in the number of nodes; a guess


def simplify_branches(skeleton: Skeleton, *, tolerance: float = 0.5) -> Skeleton:
    """Replace every branch by the fewest straight segments; junctions, tips, anchors, the root, loops and joins stay.

    Parameters
    ----------
    skeleton : Skeleton
    tolerance : float
        Upper bound on the distance of an omitted node from its segment, in radii of the node.

    Returns
    -------
    Skeleton
        Some of the nodes, none of them moved; a loop keeps at least three, and no segment stands for more than 128
        edges. The vertices of an omitted node go to the nearest kept node along the branch.

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
    Skeleton(2 nodes, 1 edge, 2 tips, 0 junctions, 0 cycles)
    """
    if not (is_number(tolerance) and tolerance > 0):
        raise UnknownChoice(f"tolerance must be positive, in local radii, not {tolerance!r}")
    return without_joining_edges(partial(_simplified, tolerance=tolerance), skeleton)


def _simplified(skeleton: Skeleton, *, tolerance: float) -> Skeleton:
    """Replace every branch by the fewest segments within the tolerance."""
    target = np.arange(len(skeleton.nodes))
    edges, ends_seen = [np.empty((0, 2), dtype=np.int64)], set()
    for branch in sorted(skeleton.branches, key=len):  # a single edge between two junctions cannot be bent aside
        ends = frozenset((int(branch[0]), int(branch[-1])))
        min_segments = 3 if len(ends) == 1 else 2 if ends in ends_seen else 1
        ends_seen.add(ends)
        radii = skeleton.radii[branch]
        tolerances = np.multiply(tolerance, radii, out=np.zeros(len(branch)), where=radii != 0)  # inf times 0 is 0
        tolerances[np.isin(branch, skeleton.anchors)] = np.nan
        kept = _fewest_segments(skeleton.nodes[branch], tolerances, min_segments)
        edges.append(np.stack([branch[kept[:-1]], branch[kept[1:]]], axis=1))
        lengths = vector_lengths(np.diff(skeleton.nodes[branch], axis=0))
        arc_length = np.append(0.0, np.cumsum(lengths))
        middles = (arc_length[kept[:-1]] + arc_length[kept[1:]]) / 2
        nearest = kept[np.searchsorted(middles, arc_length)]
        nearest[kept] = kept  # also where two of them coincide
        target[branch[1:-1]] = branch[nearest[1:-1]]
    return contract_nodes(replace(skeleton, edges=np.concatenate(edges)), target)


def _fewest_segments(P: NDArray[np.float64], tolerances: NDArray[np.float64], min_segments: int) -> NDArray[np.int64]:
    """Find the points of the polyline with the fewest segments, but no fewer than ``min_segments``.

    Dynamic programming over the points: ``segments[s, i]`` and ``error[s, i]`` belong to the best polyline to point i
    with s segments, or with s or more where s is ``min_segments``.
    """
    n = len(P)
    segments = np.full((min_segments + 1, n), n)
    error = np.full((min_segments + 1, n), np.inf)
    previous = np.zeros((min_segments + 1, n, 2), dtype=np.int64)
    segments[0, 0] = error[0, 0] = 0
    for i in range(n - 1):
        allowed, cost = _segments_from(P[i : i + MAX_SPAN + 1], tolerances[i : i + MAX_SPAN + 1])
        following = i + 1 + allowed
        for s in range(min_segments + 1):
            if segments[s, i] == n:
                continue
            t = min(s + 1, min_segments)
            has_fewer = segments[s, i] + 1 < segments[t, following]
            is_tie = segments[s, i] + 1 == segments[t, following]
            is_better = has_fewer | (is_tie & (error[s, i] + cost < error[t, following]))
            at, own_cost = following[is_better], cost[is_better]
            segments[t, at], error[t, at], previous[t, at] = segments[s, i] + 1, error[s, i] + own_cost, (s, i)
    kept, state = [n - 1], min(min_segments, n - 1)
    while kept[-1] > 0:
        state, point = previous[state, kept[-1]].tolist()
        kept.append(point)
    return np.array(kept[::-1])


def _segments_from(
    P: NDArray[np.float64], tolerances: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Find where a segment from point 0 may end, as points counted from point 1, and the squared distances it costs.

    No segment passes a point whose tolerance is NaN.
    """
    Q = P[1:] - P[0]
    squared = (Q * Q).sum(axis=1)
    share = np.clip((Q @ Q.T) / np.where(squared > 0, squared, 1)[:, None], 0, 1)  # along segment j, of point k
    distances = np.maximum(squared - share * (2 * (Q @ Q.T) - share * squared[:, None]), 0)  # squared
    is_between = np.tri(len(Q), k=-1, dtype=bool)
    is_near = distances <= tolerances[1:] ** 2
    allowed = np.flatnonzero((is_near | ~is_between).all(axis=1))
    return allowed, np.where(is_between, distances, 0).sum(axis=1)[allowed]
