"""Tips: every end branch extended to one radius below the surface, from where contraction had pulled it back.

From its last node an end follows the centerline in steps of a local radius, each corrected to the centroid of the
cross-section there, until the surface ahead is as near as the surface around it: there is the last inscribed ball. In a
limb that bends near its end the surface ahead is that beside the centerline, so the end is then traced on towards the
end of the limb that the last nodes represent. Where the last ball is still far from there, these nodes are moved to the
axis of the limb (:mod:`lbskel.refinement.level_sets`), and the branch is extended from there.
"""

from __future__ import annotations

__all__ = ["extend_ends", "extend_tips", "trace_centerline"]

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.level_sets import MAX_OFFSET, centered_axes, find_geodesic_caps, interior_axes
from lbskel.skeleton.editing import append_paths, contract_nodes
from lbskel.skeleton.skeleton import Skeleton

# The numbers are guesses where nothing else is said; benchmarks/results/constants.md
# Lower bound on a step along a centerline, in radii at its start, so that a needle takes no more steps than a cone;
# where the last inscribed ball is nearer, the end has reached it. Rows "shortest step of" in
# benchmarks/results/refinement.md: alike from 0.02 to 0.125; by hand, with 0.125 more ends are crooked
MIN_STEP = 0.05
MAX_STEPS = 60  # per end, which bounds the time
# Upper bound on the distance from the end of a limb within which a tip belongs to it, in radii of the limb or of the
# last ball; farther, the last nodes are replaced. Rows "reach of a tip" in benchmarks/results/refinement.md
TIP_REACH = 2.5
# Upper bound on that distance, in the same radii, where a tip is at the end already: 1 at a hemisphere, sqrt(3) at the
# corner of a cube. "Tips traced on" in benchmarks/results/neurons.md: farther, ends around bends are missed
BLUNT_REACH = 1.75
MIN_LIMB_LENGTH = 3.4  # of a limb, in radii; a flat patch has 2, a hemisphere 2.5, the corner of a foot up to 3.3
# Upper bound on the reach of a section from the point where it is cut, beyond the step there, in mean distances of the
# section before from its centroid: the ends of a slit have 2. It bounds the time. Rows "reach of sections of" in
# benchmarks/results/refinement.md: alike from 2 to 5
MAX_REACH = 3.0
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class _Limb:
    """The limb of the last nodes of an end branch: their number, its axis, its radius and the vertex at its end."""

    n_nodes: int
    axis: NDArray[np.float64]
    radius: float
    end: NDArray[np.float64]


