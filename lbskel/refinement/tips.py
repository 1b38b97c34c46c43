"""Tips: every end branch ends one radius below the surface, from where contraction had pulled it back or left it.

From its last node an end follows the centerline in steps of a local radius, each corrected to the centroid of the
cross-section there, until the surface ahead is as near as the surface around it: there is the last inscribed ball. In a
flat end contraction may leave the last node beyond that; it goes back along its branch.
"""

from __future__ import annotations

__all__ = ["extend_ends", "extend_tips", "trace_centerline"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.editing import append_paths, contract_nodes
from lbskel.skeleton.skeleton import Skeleton

# The numbers are guesses where nothing else is said
# Lower bound on a step along a centerline, in radii at its start, so that a needle takes no more steps than a cone;
# where the last inscribed ball is nearer, the end has reached it. Rows "shortest step of" in
# benchmarks/results/refinement.md: alike from 0.02 to 0.125; by hand, with 0.125 more ends are crooked
MIN_STEP = 0.05
MAX_STEPS = 60  # per end, which bounds the time
TINY = float(np.finfo(np.float64).tiny)


def extend_tips(skeleton: Skeleton, surface: Surface, tips: NDArray[np.int64] | None = None) -> Skeleton:
    """Extend or shorten end branches until their tips are the centers of the last inscribed balls.

    Parameters
    ----------
    skeleton : Skeleton
        Centered, so that its end branches follow the centerlines.
    surface : Surface
    tips : (t,) array of int, optional
        Those that are extended or shortened, all by default.
    """
    is_extended = np.isin(np.arange(len(skeleton.nodes)), skeleton.tips if tips is None else tips)
    ends = [way for branch in skeleton.branches for way in (branch, branch[::-1]) if is_extended[way[-1]]]
    ends = [b for b in ends if (skeleton.nodes[b[-1]] != skeleton.nodes[b[-4:][0]]).any()]
    if not ends:
        return skeleton
    directions = np.array([skeleton.nodes[end[-1]] - skeleton.nodes[end[-4:][0]] for end in ends])
    directions /= vector_lengths(directions)[:, None]
    sections = _sections_of_tips(skeleton, surface, ends, directions)
    skeleton = _with_centered_ends(skeleton, surface, ends, sections)
    skeleton, last = _with_shortened_ends(skeleton, surface, ends, directions, sections)
    return extend_ends(skeleton, surface, last, trace_centerline(surface, skeleton.nodes[last], directions))


def _sections_of_tips(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], directions: NDArray[np.float64]
) -> Sections:
    """Cut the surface across each end at its tip."""
    tips = skeleton.nodes[[end[-1] for end in ends]]
    return cross_sections(surface.mesh, tips, directions, deadline=surface.deadline)


def _with_centered_ends(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], section: Sections
) -> Skeleton:
    """Move the tips to the centroids of their cross-sections, where the sections surround the tips."""
    nodes, first, last = np.array(skeleton.nodes), [end[0] for end in ends], [end[-1] for end in ends]
    offset, length = (vector_lengths(nodes[last] - other) for other in (section.centroids, nodes[first]))
    is_own = section.surrounds & (offset <= section.radii)
    is_own &= offset <= length
    is_own[is_own] = surface.contains(section.centroids[is_own])
    nodes[np.array(last)[is_own]] = section.centroids[is_own]
    return replace(skeleton, nodes=nodes)


def _with_shortened_ends(
    skeleton: Skeleton,
    surface: Surface,
    ends: list[NDArray[np.int64]],
    directions: NDArray[np.float64],
    section: Sections,
) -> tuple[Skeleton, NDArray[np.int64]]:
    """Move tips back from a surface ahead that is nearer than that around them; return (e,) their numbers, too.

    Nodes that they pass are contracted into them. A tip passes no junction, and of two tips of a branch none goes
    beyond its middle.
    """
    last = np.array([end[-1] for end in ends])
    degrees = skeleton.degrees  # the first node of a short branch may be its other tip, as shallow as this
    before = [end[-4:][0] if degrees[end[-4:][0]] > 1 else end[len(end) // 2] for end in ends]
    inner = surface.distance(skeleton.nodes[before])
    radii = np.minimum(_hydraulic_radii(section), inner)  # of a flat section, half its thickness
    excess = np.where(section.surrounds, radii - surface.ray_distance(skeleton.nodes[last], directions), 0.0)
    nodes, target = np.array(skeleton.nodes), np.arange(len(skeleton.nodes))
    for row in np.flatnonzero(excess > MIN_STEP * radii).tolist():
        way = ends[row][::-1]
        points = skeleton.nodes[way]
        lengths = np.append(0.0, np.cumsum(vector_lengths(np.diff(points, axis=0))))
        if excess[row] < lengths[-1] / (1 if skeleton.degrees[way[-1]] > 1 else 2):
            nodes[way[0]] = [np.interp(excess[row], lengths, column) for column in points.T]
            target[way[1 : np.searchsorted(lengths, excess[row])]] = way[0]
    shortened = contract_nodes(replace(skeleton, nodes=nodes), target)
    return shortened, np.searchsorted(np.unique(target), last)


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
    T = directions / vector_lengths(directions)[:, None]
    first = np.array(T)
    paths: list[list[NDArray[np.float64]]] = [[] for _ in P]
    section = cross_sections(surface.mesh, P, T, deadline=surface.deadline)
    radii = _hydraulic_radii(section)
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
        section = cross_sections(surface.mesh, forward, T[active], deadline=surface.deadline)
        is_own = section.surrounds & (vector_lengths(section.centroids - forward) <= step)
        is_own[is_own] = surface.contains(section.centroids[is_own])
        active, moved = active[is_own], section.centroids[is_own]
        radii[active] = _hydraulic_radii(section)[is_own]
        T[active] = (moved - P[active]) / vector_lengths(moved - P[active])[:, None]
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
    order = stable_order(node_of_vertex)
    begin, stop = (np.searchsorted(node_of_vertex, ends, side, sorter=order) for side in ("left", "right"))
    for row, (end, new) in enumerate(zip(ends, positions, strict=True)):
        if len(new) == 0:
            continue
        is_mapped = order[begin[row] : stop[row]]
        is_mapped = is_mapped[node_of_vertex[is_mapped] == end]  # another path may have begun at the same node
        chain = np.concatenate([[end], first + np.arange(len(new))])
        candidates = np.concatenate([skeleton.nodes[[end]], new])
        distances = vector_lengths(surface.mesh.vertices[is_mapped][:, None, :] - candidates)
        node_of_vertex[is_mapped] = chain[np.argmin(distances, axis=1)]
        first += len(new)
    extended = append_paths(skeleton, ends.tolist(), positions, radii)
    return replace(extended, node_of_vertex=node_of_vertex)
