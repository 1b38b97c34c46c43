"""Junctions, placed by the branches that meet there.

A junction has no section of its own. It goes where the axes of its branches, carried on from their own sections, come
nearest to one point; and two junctions are one where all the branches that leave the pair point to one place.
"""

from __future__ import annotations

__all__ = ["merge_junctions_by_axes", "place_junctions"]

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.containment import segments_outside
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

NEAR = 4  # sections that tell the direction of a branch at its junction
ANCHORED = 0.02  # weight of a junction's contracted place, beside the axes of its branches
LONGEST = 3.0  # radii of the thicker of two junctions beyond which they are not taken for one
MISSES = 1.5  # radii of a branch by which its axis may pass the place where all meet
TILT = 0.4  # and the same as a sine of the angle between them
FREE = 0.5  # radii by which a junction may leave its contracted place though its branches do not all lead there


@dataclass(frozen=True, eq=False)
class _Lines:
    """The axes of the branches at junctions, as lines: one row for each that has sections enough.

    ``starts`` are the own sections nearest to the junction, ``means`` the centers of those that told the direction.
    """

    junctions: NDArray[np.int64]
    branches: NDArray[np.int64]
    starts: NDArray[np.float64]
    means: NDArray[np.float64]
    directions: NDArray[np.float64]

    def take(self, rows: NDArray[np.bool_]) -> _Lines:
        """Some of the rows."""
        return _Lines(
            self.junctions[rows], self.branches[rows], self.starts[rows], self.means[rows], self.directions[rows]
        )


def _lines(skeleton: Skeleton, axes: SectionCenters) -> _Lines:
    """The line of every branch at each of its junctions, pointing to the junction."""
    rows: list[tuple[int, int, NDArray, NDArray, NDArray]] = []
    for index, branch in enumerate(skeleton.branches):
        for way in (branch, branch[::-1]):
            own = way[1:-1][axes.is_known[way[1:-1]]][:NEAR]
            if skeleton.degrees[way[0]] < 3 or len(own) < 2:
                continue
            P = axes.places[own]
            direction = P[0] - P[-1]
            length = np.linalg.norm(direction)
            if length > 0:
                rows.append((int(way[0]), index, P[0], P.mean(axis=0), direction / length))
    junctions, branches, *vectors = zip(*rows, strict=True) if rows else ([], [], [], [], [])
    starts, means, directions = (np.array(v, dtype=np.float64).reshape(-1, 3) for v in vectors)
    return _Lines(np.array(junctions, dtype=np.int64), np.array(branches, dtype=np.int64), starts, means, directions)


