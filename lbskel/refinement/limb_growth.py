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

__all__ = ["grow_limbs"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.level_sets import (
    LEVEL_SPACING,
    MAX_LEVELS,
    centered_axes,
    find_geodesic_caps,
    interior_axes,
)
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import extend_ends, trace_centerline
from lbskel.refinement.uncovered_limbs import Limbs, ball_distances, find_limbs
from lbskel.skeleton.skeleton import Skeleton


def grow_limbs(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb that has no tip near its end, or stands out of the skeleton's balls.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    mesh = surface.proxy.mesh
    on_proxy = replace(skeleton, node_of_vertex=surface.on_proxy(skeleton.node_of_vertex))
    balls, extrema = inscribed_radii(on_proxy, surface.proxy), find_extrema(mesh, deadline=surface.deadline)
    missed = extrema.take(is_missed(extrema, mesh, balls))
    return _with_branches(skeleton, surface, find_limbs(ball_distances(balls, mesh), missed))


def _with_branches(skeleton: Skeleton, surface: Surface, limbs: Limbs) -> Skeleton:
    """Grow a branch along the axis of each limb, and map the limb's vertices to it."""
    if len(limbs.ends) == 0:
        return skeleton
    mesh = surface.proxy.mesh
    axes = centered_axes(_axes(limbs, surface), limbs.radii, surface)
    chosen = [limb for limb, axis in enumerate(axes) if len(axis)]
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
