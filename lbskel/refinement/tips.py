"""Tips: every end branch carried on to one radius under the surface, which contraction had drawn it back from.

From its last node an end follows the axis ahead, put back to the centroid of the section at each step, until the
surface ahead is as near as the surface round it: there is the last inscribed ball. Where that is not at the end of the
limb that the last nodes stand for, they are put on the axis of the limb itself (:mod:`lbskel.refinement.level_sets`) and go on from it.
"""

from __future__ import annotations

__all__ = ["append_paths", "clip_to_interior", "extend_tips", "recenter_points", "tips_at_surface", "trace_centerline"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.level_sets import GeodesicCap, find_geodesic_caps
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.pruning import STANDS_OUT
from lbskel.skeleton.skeleton import Skeleton

STEP = 0.5  # of the local radius
MOST_STEPS = 60
STRAIGHT = 0.5  # cosine of the most that an end turns from where it set out
SLACK = 1.05  # the surface ahead counts as near as the surface around within this factor
FARTHEST = 2.0  # radii of the last ball within which the surface ahead is the end of a branch
REACHES = 2.5  # radii of a limb, and of the last ball, within which its end is reached
LIMB = 3.4  # length of a limb in radii; a flat spot has 2, a half ball 2.5, the rounded corner of a foot up to 3.3
DEEP = 0.5  # radii of a limb under the surface that its axis has to run: that of a strip of surface runs on it
ASTRAY = 2.0  # radii of a section by which an end outside the surface may lie beside it
WIDEST = 1.5  # an end goes no further where its section is wider by this factor than at the step before


def extend_tips(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Add nodes at the ends until each tip is the center of the last ball that fits.

    Parameters
    ----------
    skeleton : Skeleton
        Recentered; its end branches follow the axis of the shape.
    surface : Surface
    """
    ends = [b if skeleton.degrees[b[-1]] == 1 else b[::-1] for b in skeleton.branches]
    ends = [b for b in ends if skeleton.degrees[b[-1]] == 1]
    if len(skeleton.branches) == 1 and ends:  # one branch with two ends
        ends = [ends[0], ends[0][::-1]]
    ends = [b for b in ends if (skeleton.nodes[b[-1]] != skeleton.nodes[b[-4:][0]]).any()]
    if not ends:
        return skeleton
    ahead = _ahead(skeleton, surface, ends)
    last = np.array([b[-1] for b in ends])
    skeleton = _ends_centered(skeleton, surface, ends, ahead)
    paths = trace_centerline(surface, skeleton.nodes[last], ahead)
    tips = np.array([path[-1] if path else skeleton.nodes[end] for end, path in zip(last, paths, strict=True)])
    missed = _missed_limbs(skeleton, surface, ends, tips)
    if not missed:
        return append_paths(skeleton, surface, last, paths)
    axes = recenter_points([axis for _, axis in missed.values()], surface)
    onward = trace_centerline(
        surface, np.array([axis[-1] for axis in axes]), np.array([axis[-1] - axis[-2] for axis in axes])
    )
    target, nodes = np.arange(len(skeleton.nodes)), np.array(skeleton.nodes)
    for (end, (n, _)), axis, path in zip(missed.items(), axes, onward, strict=True):
        target[ends[end][-n:]] = last[end]
        nodes[last[end]] = axis[0]
        paths[end] = [*axis[1:], *path]
    last = np.searchsorted(np.unique(target), last)
    return append_paths(contract_nodes(replace(skeleton, nodes=nodes), target), surface, last, paths)


def _ahead(skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]]) -> NDArray[np.float64]:
    """(e, 3) unit directions in which end branches lead; towards what it stands for, where a tip is at its junction."""
    along = np.array([skeleton.nodes[end[-1]] - skeleton.nodes[end[-4:][0]] for end in ends])
    first = skeleton.nodes[[end[0] for end in ends]]
    off = np.linalg.norm(skeleton.nodes[[end[-1] for end in ends]] - first, axis=1)
    for row in np.flatnonzero(off < STANDS_OUT * surface.distance(first)).tolist():
        mine = np.isin(skeleton.node_of_vertex, ends[row][1:])
        towards = surface.mesh.vertices[mine].sum(axis=0) - np.count_nonzero(mine) * first[row]
        along[row] = towards if towards.any() else along[row]
    return along / np.linalg.norm(along, axis=1, keepdims=True)


def _ends_centered(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], ahead: NDArray[np.float64]
) -> Skeleton:
    """The skeleton with its tips at the centroids of the sections there, where those are about them and not far off."""
    nodes, first, last = np.array(skeleton.nodes), [end[0] for end in ends], [end[-1] for end in ends]
    section = cross_sections(surface.mesh, nodes[last], ahead)
    shift, length = (np.linalg.norm(nodes[last] - there, axis=1) for there in (section.centroids, nodes[first]))
    is_own = section.surrounds & (shift <= section.radii)
    is_own |= section.is_cut & ~surface.contains(nodes[last]) & (shift <= ASTRAY * section.radii)
    is_own &= (shift <= length) & surface.contains(section.centroids)
    nodes[np.array(last)[is_own]] = section.centroids[is_own]
    return replace(skeleton, nodes=nodes)


def tips_at_surface(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Carry every tip on to the surface: straight ahead, or where that is far to the nearest place.

    Parameters
    ----------
    skeleton : Skeleton
        With its tips at the centers of the last balls.
    surface : Surface
    """
    tips = skeleton.tips
    if len(tips) == 0:
        return skeleton
    P = skeleton.nodes[tips]
    directions = P - skeleton.nodes[[int(skeleton.neighbors[tip][0]) for tip in tips]]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ahead, (radii, nearest) = surface.ray_distance(P, directions), surface.closest(P)
    goes_on = ahead < FARTHEST * radii
    ends = np.where(goes_on[:, None], P + np.where(goes_on, ahead, 0)[:, None] * directions, nearest)
    return append_paths(skeleton, surface, tips, [[end] for end in ends])


def _missed_limbs(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], tips: NDArray[np.float64]
) -> dict[int, tuple[int, NDArray[np.float64]]]:
    """For each branch whose tip is not at the end of its limb, how many nodes to leave for the limb's axis, and that.

    One, two, four and so on of its last nodes may stand for the limb, up to all. Of what is a limb that counts which
    leads from the junction to its end with the least detour.
    """
    radii = surface.distance(tips)
    n_tried = dict.fromkeys(range(len(ends)), 1)
    best: dict[int, tuple[float, int, NDArray[np.float64]]] = {}
    while n_tried:
        piece = np.full(len(skeleton.nodes), -1)
        for index, n in n_tried.items():
            piece[ends[index][-n:]] = index
        limbs = find_geodesic_caps(surface.proxy.mesh, surface.on_proxy(piece[skeleton.node_of_vertex]))
        trying, n_tried = n_tried, {}
        for index, n in trying.items():
            way, limb = ends[index], limbs.get(index)
            if limb is not None:
                if np.linalg.norm(limb.end - tips[index]) <= REACHES * max(limb.radius, radii[index]):
                    continue
                axis = clip_to_interior(limb, surface) if limb.length > LIMB * limb.radius else np.empty((0, 3))
                if len(axis) >= 2:
                    detour = _detour(np.concatenate([skeleton.nodes[way[:-n]], axis, limb.end[None]]))
                    best[index] = min(best.get(index, (np.inf, n, axis)), (detour, n, axis), key=lambda one: one[0])
            if n < len(way) - 1:
                n_tried[index] = min(2 * n, len(way) - 1)
    return {index: (n, axis) for index, (_, n, axis) in best.items()}


def clip_to_interior(limb: GeodesicCap, surface: Surface) -> NDArray[np.float64]:
    """The axis of a limb, as far as it is inside from its end on; none of what has no thickness."""
    axis = limb.axis
    if len(axis) == 0 or np.median(surface.distance(axis)) < DEEP * limb.radius:
        return np.empty((0, 3))
    outer = np.flatnonzero(~surface.contains(axis))
    return axis[outer[-1] + 1 :] if len(outer) else axis


def _detour(way: NDArray[np.float64]) -> float:
    """How many times longer a way is than straight."""
    straight = float(np.linalg.norm(way[-1] - way[0]))
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()) / max(straight, 1e-300)


