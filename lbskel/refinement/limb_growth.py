"""Growth of limbs: a branch is grown along every limb that stands out of the skeleton's balls.

A limb that is short, or thin relative to the contracted faces, may be pulled into the body before it becomes a line. It
is found because the skeleton leaves it uncovered (:mod:`lbskel.refinement.uncovered_limbs`), even if it is too short
for the geodesic extrema of :mod:`lbskel.refinement.missing_branches`. The extrema in turn find the short ends of thick
bodies, which the skeleton's balls cover. The limb's axis comes from the distance to its end
(:mod:`lbskel.refinement.level_sets`) or, if the limb is too short for that, is the segment from the skeleton to its
end. The points of the axis are moved to the centroids of their cross-sections.
"""

from __future__ import annotations

__all__ = ["grow_uncovered_limbs"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.level_sets import find_geodesic_caps, interior_axes
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.region_map import nearest_balls
from lbskel.refinement.tips import extend_ends, trace_centerline
from lbskel.refinement.uncovered_limbs import UncoveredLimbs, ball_distances, find_uncovered_limbs
from lbskel.skeleton.skeleton import Skeleton

# Lower bounds on the reach and the elongation of a limb (lbskel.refinement.uncovered_limbs). A short limb of a thick
# body, such as a tail, does not reach far out of 1.75 radii of it, but is longer than wide beyond 1.25 of them.
# "Bounds on limbs that are grown" in benchmarks/results/neurons.md
LIMB_BOUNDS = ((1.75, 1.5), (1.25, 2.5))
# Distance between the points of a straight axis, in radii of the limb. A section is cut at each, so that it bounds the
# time; limbs found are the same from 0.25 to 2. "Points on the straight axis" in benchmarks/results/neurons.md
SPACING = 1.0
MAX_POINTS = 50  # of a straight axis, which bounds the time; a guess
MAX_OFFSET = 2.0  # of the centroid of a section from the axis, in radii of the section; a guess
MAX_WIDENING = 2.0  # of a section, in radii of the limb: wider ones are those of the body; a guess
# Distance in radii of a section within which a search decides on it: one beside the point is decided once four times
# its distance, at most MAX_OFFSET radii, and its length, that of a circle, have been searched (MAX_REACH of
# lbskel._kernels.cross_sections)
DECIDED_WITHIN = 4 * (MAX_OFFSET + 2 * np.pi)


def grow_uncovered_limbs(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb that stands out of the skeleton's balls.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    on_proxy = replace(skeleton, node_of_vertex=surface.on_proxy(skeleton.node_of_vertex))
    balls = ball_distances(inscribed_radii(on_proxy, surface.proxy), surface.proxy.mesh)
    limbs = find_uncovered_limbs(balls, LIMB_BOUNDS)
    if len(limbs.ends) == 0:
        return skeleton
    mesh = surface.proxy.mesh
    axes, widths = _centered(_axes(limbs, surface), limbs.radii, surface)
    reaches = [reach * width for reach, width in zip(limbs.min_reaches.tolist(), widths, strict=True)]
    grown = _not_covered(mesh.vertices[limbs.ends], axes, reaches)
    if not grown:
        return skeleton
    bases = np.zeros(len(limbs.ends), dtype=np.int64)
    bases[grown] = nearest_balls(skeleton, np.array([axes[limb][0] for limb in grown]))
    outward = [mesh.vertices[limbs.ends[limb]] - axes[limb][-1] for limb in grown]
    onward = trace_centerline(surface, np.array([axes[limb][-1] for limb in grown]), np.array(outward))
    paths = [[*axes[limb], *continuation] for limb, continuation in zip(grown, onward, strict=True)]
    limb_of_vertex, node_of_vertex = surface.from_proxy(limbs.limb_of_vertex), np.array(skeleton.node_of_vertex)
    is_on_limb = np.isin(limb_of_vertex, grown)
    node_of_vertex[is_on_limb] = bases[limb_of_vertex[is_on_limb]]
    return extend_ends(replace(skeleton, node_of_vertex=node_of_vertex), surface, bases[grown], paths)


def _axes(limbs: UncoveredLimbs, surface: Surface) -> list[NDArray[np.float64]]:
    """Compute points along the axis of each limb, from the border of the skeleton's ball to the center of its cap."""
    mesh = surface.proxy.mesh
    caps = find_geodesic_caps(mesh, limbs.limb_of_vertex)
    clipped = dict(zip(caps, interior_axes(list(caps.values()), surface), strict=True))
    axes = []
    for limb, end in enumerate(mesh.vertices[limbs.ends]):
        axis = clipped.get(limb, np.empty((0, 3)))
        if len(axis) < 2:
            distance = float(np.linalg.norm(end - limbs.bases[limb]))
            first, last = limbs.base_radii[limb], distance - limbs.radii[limb]
            n_points = int(np.clip(2 + (last - first) / (SPACING * limbs.radii[limb]), 2, MAX_POINTS))
            shares = np.linspace(first, last, n_points)[:, None] / distance
            axis = (1 - shares) * limbs.bases[limb] + shares * end
        axes.append(axis)
    return axes


def _centered(
    axes: list[NDArray[np.float64]], limb_radii: NDArray[np.float64], surface: Surface
) -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]:
    """Move the points of axes to the centroids of their cross-sections, whose mean radii are returned too.

    Points are dropped whose section is far away, much wider than the limb, or has its centroid outside the surface.
    """
    P = np.concatenate(axes)
    T = np.concatenate([np.gradient(axis, axis=0) for axis in axes])
    T /= np.linalg.norm(T, axis=1, keepdims=True)
    max_radii = MAX_WIDENING * np.repeat(limb_radii, [len(axis) for axis in axes])
    sections = cross_sections(surface.mesh, P, T, max_reaches=DECIDED_WITHIN * max_radii, deadline=surface.deadline)
    is_own = sections.is_cut & (np.linalg.norm(sections.centroids - P, axis=1) <= MAX_OFFSET * sections.radii)
    is_own &= sections.radii <= max_radii
    is_own &= surface.contains(sections.centroids)
    parts = np.cumsum([len(axis) for axis in axes])[:-1]
    own, points, widths = (np.split(values, parts) for values in (is_own, sections.centroids, sections.radii))
    return (
        [point[kept] for point, kept in zip(points, own, strict=True)],
        [width[kept] for width, kept in zip(widths, own, strict=True)],
    )


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
