"""Junctions, placed by the centerlines of the branches that meet there.

A junction has no cross-section of its own. It is placed at the point nearest to the tangents of its branches at their
sections next to it, or where inscribed balls grow no more on the way to that point. From there it is moved towards the
middle of the solid by at most the standard error of that fit. Where the lines do not agree, or agree on a place with a
smaller ball, it is placed in the middle. Two junctions are merged where all branches that leave the pair point to one
place, there or as near to it as the ball is about as large as theirs. Along a trunk (:mod:`lbskel.refinement.trunks`)
they are merged where their limbs overlap, and where contraction has joined these in the wrong order.
"""

from __future__ import annotations

__all__ = ["merge_junctions_by_axes", "place_junctions"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.branch_lines import MAX_SINE, BranchLines, branch_lines, nearest_points
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.inscribed_balls import MIN_BALL_RATIO, climb_to_middle
from lbskel.refinement.trunks import judge_pairs
from lbskel.refinement.tunnel_sides import edges_that_pass, n_tunnels_missed
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.pruning import adjacent_junctions, closes_a_cycle, inner_branch_lengths
from lbskel.skeleton.skeleton import Skeleton

# Upper bound on the branch between two junctions that are merged, in radii of the larger. Rows in
# benchmarks/results/robustness.md: with 2 palms of bent hands have two junctions, 3 to 6 are alike, as are 2 to
# 6 in "merge length" in refinement.md; by hand, the pelvis of a human is 4.6 from its chest
MAX_MERGE_LENGTH = 4.0
# The same, where a trunk passes through both. Rows in robustness.md: 6 and more are alike, with 4 the error of hard
# shapes is larger by 3 %, as limbs that cross a thick bar at 40 degrees meet in two junctions
MAX_TRUNK_LENGTH = 6.0
# Growth of a junction's ball by length of its way out of that ball, below which the junction goes no farther to where
# its branches seem to meet. It is 0 along a tube, and the sine of half the angle on the bisector of two equal tubes.
# Rows "growth of balls" in benchmarks/results/refinement.md; by hand, on hard shapes in ten variants of steps and
# mirror images, 0.06 to 0.07 are alike, with less a pelvis enters a chest, with 0.087 crossing limbs meet twice
MIN_BALL_GROWTH = 0.065
# A guess: on a way of ten radii, stops are half a radius apart
N_STOPS = 17  # places on that way, of up to ten radii, at which a junction may stop
TINY = float(np.finfo(np.float64).tiny)


def place_junctions(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> SectionCenters:
    """Move each junction to the point nearest to the extended centerlines of its branches, and towards the middle.

    Parameters
    ----------
    skeleton : Skeleton
        Its nodes are the contracted positions.
    centers : SectionCenters
    surface : Surface
        A junction goes to the middle of its part of the solid where its branches do not agree on a place inside with
        at least MIN_BALL_RATIO of its ball.

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
    lines = branch_lines(skeleton, centers, with_single=True)
    rows, groups = lines.at(junctions[:, None])
    has_lines = np.bincount(groups, minlength=len(junctions)) >= 2
    rows, groups = rows[has_lines[groups]], groups[has_lines[groups]]
    own = lines.take(rows)
    placed = nearest_points(own, groups, placed, radii)
    agrees = np.isfinite(_largest_sines(own, groups, placed))
    olds = skeleton.nodes[junctions]
    placed[agrees] = _where_balls_stop_growing(olds[agrees], placed[agrees], radii[agrees], surface)
    is_settled = agrees & surface.contains(placed) & (surface.distance(placed) >= MIN_BALL_RATIO * radii)
    settled, astray = np.flatnonzero(is_settled), np.flatnonzero(~is_settled)
    errors = _standard_errors(own, groups, placed)[settled]
    placed[settled] = _towards(
        placed[settled], _middle(skeleton, junctions[settled], placed[settled], surface)[0], errors
    )
    middle, balls = _middle(skeleton, junctions[astray], olds[astray], surface)
    within = _towards(middle, placed[astray], balls)
    is_shallow = surface.distance(within) < MIN_BALL_RATIO * balls
    placed[astray] = np.where(is_shallow[:, None], middle, within)
    positions = np.array(centers.positions)
    positions[junctions] = placed
    return SectionCenters(centers.is_known & ~_is_passed(skeleton, centers, lines, positions), positions)


def _where_balls_stop_growing(
    starts: NDArray[np.float64], targets: NDArray[np.float64], radii: NDArray[np.float64], surface: Surface
) -> NDArray[np.float64]:
    """(k, 3) targets; in place of one outside of the ball around its start, the best of N_STOPS places on the way.

    Nearly parallel lines meet anywhere along a tube. So a junction goes beyond the rim of its ball, whose radius is
    given, only to a ball that is larger than that at the rim by MIN_BALL_GROWTH of the way between them at least.
    """
    ways = vector_lengths(targets - starts)
    places, far = np.array(targets), np.flatnonzero(ways > radii)
    lengths = np.linspace(radii[far], ways[far], N_STOPS, axis=1)
    stops = starts[far, None] + (lengths / ways[far, None])[:, :, None] * (targets - starts)[far, None]
    flat = stops.reshape(-1, 3)
    balls = np.where(surface.contains(flat), surface.distance(flat), -np.inf).reshape(lengths.shape)
    best = np.argmax(balls - MIN_BALL_GROWTH * lengths, axis=1)
    places[far] = stops[np.arange(len(far)), best]
    return places


def _standard_errors(lines: BranchLines, groups: NDArray[np.int64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(g,) standard error of the lines of each group, where three coordinates are fitted to two distances per line."""
    misses = vector_lengths(np.cross(places[groups] - lines.means, lines.directions))
    n_free = np.maximum(2 * np.bincount(groups, minlength=len(places)) - 3, 1)
    errors: NDArray[np.float64] = np.sqrt(np.bincount(groups, misses**2, len(places)) / n_free)
    return errors


def _towards(
    points: NDArray[np.float64], targets: NDArray[np.float64], limits: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(k, 3) points moved to targets, each by at most a limit."""
    distances = vector_lengths(targets - points)
    shares = np.divide(limits, distances, out=np.ones(len(limits)), where=distances > limits)
    moved: NDArray[np.float64] = points + shares[:, None] * (targets - points)
    return moved


def _middle(
    skeleton: Skeleton, junctions: NDArray[np.int64], places: NDArray[np.float64], surface: Surface
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) places moved to larger balls, along the principal directions of their junctions' edges, and (k,) radii."""
    places, balls = np.array(places), np.array(surface.distance(places))
    inside = np.flatnonzero(surface.contains(places))
    edges = [skeleton.nodes[skeleton.neighbors[j]] - skeleton.nodes[j] for j in junctions[inside].tolist()]
    frames = np.array([np.linalg.svd(vectors)[2] for vectors in edges]).reshape(-1, 3, 3)
    places[inside], balls[inside] = climb_to_middle(places[inside], frames, surface)
    return places, balls


def _is_passed(
    skeleton: Skeleton, centers: SectionCenters, lines: BranchLines, positions: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(k,) whether a section lies beyond the new position of a junction, in the direction of its branch."""
    is_passed = np.zeros(len(positions), dtype=bool)
    lines = lines.take(np.einsum("li,li->l", lines.starts - positions[lines.junctions], lines.directions) >= 0)
    for junction, index, is_first, direction in zip(
        lines.junctions, lines.branches, lines.is_first, lines.directions, strict=True
    ):
        path = skeleton.branches[index][:: 1 if is_first else -1]
        own = path[centers.is_known[path]]
        is_behind = (positions[own] - positions[junction]) @ direction >= 0
        is_passed[own[: len(own) if is_behind.all() else np.argmin(is_behind)]] = True
    return is_passed


def merge_junctions_by_axes(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> Skeleton:
    """Merge two junctions where the branches that leave the pair all point to one place.

    In a thick part, such as a palm, several branches run together before they end. Contraction then joins them in
    pairs, in an order that does not depend on where they come from. In each round, the pairs are merged that fit better
    than all pairs at the junctions beside them. No cycle is lost, and none is drawn off its tunnel.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches and inscribed radii.
    centers : SectionCenters
    surface : Surface
    """
    merged = _merged(skeleton, centers, surface, keep_sides=False)
    if n_tunnels_missed(merged, surface) > n_tunnels_missed(skeleton, surface):
        merged = _merged(skeleton, centers, surface, keep_sides=True)
    return merged


def _merged(skeleton: Skeleton, centers: SectionCenters, surface: Surface, *, keep_sides: bool) -> Skeleton:
    """Merge pairs of junctions; with ``keep_sides``, none whose edges would then pass a tunnel on another side."""
    while len(inner := _short_branches(skeleton)):
        lines = branch_lines(skeleton, centers)
        sines, places = _common_places(skeleton, lines, inner)
        sines = judge_pairs(skeleton, lines, inner, sines, surface)
        fitting = [row for row in np.argsort(sines, kind="stable").tolist() if np.isfinite(sines[row])]
        touched, target = np.zeros(len(skeleton.nodes), dtype=bool), np.arange(len(skeleton.nodes))
        nodes, radii, positions = np.array(skeleton.nodes), np.array(skeleton.radii), np.array(centers.positions)
        first, adjacent = adjacent_junctions(skeleton)
        for row in fitting:
            branch = skeleton.branches[inner[row]]
            beside = np.concatenate([adjacent[first[end] : first[end + 1]] for end in branch[[0, -1]]])
            if touched[branch[[0, -1]]].any() or closes_a_cycle(skeleton, branch):
                continue
            if keep_sides and _passes_a_tunnel(skeleton, branch, places[row], surface):
                continue
            touched[branch[[0, -1]]] = touched[beside] = True
            target[branch] = branch[0]
            nodes[branch[0]] = positions[branch[0]] = place = _with_ball(skeleton, branch, places[row], surface)
            radii[branch[0]] = surface.distance(place[None])[0]
        if not touched.any():
            return skeleton
        skeleton = contract_nodes(replace(skeleton, nodes=nodes, radii=radii), target)
        kept = np.unique(target)
        centers = SectionCenters(centers.is_known[kept], positions[kept])
    return skeleton


def _with_ball(
    skeleton: Skeleton, branch: NDArray[np.int64], place: NDArray[np.float64], surface: Surface
) -> NDArray[np.float64]:
    """Go from a place towards the end of a branch with the larger ball, until that there has MIN_BALL_RATIO of it.

    The radius of a ball changes by no more than its center moves, so that no step passes the end.
    """
    ends = skeleton.nodes[branch[[0, -1]]]
    balls = surface.distance(ends)
    while (ball := surface.distance(place[None])[0]) < MIN_BALL_RATIO * balls.max():
        way = ends[balls.argmax()] - place
        place = place + (balls.max() - ball) / np.linalg.norm(way) * way
    return place


def _passes_a_tunnel(
    skeleton: Skeleton, branch: NDArray[np.int64], place: NDArray[np.float64], surface: Surface
) -> bool:
    """Whether an edge passes a tunnel on another side when a branch is contracted to a place."""
    moved = np.array(skeleton.nodes)
    moved[branch] = place
    edges = skeleton.edges[np.isin(skeleton.edges, branch).any(axis=1)]
    return bool(edges_that_pass(skeleton.nodes, moved, edges, surface).any())


def _short_branches(skeleton: Skeleton) -> NDArray[np.int64]:
    """Find the branches between two junctions that are short enough for these to be merged on a trunk.

    Two short branches between the same junctions have a tunnel between them, so neither of them counts.
    """
    lengths, ends = inner_branch_lengths(skeleton)
    short = np.flatnonzero(lengths <= MAX_TRUNK_LENGTH * skeleton.radii[ends].max(axis=1))
    pairs = np.sort(ends[short], axis=1)
    _, pair, counts = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    single: NDArray[np.int64] = short[counts[pair.ravel()] == 1]
    return single


def _common_places(
    skeleton: Skeleton, lines: BranchLines, inner: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(i,) largest sine by which a line of the other branches at an inner branch misses their place, and (i, 3) places.

    The place is the point nearest to these lines. The sine is infinite where it is farther from the way between the two
    junctions than the ball of the larger one: legs that point to a chest have a pelvis of their own. So it is where
    the inner branch is longer than MAX_MERGE_LENGTH.
    """
    ends = skeleton.branch_ends[inner]
    rows, groups = lines.at(ends)
    is_outer = lines.branches[rows] != inner[groups]
    rows, groups = rows[is_outer], groups[is_outer]
    at_end = lines.junctions[rows, None] == ends[groups]
    has_both = np.all([np.bincount(groups[of_end], minlength=len(inner)) > 0 for of_end in at_end.T], axis=0)
    outer = lines.take(rows)
    places = nearest_points(outer, groups, skeleton.nodes[ends].mean(axis=1), np.zeros(len(inner)))
    sines = np.where(has_both, _largest_sines(outer, groups, places), np.inf)
    starts, ways = skeleton.nodes[ends[:, 0]], skeleton.nodes[ends[:, 1]] - skeleton.nodes[ends[:, 0]]
    lengths = np.maximum(np.einsum("ij,ij->i", ways, ways), TINY)
    shares = np.clip(np.einsum("ij,ij->i", places - starts, ways) / lengths, 0, 1)
    asides = vector_lengths(places - starts - shares[:, None] * ways)
    balls, all_lengths = skeleton.radii[ends].max(axis=1), inner_branch_lengths(skeleton)[0]
    is_near = (asides <= balls) & (all_lengths[inner] <= MAX_MERGE_LENGTH * balls)
    return np.where(is_near, sines, np.inf), places


def _largest_sines(lines: BranchLines, groups: NDArray[np.int64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(g,) the largest sine of an angle between the lines of each group and the direction to its place.

    The sine is infinite where a line passes beside the place. A line may start beyond it, as that of the trunk of a
    narrow fork. The sine is infinite for fewer than three lines, since two nearly meet in any case.
    """
    to_place = places[groups] - lines.means
    misses, distances = (vector_lengths(each) for each in (np.cross(to_place, lines.directions), to_place))
    sines = np.divide(misses, distances, out=np.zeros_like(misses), where=distances > 0)
    largest = np.where(np.bincount(groups, minlength=len(places)) >= 3, 0.0, np.inf)
    np.maximum.at(largest, groups, np.where(sines > MAX_SINE, np.inf, sines))
    return largest