def extend_tips(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Extend every end branch until its tip is the center of the last inscribed ball.

    Parameters
    ----------
    skeleton : Skeleton
        Centered, so that its end branches follow the centerlines.
    surface : Surface
    """
    ends = [b if skeleton.degrees[b[-1]] == 1 else b[::-1] for b in skeleton.branches]
    ends = [b for b in ends if skeleton.degrees[b[-1]] == 1]
    if len(skeleton.branches) == 1 and ends:  # one branch with two ends
        ends = [ends[0], ends[0][::-1]]
    ends = [b for b in ends if (skeleton.nodes[b[-1]] != skeleton.nodes[b[-4:][0]]).any()]
    if not ends:
        return skeleton
    directions = np.array([skeleton.nodes[end[-1]] - skeleton.nodes[end[-4:][0]] for end in ends])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    last = np.array([b[-1] for b in ends])
    skeleton = _with_centered_ends(skeleton, surface, ends, directions)
    paths = trace_centerline(surface, skeleton.nodes[last], directions)
    tips = np.array([path[-1] if path else skeleton.nodes[end] for end, path in zip(last, paths, strict=True)])
    limbs = _limbs_ahead(skeleton, surface, ends, tips)
    paths = _traced_on(paths, tips, directions, {index: limb.end for index, limb in limbs.items()}, surface)
    tips = np.array([path[-1] if path else tip for tip, path in zip(tips, paths, strict=True)])
    radii = surface.distance(tips)
    missed = {
        index: limb
        for index, limb in limbs.items()
        if len(limb.axis) and math.dist(limb.end, tips[index]) > TIP_REACH * max(limb.radius, radii[index])
    }
    if not missed:
        return extend_ends(skeleton, surface, last, paths)
    level_axes = [limb.axis for limb in missed.values()]
    centered = centered_axes(level_axes, np.array([limb.radius for limb in missed.values()]), surface)
    axes = [own if len(own) >= 2 else axis for axis, own in zip(level_axes, centered, strict=True)]
    onward = trace_centerline(
        surface, np.array([axis[-1] for axis in axes]), np.array([axis[-1] - axis[-2] for axis in axes])
    )
    target, nodes = np.arange(len(skeleton.nodes)), np.array(skeleton.nodes)
    for (index, limb), axis, continuation in zip(missed.items(), axes, onward, strict=True):
        target[ends[index][-limb.n_nodes :]] = last[index]
        nodes[last[index]] = axis[0]
        paths[index] = [*axis[1:], *continuation]
    last = np.searchsorted(np.unique(target), last)
    return extend_ends(contract_nodes(replace(skeleton, nodes=nodes), target), surface, last, paths)


def _with_centered_ends(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], directions: NDArray[np.float64]
) -> Skeleton:
    """Move the tips to the centroids of their cross-sections, where the sections surround the tips or are near."""
    nodes, first, last = np.array(skeleton.nodes), [end[0] for end in ends], [end[-1] for end in ends]
    section = cross_sections(surface.mesh, nodes[last], directions, deadline=surface.deadline)
    offset, length = (np.linalg.norm(nodes[last] - other, axis=1) for other in (section.centroids, nodes[first]))
    is_own = section.surrounds & (offset <= section.radii)
    is_own |= section.is_cut & ~surface.contains(nodes[last]) & (offset <= MAX_OFFSET * section.radii)
    is_own &= (offset <= length) & surface.contains(section.centroids)
    nodes[np.array(last)[is_own]] = section.centroids[is_own]
    return replace(skeleton, nodes=nodes)


def _traced_on(
    paths: list[list[NDArray[np.float64]]],
    tips: NDArray[np.float64],
    directions: NDArray[np.float64],
    goals: dict[int, NDArray[np.float64]],
    surface: Surface,
) -> list[list[NDArray[np.float64]]]:
    """Continue some paths along the centerlines from their tips towards goals, where these lie ahead."""
    numbers = np.array([*goals], dtype=np.int64)
    ways = np.array([*goals.values()]).reshape(-1, 3) - tips[numbers]
    is_ahead = np.einsum("ki,ki->k", ways, directions[numbers]) > 0
    numbers, ways = numbers[is_ahead], ways[is_ahead]
    onward = dict(zip(numbers, trace_centerline(surface, tips[numbers], ways), strict=True))
    return [[*path, *onward.get(number, [])] for number, path in enumerate(paths)]


def _limbs_ahead(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], tips: NDArray[np.float64]
) -> dict[int, _Limb]:
    """For each end branch whose tip is not at the end of its limb: the limb, without an axis if the tip is near.

    The limb is the patch of the vertices of the branch's last 1, 2, 4, ... nodes, up to all. Among candidate limbs,
    keep the one with the smallest detour from the junction to its end.
    """
    radii = surface.distance(tips)
    n_tried = dict.fromkeys(range(len(ends)), 1)
    best: dict[int, tuple[float, _Limb]] = {}
    near: dict[int, _Limb] = {}
    while n_tried:
        patch = np.full(len(skeleton.nodes), -1)
        for index, n in n_tried.items():
            patch[ends[index][-n:]] = index
        caps = find_geodesic_caps(surface.proxy.mesh, surface.on_proxy(patch[skeleton.node_of_vertex]))
        gaps = {k: math.dist(cap.end, tips[k]) / max(cap.radius, radii[k], TINY) for k, cap in caps.items()}
        reached = {index for index, gap in gaps.items() if gap <= TIP_REACH}
        blunt = [index for index in reached if gaps[index] > BLUNT_REACH]
        near |= {index: _Limb(0, np.empty((0, 3)), caps[index].radius, caps[index].end) for index in blunt}
        trying, n_tried = {index: n for index, n in n_tried.items() if index not in reached}, {}
        limbs = [
            index for index in trying if index in caps and caps[index].length > MIN_LIMB_LENGTH * caps[index].radius
        ]
        for index, axis in zip(limbs, interior_axes([caps[index] for index in limbs], surface), strict=True):
            if len(axis) >= 2:
                branch, n = ends[index], trying[index]
                detour = _detour(np.concatenate([skeleton.nodes[branch[:-n]], axis, caps[index].end[None]]))
                if index not in best or detour < best[index][0]:
                    best[index] = detour, _Limb(n, axis, caps[index].radius, caps[index].end)
        for index, n in trying.items():
            if n < len(ends[index]) - 1:
                n_tried[index] = min(2 * n, len(ends[index]) - 1)
    return near | {index: limb for index, (_, limb) in best.items()}


def _detour(path: NDArray[np.float64]) -> float:
    """Measure the length of a path relative to the distance between its ends."""
    straight = float(np.linalg.norm(path[-1] - path[0]))
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) / max(straight, TINY)


def trace_centerline(
    surface: Surface, starts: NDArray[np.float64], directions: NDArray[np.float64]
) -> list[list[NDArray[np.float64]]]:
    """Trace the centerline ahead of each end up to its last inscribed ball; all ends are traced at once.

    Parameters
    ----------
    surface : Surface
    starts : (e, 3) array of float
        On the centerlines.
    directions : (e, 3) array of float
        Need not be of unit length.

    Returns
    -------
    list of e lists of (3,) arrays of float
        The points after each start; none where the start is at the last inscribed ball.
    """
    P = np.array(starts)
    T = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    first = np.array(T)
    paths: list[list[NDArray[np.float64]]] = [[] for _ in P]
    section = cross_sections(surface.mesh, P, T, deadline=surface.deadline)
    width, radii = section.radii, _hydraulic_radii(section)
    first_radii = np.array(radii)
    active = np.arange(len(P))
    for _ in range(MAX_STEPS):
        radius = radii[active]
        ahead = surface.ray_distance(P[active], T[active])
        is_straight = np.einsum("ki,ki->k", T[active], first[active]) > 0
        shortest = MIN_STEP * first_radii[active]
        continues = is_straight & np.isfinite(ahead) & (ahead - radius > shortest) & (radius > 0)
        active, radius, ahead, shortest = active[continues], radius[continues], ahead[continues], shortest[continues]
        if len(active) == 0:
            break
        step = np.minimum(np.maximum(radius, shortest), ahead - radius)
        forward = P[active] + step[:, None] * T[active]
        reach = step + MAX_REACH * width[active]
        section = cross_sections(surface.mesh, forward, T[active], max_reaches=reach, deadline=surface.deadline)
        is_own = section.surrounds & (np.linalg.norm(section.centroids - forward, axis=1) <= step)
        is_own &= surface.contains(section.centroids)
        active, moved = active[is_own], section.centroids[is_own]
        width[active], radii[active] = section.radii[is_own], _hydraulic_radii(section)[is_own]
        T[active] = (moved - P[active]) / np.linalg.norm(moved - P[active], axis=1, keepdims=True)
        P[active] = moved
        for end, point in zip(active, moved, strict=True):
            paths[end].append(point)
    return paths


def _hydraulic_radii(sections: Sections) -> NDArray[np.float64]:
    """Hydraulic radii, 2 area / length: the radius of a circle, about the thickness of a flat section.

    They are averages over the curve, so noise does not make them small, as it does the distance to the nearest point.
    """
    radii: NDArray[np.float64] = np.divide(
        2 * sections.areas, sections.lengths, out=np.zeros(len(sections.areas)), where=sections.lengths > 0
    )
    return radii


def extend_ends(
    skeleton: Skeleton, surface: Surface, ends: NDArray[np.int64], paths: list[list[NDArray[np.float64]]]
) -> Skeleton:
    """Append a path of new nodes to each of p nodes; the vertices of such a node go to the nearest node of its path.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    ends : (p,) array of int
    paths : list of p lists of (3,) arrays of float
        Positions of the new nodes; an empty path adds nothing.
    """
    positions = [np.array(path).reshape(-1, 3) for path in paths]
    radii = surface.distance(np.concatenate([np.empty((0, 3)), *positions]))
    node_of_vertex, first = np.array(skeleton.node_of_vertex), len(skeleton.nodes)
    order = np.argsort(node_of_vertex, kind="stable")
    begin, stop = (np.searchsorted(node_of_vertex, ends, side, sorter=order) for side in ("left", "right"))
    for row, (end, new) in enumerate(zip(ends, positions, strict=True)):
        if len(new) == 0:
            continue
        is_mapped = order[begin[row] : stop[row]]
        is_mapped = is_mapped[node_of_vertex[is_mapped] == end]  # another path may have begun at the same node
        chain = np.concatenate([[end], first + np.arange(len(new))])
        candidates = np.concatenate([skeleton.nodes[[end]], new])
        distances = np.linalg.norm(surface.mesh.vertices[is_mapped][:, None, :] - candidates, axis=2)
        node_of_vertex[is_mapped] = chain[np.argmin(distances, axis=1)]
        first += len(new)
    extended = append_paths(skeleton, ends.tolist(), positions, radii)
    return replace(extended, node_of_vertex=node_of_vertex)
