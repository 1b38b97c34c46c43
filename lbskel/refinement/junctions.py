"""Junctions, placed by the centerlines of the branches that meet there.

A junction has no cross-section of its own. It goes to the point nearest to the centerlines of its branches, extended
straight from their own sections. Two junctions are merged where all branches that leave the pair point to one place.
"""

from __future__ import annotations

__all__ = ["merge_junctions_by_axes", "place_junctions"]

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.containment import segments_outside
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

N_SECTIONS = 4  # sections next to a junction that give the direction of a branch; a guess,
# benchmarks/results/constants.md
REGULARIZATION = 0.02  # weight of a junction's contracted position, relative to the trace of the system of its lines; a
# guess, benchmarks/results/constants.md
MAX_MERGE_LENGTH = 3.0  # upper bound on the branch between two junctions that are merged, in radii of the larger; a
# guess, benchmarks/results/constants.md
MAX_MISS = 1.5  # upper bound on the distance of a branch's line from the common place, in radii of the branch; a guess,
# benchmarks/results/constants.md
MAX_SINE = 0.4  # upper bound on the sine of the angle between a branch's line and the direction to the common place; a
# guess, benchmarks/results/constants.md
MAX_FREE_MOVE = 0.5  # upper bound on the move of a junction whose branches do not all point to one place, in radii; a
# guess, benchmarks/results/constants.md


