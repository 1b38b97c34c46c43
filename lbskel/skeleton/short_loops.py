"""Opening of short loops: handles that a surface has by noise or where limbs touch, and that the shape does not have.

The loops are those of the branch graph, whose edges are whole branches. From a loop that is shorter than a number of
local radii the thinnest branch is removed, so that the path around the other side stays. Where some of its balls touch
none of that path, as where two neurites touch twice, it is cable, and only its thinnest edge between these is removed.
"""

from __future__ import annotations

__all__ = ["n_opened_loops", "open_short_loops", "with_opened_loops"]

import heapq
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from lbskel.errors import UnknownChoice, is_number
from lbskel.geometry.normals import vector_lengths
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

MIN_RADIUS = 0.25  # lower bound on the radius that divides a length, in median radii of the branch; a guess


def open_short_loops(skeleton: Skeleton, min_loop: float) -> Skeleton:
    """Open every loop shorter than ``min_loop`` local radii at its thinnest branch, the shortest loop first.

    The thinnest branch is that with the smallest radius at a node between its ends, of the radii that are known. It is
    removed, and its vertices go to the nearer of its two ends; but where some of its balls touch none of the rest of
    the loop, only the thinnest edge between these is. A branch with an anchor is not removed.

    Parameters
    ----------
    skeleton : Skeleton
    min_loop : float
        Length of a loop, in local radii along it, below which it is opened. The ring around a tunnel as wide as
        its tube is thick has a length of 4 pi radii.

    Returns
    -------
    Skeleton
        If a loop was opened, its report counts them in ``loops_opened``; :func:`lbskel.score` does not count these as
        missing.

    Raises
    ------
    UnknownChoice
        If it is negative or NaN.

    Examples
    --------
    >>> from lbskel import Skeleton, open_short_loops
    >>> eye = Skeleton([[0, 0, 0], [1, 0, 0], [2, 1, 0], [2, -1, 0], [3, 0, 0], [4, 0, 0]],
    ...                [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [4, 5]], [1, 1, 1, 0.5, 1, 1])
    >>> open_short_loops(eye, 10).cycle_rank, open_short_loops(eye, 3).cycle_rank
    (0, 1)
    """
    if not (is_number(min_loop) and min_loop >= 0):
        raise UnknownChoice(f"min_loop must be a number of local radii, 0 or more, not {min_loop!r}")
    opened = skeleton
    while opened.cycle_rank and min_loop > 0:
        removed = _branches_to_remove(opened, min_loop)
        if not removed:
            break
        opened = _without_branches(opened, removed)
    return with_opened_loops(skeleton, opened)


def with_opened_loops(before: Skeleton, after: Skeleton, count: str = "loops_opened") -> Skeleton:
    """Count in the report of a skeleton the cycles that an edit has opened.

    Parameters
    ----------
    before, after : Skeleton
        ``after`` has some of the nodes and edges of ``before``.
    count : str
        The entry of the report: ``loops_opened``, or ``cycles_cut`` where all were.
    """
    n_opened = before.cycle_rank - after.cycle_rank
    if n_opened == 0:
        return after
    report = before.report | {count: before.report.get(count, 0) + n_opened}
    return replace(after, report=report)


def n_opened_loops(skeleton: Skeleton) -> int:
    """Count the cycles that were opened on purpose, according to the report.

    Parameters
    ----------
    skeleton : Skeleton
    """
    return sum(int(skeleton.report.get(count, 0)) for count in ("loops_opened", "cycles_cut"))


def _branches_to_remove(skeleton: Skeleton, min_loop: float) -> list[NDArray[np.int64]]:
    """Find a branch without an anchor, or an edge of it, to remove from each of some loops that share no branch."""
    branches = skeleton.branches
    lengths = _lengths_in_radii(skeleton, branches)
    adjacent: dict[int, list[tuple[int, float, int]]] = {}
    for index, (branch, length) in enumerate(zip(branches, lengths, strict=True)):
        if length < min_loop:
            for start, end in ((int(branch[0]), int(branch[-1])), (int(branch[-1]), int(branch[0]))):
                adjacent.setdefault(start, []).append((end, length, index))
    found = []
    for index, length in enumerate(lengths):
        if length < min_loop and (loop := _loop_through(branches[index], index, length, adjacent, min_loop)):
            found.append((sum(lengths[part] for part in loop), loop))
    taken: set[int] = set()
    removed = []
    for _, loop in sorted(found):
        free = [part for part in loop if not np.isin(branches[part][1:-1], skeleton.anchors).any()]
        if free and taken.isdisjoint(loop):
            taken.update(loop)
            thinnest = min(free, key=lambda part: _smallest_radius(skeleton.radii[branches[part]]))
            whole, others = branches[thinnest], [branches[part] for part in loop if part != thinnest]
            cable = _apart(skeleton, whole, np.concatenate(others)) if others else whole[:0]
            removed.append(_thinnest_edge(skeleton, cable) if len(cable) > 1 else whole)
    return removed


