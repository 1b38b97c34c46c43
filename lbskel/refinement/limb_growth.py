"""Growth of limbs: a branch is grown along every limb that contraction has left without one.

A limb that is short, or thin relative to the contracted faces, may be pulled into the body before it becomes a line.
Its end is an extremum of the geodesic distance to which no tip is near (:mod:`lbskel.refinement.extrema`): so the short
ends of thick bodies are found. Or the limb stands out of the skeleton's balls
(:mod:`lbskel.refinement.uncovered_limbs`): so limbs too short for the extrema are found. The limb's axis comes from the
distance to its end (:mod:`lbskel.refinement.level_sets`) or, if that has no part inside, is the segment from the
skeleton to its end. The points of the axis are moved to the centroids of their cross-sections. Of the nodes of the limb
and of those beside it, the branch begins at the one nearest to the last point of the axis that is within a radius of
such a node or, if there is none, to the first point.
"""

from __future__ import annotations

__all__ = ["grow_missing_branches", "grow_uncovered_limbs"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.level_sets import (
    LEVEL_SPACING,
    MAX_LEVELS,
    MIN_DEPTH,
    centered_axes,
    find_geodesic_caps,
    interior_axes,
)
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import extend_ends, trace_centerline
from lbskel.refinement.uncovered_limbs import Limbs, ball_distances, find_uncovered_limbs
from lbskel.skeleton.skeleton import Skeleton

# Lower bounds on the reach and the elongation of a limb (lbskel.refinement.uncovered_limbs). A short limb of a thick
# body, such as a tail, does not reach far out of 1.75 radii of it, but is longer than wide beyond 1.25 of them.
# "Bounds on limbs that are grown" in benchmarks/results/neurons.md
LIMB_BOUNDS = ((1.75, 1.5), (1.25, 2.5))


def grow_missing_branches(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb whose end is outside the skeleton's balls and has no tip near it.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    mesh, balls = surface.proxy.mesh, inscribed_radii(skeleton, surface.proxy)
    extrema = find_extrema(mesh, deadline=surface.deadline)
    missed = np.flatnonzero(is_missed(extrema, mesh, balls))
    limb_of_extremum = np.full(len(extrema.vertices) + 1, -1)  # the last is for vertices without an extremum
    limb_of_extremum[missed] = np.arange(len(missed))
    ends = extrema.vertices[missed]
    nearest = cKDTree(balls.nodes).query(mesh.vertices[ends])[1]
    limbs = Limbs(
        ends,
        balls.nodes[nearest],
        balls.radii[nearest],
        extrema.radii[missed],
        np.zeros(len(ends)),
        limb_of_extremum[extrema.limb_of_vertex],
    )
    return _with_branches(skeleton, surface, limbs, min_depth=MIN_DEPTH)


def grow_uncovered_limbs(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb that stands out of the skeleton's balls.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    on_proxy = replace(skeleton, node_of_vertex=surface.on_proxy(skeleton.node_of_vertex))
    balls = ball_distances(inscribed_radii(on_proxy, surface.proxy), surface.proxy.mesh)
    return _with_branches(skeleton, surface, find_uncovered_limbs(balls, LIMB_BOUNDS))


def _with_branches(skeleton: Skeleton, surface: Surface, limbs: Limbs, *, min_depth: float = 0.0) -> Skeleton:
    """Grow a branch along the axis of each limb, and map the limb's vertices to it.

    An axis must have a median depth below the surface of ``min_depth`` radii of its limb.
    """
    if len(limbs.ends) == 0:
        return skeleton
    mesh = surface.proxy.mesh
    axes, widths = centered_axes(_axes(limbs, surface), limbs.radii, surface)
    axes = _deep_axes(axes, min_depth * limbs.radii, surface)
    reaches = [reach * width[: len(axis)] for reach, width, axis in zip(limbs.min_reaches, widths, axes, strict=True)]
    chosen = _not_covered(mesh.vertices[limbs.ends], axes, reaches)
    if not chosen:
        return skeleton
    lasts = np.array([axes[limb][-1] for limb in chosen])
    outward = np.array([axes[limb][-1] - axes[limb][-2:][0] for limb in chosen])
    is_single = ~outward.any(axis=1)
    outward[is_single] = (mesh.vertices[limbs.ends[chosen]] - lasts)[is_single]
    onward = trace_centerline(surface, lasts, outward)
    nearby = _nodes_near_limbs(surface.on_proxy(skeleton.node_of_vertex), limbs.limb_of_vertex, mesh)
    base_of_limb = np.full(len(limbs.ends), -1)
    paths: list[list[NDArray[np.float64]]] = []
    for limb, continuation in zip(chosen, onward, strict=True):
        path, candidates = np.array([*axes[limb], *continuation]), nearby[limb]
        distances = cdist(path, skeleton.nodes[candidates])
        touching = np.flatnonzero(distances.min(axis=1) <= limbs.radii[limb])
        first = touching[-1] + 1 if len(touching) else 0
        if first < len(path):
            base_of_limb[limb] = candidates[distances[max(first - 1, 0)].argmin()]
            paths.append(list(path[first:]))
    bases = np.append(base_of_limb, -1)[surface.from_proxy(limbs.limb_of_vertex)]  # the last is for vertices of no limb
    skeleton = replace(skeleton, node_of_vertex=np.where(bases < 0, skeleton.node_of_vertex, bases))
    return extend_ends(skeleton, surface, base_of_limb[base_of_limb >= 0], paths)


def _axes(limbs: Limbs, surface: Surface) -> list[NDArray[np.float64]]:
    """Compute points along the axis of each limb, up to the center of its cap; straight ones begin near the ball."""
    mesh = surface.proxy.mesh
    caps = find_geodesic_caps(mesh, limbs.limb_of_vertex)
    clipped = dict(zip(caps, interior_axes(list(caps.values()), surface), strict=True))
    axes = []
    for limb, end in enumerate(mesh.vertices[limbs.ends]):
        axis = clipped.get(limb, np.empty((0, 3)))
        if len(axis) < 2:
            distance = float(np.linalg.norm(end - limbs.bases[limb]))
            last = distance - limbs.radii[limb]
            step = LEVEL_SPACING * limbs.radii[limb]
            first = min(limbs.base_radii[limb], last - step)
            n_points = 2 + int(min((last - first) / step, MAX_LEVELS))
            shares = np.linspace(first, last, n_points)[:, None] / distance
            axis = (1 - shares) * limbs.bases[limb] + shares * end
        axes.append(axis)
    return axes


def _deep_axes(
    axes: list[NDArray[np.float64]], min_depths: NDArray[np.float64], surface: Surface
) -> list[NDArray[np.float64]]:
    """Drop the points of the axes whose median depth is below a bound, such as those of sheets."""
    points, cuts = np.concatenate(axes), np.cumsum([len(axis) for axis in axes])[:-1]
    depths = np.split(surface.distance(points), cuts)
    return [
        axis if len(axis) and np.median(depth) >= min_depth else axis[:0]
        for axis, depth, min_depth in zip(axes, depths, min_depths.tolist(), strict=True)
    ]


def _not_covered(
    ends: NDArray[np.float64], axes: list[NDArray[np.float64]], reaches: list[NDArray[np.float64]]
) -> list[int]:
    """Choose limbs in their order, without those whose end is within reach of the axis of one chosen before."""
    if not any(map(len, axes)):
        return []
    owner = np.repeat(np.arange(len(axes)), [len(axis) for axis in axes])
    covered_by: list[set[int]] = [set() for _ in ends]
    within = cKDTree(ends).query_ball_point(np.concatenate(axes), np.concatenate(reaches))
    for limb, covered in zip(owner.tolist(), within, strict=True):
        for other in covered:
            covered_by[other].add(limb)
    chosen: set[int] = set()
    for limb, axis in enumerate(axes):
        if len(axis) and not covered_by[limb] & chosen:
            chosen.add(limb)
    return sorted(chosen)


def _nodes_near_limbs(
    node_of_vertex: NDArray[np.int64], limb_of_vertex: NDArray[np.int64], mesh: Mesh
) -> dict[int, NDArray[np.int64]]:
    """For each limb, the nodes of its vertices and of those adjacent to them, in ascending order."""
    i, j = mesh.edges.T
    limbs = limb_of_vertex[np.concatenate([i, j, i, j])]
    nodes = node_of_vertex[np.concatenate([i, j, j, i])]
    pairs = np.unique(np.stack([limbs, nodes], axis=1)[limbs >= 0], axis=0)
    limbs, first = np.unique(pairs[:, 0], return_index=True)
    return dict(zip(limbs.tolist(), np.split(pairs[:, 1], first[1:]), strict=True))