def recenter_points(axes: list[NDArray[np.float64]], surface: Surface) -> list[NDArray[np.float64]]:
    """SectionCenters put to the centroids of their own sections, without the points that have none if at least two are left."""
    P = np.concatenate(axes)
    T = np.concatenate([np.gradient(axis, axis=0) for axis in axes])
    section = cross_sections(surface.mesh, P, T / np.linalg.norm(T, axis=1, keepdims=True))
    parts = np.cumsum([len(axis) for axis in axes])[:-1]
    usual = np.concatenate([np.full(len(radii), np.median(radii)) for radii in np.split(section.radii, parts)])
    is_own = section.surrounds & (np.linalg.norm(section.centroids - P, axis=1) <= section.radii)
    is_own &= (section.radii <= WIDEST * usual) & surface.contains(section.centroids)
    own = zip(np.split(section.centroids, parts), np.split(is_own, parts), strict=True)
    return [C[known] if known.sum() >= 2 else axis for axis, (C, known) in zip(axes, own, strict=True)]


def trace_centerline(
    surface: Surface, starts: NDArray[np.float64], directions: NDArray[np.float64]
) -> list[list[NDArray[np.float64]]]:
    """For each end, the points on its way to its tip, all ends at once."""
    P = np.array(starts)
    T = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    first = np.array(T)
    paths: list[list[NDArray[np.float64]]] = [[] for _ in P]
    section = cross_sections(surface.mesh, P, T)
    width, radii = section.radii, _hydraulic_radii(section)
    active = np.arange(len(P))
    for _ in range(MOST_STEPS):
        radius = radii[active]
        ahead = surface.ray_distance(P[active], T[active])
        is_straight = np.einsum("ki,ki->k", T[active], first[active]) > STRAIGHT
        goes_on = is_straight & np.isfinite(ahead) & (ahead > SLACK * radius) & (radius > 0)
        active, radius, ahead = active[goes_on], radius[goes_on], ahead[goes_on]
        if len(active) == 0:
            break
        step = np.minimum(STEP * radius, ahead - radius)
        forward = P[active] + step[:, None] * T[active]
        section = cross_sections(surface.mesh, forward, T[active])
        is_own = section.surrounds & (section.radii < WIDEST * width[active]) & surface.contains(section.centroids)
        active, moved, step = active[is_own], section.centroids[is_own], step[is_own]
        width[active], radii[active] = section.radii[is_own], _hydraulic_radii(section)[is_own]
        turned = T[active] + (moved - P[active]) / step[:, None]
        T[active] = turned / np.linalg.norm(turned, axis=1, keepdims=True)
        P[active] = moved
        for end, point in zip(active, moved, strict=True):
            paths[end].append(point)
    return paths