def _apart(skeleton: Skeleton, branch: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the nodes between the first and the last of a branch whose balls touch none of others; unknown ones do."""
    inner, radii = branch[1:-1], np.where(np.isnan(skeleton.radii), np.inf, skeleton.radii)
    gaps = cdist(skeleton.nodes[inner], skeleton.nodes[others]) - radii[inner, None] - radii[others]
    apart = np.flatnonzero((gaps > 0).all(axis=1))
    return inner[apart[0] : apart[-1] + 1] if len(apart) else apart


def _smallest_radius(radii: NDArray[np.float64]) -> float:
    """Find the smallest known radius between the ends of a branch, or at the ends of an edge; infinite without any."""
    between = radii[1:-1] if len(radii) > 2 else radii
    return float(np.where(np.isnan(between), np.inf, between).min())


def _lengths_in_radii(skeleton: Skeleton, branches: tuple[NDArray[np.int64], ...]) -> list[float]:
    """Integrate the inverse radius along branches; radii count as at least MIN_RADIUS of the median of those known."""
    sizes = np.array([len(branch) for branch in branches])
    ends, nodes, branch_of = np.cumsum(sizes), np.concatenate(branches), np.repeat(np.arange(len(sizes)), sizes)
    known = np.nan_to_num(skeleton.radii[nodes])
    ascending = known[np.lexsort((known, branch_of))]
    n_known = np.bincount(branch_of, known > 0).astype(np.int64)
    middles = ascending[[ends - 1 - n_known // 2, ends - 1 - np.maximum(n_known - 1, 0) // 2]]
    medians = np.where(n_known > 0, middles.mean(axis=0), 0.0)
    radii = np.maximum(known, MIN_RADIUS * medians[branch_of])
    lengths = vector_lengths(np.diff(skeleton.nodes[nodes], axis=0))
    between = (radii[1:] + radii[:-1]) / 2
    in_radii = np.divide(lengths, between, out=np.full_like(lengths, np.inf), where=between > 0)
    is_within = branch_of[1:] == branch_of[:-1]
    totals: list[float] = np.bincount(branch_of[1:][is_within], in_radii[is_within], len(sizes)).tolist()
    return totals


def _loop_through(
    branch: NDArray[np.int64],
    index: int,
    length: float,
    adjacent: dict[int, list[tuple[int, float, int]]],
    limit: float,
) -> list[int]:
    """Find the branches of the shortest loop through one of them; none if it is not shorter than a limit."""
    start, end = int(branch[0]), int(branch[-1])
    if start == end:
        return [index]
    queue: list[tuple[float, int, list[int]]] = [(length, start, [index])]
    done: set[int] = set()
    while queue:
        total, node, path = heapq.heappop(queue)
        if node == end:
            return path
        if node in done:
            continue
        done.add(node)
        for other, further, part in adjacent[node]:
            if part != index and other not in done and total + further < limit:
                heapq.heappush(queue, (total + further, other, [*path, part]))
    return []


def _thinnest_edge(skeleton: Skeleton, branch: NDArray[np.int64]) -> NDArray[np.int64]:
    """(2,) nodes of the edge of a branch that is thinnest at one of them; of several the longest, then the last."""
    known = np.where(np.isnan(skeleton.radii[branch]), np.inf, skeleton.radii[branch])
    lengths = vector_lengths(np.diff(skeleton.nodes[branch], axis=0))
    edge = int(np.lexsort((lengths, -np.minimum(known[1:], known[:-1])))[-1])
    return branch[edge : edge + 2]


def _without_branches(skeleton: Skeleton, branches: list[NDArray[np.int64]]) -> Skeleton:
    """Remove the edges and inner nodes of branches; of a branch that ends where it begins, only the thinnest edge."""
    k = len(skeleton.nodes)
    target, removed = np.arange(k), []
    for branch in branches:
        path = _thinnest_edge(skeleton, branch) if branch[0] == branch[-1] else branch
        removed.append(np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1))
        s = np.cumsum(vector_lengths(np.diff(skeleton.nodes[path], axis=0)))
        half = 1 + int(np.searchsorted(s[:-1], s[-1] / 2))
        target[path[1:half]], target[path[half:-1]] = path[0], path[-1]
    is_kept = ~np.isin(skeleton.edges @ [k, 1], np.concatenate(removed) @ [k, 1])
    return contract_nodes(replace(skeleton, edges=skeleton.edges[is_kept]), target)