@dataclass(frozen=True, eq=False)
class _Lines:
    """Straight extensions of branches to their junctions: one row per junction and branch with enough sections.

    ``starts`` are the own sections nearest to the junction, ``means`` the centroids of the sections that gave the
    direction. The unit ``directions`` point to the junction.
    """

    junctions: NDArray[np.int64]
    branches: NDArray[np.int64]
    starts: NDArray[np.float64]
    means: NDArray[np.float64]
    directions: NDArray[np.float64]

    @cached_property
    def _order(self) -> NDArray[np.int64]:
        """Rows by junction."""
        return np.argsort(self.junctions, kind="stable")

    def at(self, junctions: NDArray[np.int64]) -> _Lines:
        """Select the rows of one or two junctions."""
        ascending = self.junctions[self._order]
        spans = zip(np.searchsorted(ascending, junctions), np.searchsorted(ascending, junctions, "right"), strict=True)
        return self.take(np.sort(np.concatenate([self._order[begin:end] for begin, end in spans])))

    def take(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> _Lines:
        """Select some of the rows."""
        return _Lines(
            self.junctions[rows], self.branches[rows], self.starts[rows], self.means[rows], self.directions[rows]
        )


def _branch_lines(skeleton: Skeleton, centers: SectionCenters) -> _Lines:
    """Find the line of every branch at each of its junctions."""
    junctions: list[int] = []
    branches: list[int] = []
    vectors: list[NDArray[np.float64]] = []
    for index, branch in enumerate(skeleton.branches):
        for path in (branch, branch[::-1]):
            own = path[1:-1][centers.is_known[path[1:-1]]][:N_SECTIONS]
            if skeleton.degrees[path[0]] < 3 or len(own) < 2:
                continue
            P = centers.positions[own]
            direction = P[0] - P[-1]
            length = np.linalg.norm(direction)
            if length > 0:
                junctions.append(int(path[0]))
                branches.append(index)
                vectors.append(np.stack([P[0], P.mean(axis=0), direction / length]))
    starts, means, directions = np.array(vectors, dtype=np.float64).reshape(-1, 3, 3).transpose(1, 0, 2)
    return _Lines(np.array(junctions, dtype=np.int64), np.array(branches, dtype=np.int64), starts, means, directions)


def _nearest_point(lines: _Lines, anchor: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Find the point with the least weighted sum of squared distances to all lines.

    A line's weight is the inverse square of the distance over which it is extended, at least the radius. Directions
    that the lines leave undetermined are decided by the anchor.
    """
    distances = np.linalg.norm(lines.starts - anchor, axis=1)
    projections = np.eye(3) - lines.directions[:, :, None] * lines.directions[:, None, :]
    projections /= np.maximum(distances, radius)[:, None, None] ** 2
    A = projections.sum(axis=0)
    b = np.einsum("lij,lj->i", projections, lines.means - anchor)
    regularization = (REGULARIZATION * np.trace(A)) ** 2  # added to A @ A: well-determined directions hardly move
    return np.asarray(anchor + np.linalg.solve(A @ A + regularization * np.eye(3), A @ b))


def place_junctions(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> SectionCenters:
    """Move each junction to the point nearest to the extended centerlines of its branches.

    Parameters
    ----------
    skeleton : Skeleton
        Its nodes are the contracted positions.
    centers : SectionCenters
    surface : Surface
        A junction stays where its new position would be outside.

    Returns
    -------
    SectionCenters
        With the junctions' new positions. Sections that a junction has passed are no longer known.
    """
    junctions = skeleton.junctions
    placed = np.array(skeleton.nodes[junctions])
    if len(junctions) == 0:
        return centers
    radii = surface.distance(placed)
    lines = _branch_lines(skeleton, centers)
    for row in range(len(junctions)):
        own = lines.at(junctions[row : row + 1])
        if len(own.junctions) < 2:
            continue
        target = _nearest_point(own, placed[row], radii[row])
        move = target - placed[row]
        distance = float(np.linalg.norm(move))
        max_move = MAX_FREE_MOVE * radii[row]
        if distance > max_move and not np.isfinite(_largest_sine(own, target, surface)):
            move *= max_move / distance
        placed[row] += move
    is_outside = ~surface.contains(placed)
    placed[is_outside] = skeleton.nodes[junctions[is_outside]]
    positions = np.array(centers.positions)
    positions[junctions] = placed
    return SectionCenters(centers.is_known & ~_is_passed(skeleton, centers, lines, positions), positions)


def _is_passed(
    skeleton: Skeleton, centers: SectionCenters, lines: _Lines, positions: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(k,) the sections that lie behind the new position of a junction, in the direction of their branch."""
    is_passed = np.zeros(len(positions), dtype=bool)
    for junction, index, direction in zip(lines.junctions.tolist(), lines.branches, lines.directions, strict=True):
        branch = skeleton.branches[index]
        path = branch if branch[0] == junction else branch[::-1]
        own = path[centers.is_known[path]]
        is_behind = (positions[own] - positions[junction]) @ direction >= 0
        is_passed[own[: len(own) if is_behind.all() else np.argmin(is_behind)]] = True
    return is_passed


def merge_junctions_by_axes(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> Skeleton:
    """Merge two junctions where the branches that leave the pair all point to one place.

    In a thick part, such as a palm, several branches run together before they end. Contraction then joins them in
    pairs, in an order that does not depend on where they come from. In each round, the pairs are merged that fit better
    than all pairs at the junctions beside them. No cycle is closed.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches and inscribed radii.
    centers : SectionCenters
    surface : Surface
    """
    while inner := _inner_branches(skeleton):
        lines = _branch_lines(skeleton, centers)
        candidates = [(*_common_place(skeleton, lines, index, surface), index) for index in inner]
        fitting = sorted((c for c in candidates if np.isfinite(c[0])), key=lambda candidate: candidate[0])
        touched, target = np.zeros(len(skeleton.nodes), dtype=bool), np.arange(len(skeleton.nodes))
        nodes, positions = np.array(skeleton.nodes), np.array(centers.positions)
        first, adjacent = _adjacent_junctions(skeleton)
        for _, place, index in fitting:
            branch = skeleton.branches[index]
            beside = np.concatenate([adjacent[first[end] : first[end + 1]] for end in branch[[0, -1]]])
            if touched[branch[[0, -1]]].any() or _closes_a_cycle(skeleton, branch):
                continue
            touched[branch[[0, -1]]] = touched[beside] = True
            target[branch] = branch[0]
            nodes[branch[0]] = positions[branch[0]] = place
        if not touched.any():
            return skeleton
        skeleton = contract_nodes(replace(skeleton, nodes=nodes), target)
        kept = np.unique(target)
        centers = SectionCenters(centers.is_known[kept], positions[kept])
    return skeleton


def _adjacent_junctions(skeleton: Skeleton) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Adjacency of nodes that are the two ends of a branch."""
    ends = np.array([branch[[0, -1]] for branch in skeleton.branches], dtype=np.int64).reshape(-1, 2)
    both = np.concatenate([ends, ends[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    return np.searchsorted(both[order, 0], np.arange(len(skeleton.nodes) + 1)), both[order, 1]


def _closes_a_cycle(skeleton: Skeleton, branch: NDArray[np.int64]) -> bool:
    """Whether another path of at most two edges joins the ends of a branch, which merging them would close."""
    first, adjacent = skeleton.adjacency
    one, other = (set(adjacent[first[end] : first[end + 1]].tolist()) for end in branch[[0, -1]])
    within = set(branch.tolist())
    return bool((one & other) - within) or (len(branch) > 2 and int(branch[-1]) in one)


def _inner_branches(skeleton: Skeleton) -> list[int]:
    """Find the branches between two junctions that are short enough for them to be merged."""
    found = []
    for index, branch in enumerate(skeleton.branches):
        ends = branch[[0, -1]]
        length = np.linalg.norm(np.diff(skeleton.nodes[branch], axis=0), axis=1).sum()
        is_short = length <= MAX_MERGE_LENGTH * skeleton.radii[ends].max()
        if ends[0] != ends[1] and min(skeleton.degrees[ends]) >= 3 and is_short:
            found.append(index)
    return found


def _common_place(skeleton: Skeleton, lines: _Lines, index: int, surface: Surface) -> tuple[float, NDArray[np.float64]]:
    """Where all other branches at the two ends of an inner branch meet, and the largest sine by which one misses it."""
    branch = skeleton.branches[index]
    middle = skeleton.nodes[branch[[0, -1]]].mean(axis=0)
    outer = lines.at(branch[[0, -1]])
    outer = outer.take(outer.branches != index)
    if not np.isin(branch[[0, -1]], outer.junctions).all():
        return np.inf, middle
    place = _nearest_point(outer, middle, 0.0)
    return _largest_sine(outer, place, surface), place


def _largest_sine(lines: _Lines, place: NDArray[np.float64], surface: Surface) -> float:
    """Measure the largest sine of an angle between a line and the direction to a place, if all lines point there.

    Infinite where a line starts well beyond the place, passes it too far, or leaves the surface before it; and for
    fewer than three lines, since two lines nearly meet somewhere in any case.
    """
    to_place = place - lines.means
    along = np.einsum("li,li->l", place - lines.starts, lines.directions)
    miss = np.linalg.norm(np.cross(to_place, lines.directions), axis=1)
    sine = miss / np.linalg.norm(to_place, axis=1)
    radii = surface.distance(lines.starts)
    points_there = (along > -radii) & (miss <= MAX_MISS * radii) & (sine <= MAX_SINE)
    nodes, n_lines = np.concatenate([lines.starts, place[None]]), len(points_there)
    segments = np.stack([np.arange(n_lines), np.full(n_lines, n_lines)], axis=1)
    if n_lines < 3 or not points_there.all() or segments_outside(nodes, segments, surface).any():
        return np.inf
    return float(sine.max())