def _meeting(lines: _Lines, anchor: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """The point nearest to all lines, each counted by the square of the distance over which it is carried on.

    What the lines leave open the anchor decides.
    """
    far = np.linalg.norm(lines.starts - anchor, axis=1)
    across = np.eye(3) - lines.directions[:, :, None] * lines.directions[:, None, :]
    across /= np.maximum(far, radius)[:, None, None] ** 2
    A = across.sum(axis=0)
    b = np.einsum("lij,lj->i", across, lines.means - anchor)
    loose = (ANCHORED * np.trace(A)) ** 2  # beside the squares, so that what the lines do tell is hardly moved
    return np.asarray(anchor + np.linalg.solve(A @ A + loose * np.eye(3), A @ b))


def place_junctions(skeleton: Skeleton, axes: SectionCenters, surface: Surface) -> SectionCenters:
    """The axes with each junction where those of its branches come nearest to one point.

    Sections beyond that point belong to the junction and are no longer known.

    Parameters
    ----------
    skeleton : Skeleton
        At its contracted places.
    axes : SectionCenters
    surface : Surface
        A place outside of it is not taken, the junction stays.
    """
    junctions = skeleton.junctions
    placed = np.array(skeleton.nodes[junctions])
    if len(junctions) == 0:
        return axes
    radii = surface.distance(placed)
    lines = _lines(skeleton, axes)
    for row, junction in enumerate(junctions.tolist()):
        mine = lines.take(lines.junctions == junction)
        if len(mine.junctions) < 2:
            continue
        place = _meeting(mine, placed[row], radii[row])
        move = place - placed[row]
        far = float(np.linalg.norm(move))
        if far > FREE * radii[row] and not np.isfinite(_misses(mine, place, surface)):
            move *= FREE * radii[row] / far
        placed[row] += move
    outer = ~surface.contains(placed)
    placed[outer] = skeleton.nodes[junctions[outer]]
    places = np.array(axes.places)
    places[junctions] = placed
    return SectionCenters(axes.is_known & ~_passed(skeleton, axes, lines, places), places)


def _passed(skeleton: Skeleton, axes: SectionCenters, lines: _Lines, places: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) which sections a junction has moved past, along the direction of its branch."""
    passed = np.zeros(len(places), dtype=bool)
    for junction, index, direction in zip(lines.junctions.tolist(), lines.branches, lines.directions, strict=True):
        branch = skeleton.branches[index]
        way = branch if branch[0] == junction else branch[::-1]
        own = way[axes.is_known[way]]
        is_beyond = (places[own] - places[junction]) @ direction >= 0
        passed[own[: len(own) if is_beyond.all() else np.argmin(is_beyond)]] = True
    return passed


def merge_junctions_by_axes(skeleton: Skeleton, axes: SectionCenters, surface: Surface) -> Skeleton:
    """Make one of two junctions where the branches that leave the pair all point to one place between them or beyond.

    In a thick body several branches run together before they end, and contraction joins them two by two, in an order
    that has nothing to do with where they come from: fingers in a palm. The best two go first, but never with a loop.

    Parameters
    ----------
    skeleton : Skeleton
        With branches evenly sampled and inscribed radii.
    axes : SectionCenters
    surface : Surface
    """
    while inner := _inner_branches(skeleton):
        lines = _lines(skeleton, axes)
        found = [(*_common_place(skeleton, lines, index, surface), index) for index in inner]
        for _, place, index in sorted((one for one in found if np.isfinite(one[0])), key=lambda one: one[0]):
            branch = skeleton.branches[index]
            target = np.arange(len(skeleton.nodes))
            target[branch] = branch[0]
            nodes, places = np.array(skeleton.nodes), np.array(axes.places)
            nodes[branch[0]] = places[branch[0]] = place
            merged = contract_nodes(replace(skeleton, nodes=nodes), target)
            if merged.cycle_rank == skeleton.cycle_rank:
                kept = np.unique(target)
                skeleton, axes = merged, SectionCenters(axes.is_known[kept], places[kept])
                break
        else:
            return skeleton
    return skeleton


def _inner_branches(skeleton: Skeleton) -> list[int]:
    """Branches short enough for their two junctions to be one."""
    found = []
    for index, branch in enumerate(skeleton.branches):
        ends = branch[[0, -1]]
        length = np.linalg.norm(np.diff(skeleton.nodes[branch], axis=0), axis=1).sum()
        if ends[0] != ends[1] and min(skeleton.degrees[ends]) >= 3 and length <= LONGEST * skeleton.radii[ends].max():
            found.append(index)
    return found


def _common_place(skeleton: Skeleton, lines: _Lines, index: int, surface: Surface) -> tuple[float, NDArray[np.float64]]:
    """Where all branches at the two ends of an inner one meet, and by how much they miss it."""
    branch = skeleton.branches[index]
    middle = skeleton.nodes[branch[[0, -1]]].mean(axis=0)
    outer = lines.take(np.isin(lines.junctions, branch[[0, -1]]) & (lines.branches != index))
    if not np.isin(branch[[0, -1]], outer.junctions).all():
        return np.inf, middle
    place = _meeting(outer, middle, 0.0)
    return _misses(outer, place, surface), place


def _misses(lines: _Lines, place: NDArray[np.float64], surface: Surface) -> float:
    """The largest sine of an angle by which a line misses a place, if all of them lead there.

    Infinite where one has sections well beyond, passes too far, or would have to leave the surface; and for fewer than
    three lines, since two nearly meet somewhere in any case.
    """
    way = place - lines.means
    along = np.einsum("li,li->l", place - lines.starts, lines.directions)
    miss = np.linalg.norm(np.cross(way, lines.directions), axis=1)
    sine = miss / np.linalg.norm(way, axis=1)
    radii = surface.distance(lines.starts)
    leads = (along > -radii) & (miss <= MISSES * radii) & (sine <= TILT)
    ends, last = np.concatenate([lines.starts, place[None]]), len(leads)
    ways = np.stack([np.arange(last), np.full(last, last)], axis=1)
    return np.inf if last < 3 or not leads.all() or segments_outside(ends, ways, surface).any() else float(sine.max())