def _hydraulic_radii(sections: Sections) -> NDArray[np.float64]:
    """Twice the area over the length of each curve: the radius of a circle, and of a flat section about its thickness.

    It averages over the curve, so that noise does not make it small as it does the distance to the nearest point.
    """
    return np.divide(
        2 * sections.areas, sections.lengths, out=np.zeros(len(sections.areas)), where=sections.lengths > 0
    )


def append_paths(
    skeleton: Skeleton, surface: Surface, last: NDArray[np.int64], paths: list[list[NDArray[np.float64]]]
) -> Skeleton:
    """The skeleton with a chain of new nodes at each end; the end's vertices go to the nearest along the chain."""
    nodes, edges, node_of_vertex = [skeleton.nodes], [skeleton.edges], np.array(skeleton.node_of_vertex)
    n_nodes = len(skeleton.nodes)
    for end, path in zip(last, paths, strict=True):
        if not path:
            continue
        new = n_nodes + np.arange(len(path))
        chain = np.concatenate([[end], new])
        nodes.append(np.array(path))
        edges.append(np.stack([chain[:-1], chain[1:]], axis=1))
        n_nodes += len(path)
        mine = np.flatnonzero(node_of_vertex == end)
        places = np.concatenate([skeleton.nodes[[end]], np.array(path)])
        apart = np.linalg.norm(surface.mesh.vertices[mine][:, None, :] - places, axis=2)
        node_of_vertex[mine] = chain[np.argmin(apart, axis=1)]
    P = np.concatenate(nodes)
    radii = np.concatenate([skeleton.radii, surface.distance(P[len(skeleton.nodes) :])])
    return replace(
        skeleton,
        nodes=P,
        edges=np.concatenate(edges),
        radii=radii,
        mean_radii=np.empty(0),
        node_of_vertex=node_of_vertex,
    )
