"""The centerline of a limb from the level sets of the geodesic distance to its end.

Contraction may pull a limb back to its base, where its centerline is lost. The vertices mapped to the end of a skeleton
are a patch of the surface; where that patch is a limb, the level sets of the distance from its end are closed curves
around it, and their centroids lie on its axis (Verroust, Lazarus 2000, "Extracting skeletal curves from 3D scattered
data", https://doi.org/10.1007/PL00007210).
"""

from __future__ import annotations

__all__ = ["GeodesicCap", "cap_axes", "centered_axes", "find_geodesic_caps", "interior_axes"]

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.graphs import edge_length_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order, unique_inverse
from lbskel.geometry.surface_queries import Surface

# Distance between level sets, or between points of a straight axis, in radii of the limb; it bounds time. Alike from
# 0.25 to 1 in benchmarks/results/constants.md, and from 0.25 to 2 in "Points on the straight axis" of neurons.md
LEVEL_SPACING = 0.5
MAX_LEVELS = 500  # per limb, which bounds the memory and time that hair-thin limbs take; a guess,
# benchmarks/results/constants.md
# Lower bound on the median depth of an axis below the surface, in radii of its limb; 0.16 where a limb is ten times as
# wide as thick. Rows "depth of an axis" in benchmarks/results/refinement.md: alike from 0 to 0.25, and with 0.5 ears
# and fingers are missed; by hand, with 0 one of three turned plates, 50 times as wide as thick, got a third tip
MIN_DEPTH = 0.1
CAP_LENGTH = np.pi / 2  # from the end of a round limb to the rim of its hemispherical cap along the surface, in radii
# Upper bounds on the distance of the centroid of a section from the axis, in radii of the section, and on the radius of
# the section, in radii of the limb: wider ones are those of the body. Rows in benchmarks/results/robustness.md: alike
# from 0.5 to 2 and from 1.25 to 4; without the second, 4 of 28 hard shapes get branches too many
MAX_OFFSET = 2.0
MAX_WIDENING = 2.0
# Distance in radii of a section within which a search decides on it: one beside the point is decided once four times
# its distance, at most MAX_OFFSET radii, and its length, that of a circle, have been searched (MAX_REACH of
# lbskel._kernels.cross_sections)
DECIDED_WITHIN = 4 * (MAX_OFFSET + 2 * np.pi)


@dataclass(frozen=True, eq=False)
class GeodesicCap:
    """The part of a patch of surface that is nearer to its end than its border is.

    Parameters
    ----------
    end : (3,) array of float
        The vertex farthest from the border.
    length : float
        Distance along edges from the end to the nearest vertex of the border.
    radius : float
        Radius of a round limb of this length and area.
    corners : (f, 3, 3) array of float
        Positions of the corners of its faces.
    edges : (f, 3) array of int
        The number of the edge from each corner to the next.
    distances : (f, 3) array of float
        Distance along edges from the end to each corner.
    """

    end: NDArray[np.float64]
    length: float
    radius: float
    corners: NDArray[np.float64]
    edges: NDArray[np.int64]
    distances: NDArray[np.float64]

    @cached_property
    def axis(self) -> NDArray[np.float64]:
        """(k, 3) centroids of the level sets of this cap, by :func:`cap_axes`."""
        return cap_axes([self])[0]


def cap_axes(caps: Sequence[GeodesicCap]) -> list[NDArray[np.float64]]:
    """(k, 3) centroids of the level sets of each cap, from its border to its hemispherical end.

    There are none if the cap is no longer than such an end. Of several curves at one level, the one whose centroid is
    nearest to that of the level before is used.

    Parameters
    ----------
    caps : sequence of GeodesicCap
    """
    axes: list[NDArray[np.float64]] = [np.empty((0, 3))] * len(caps)
    limbs = [number for number, cap in enumerate(caps) if 0 < CAP_LENGTH * cap.radius < cap.length]
    if not limbs:
        return axes
    begins, curves = _level_curves([caps[number] for number in limbs])
    for number, first, last in zip(limbs, begins, begins[1:], strict=False):
        level, centroids = curves[0][first:last], curves[1][first:last]
        if (level[1:] == level[:-1]).any():
            points = [caps[number].end]
            for candidates in np.split(centroids, np.flatnonzero(np.diff(level)) + 1):
                points.append(candidates[np.linalg.norm(candidates - points[-1], axis=1).argmin()])
            centroids = np.array(points[1:])
        axes[number] = centroids[::-1].reshape(-1, 3)
    return axes


def interior_axes(caps: Sequence[GeodesicCap], surface: Surface) -> list[NDArray[np.float64]]:
    """Clip the axis of each cap to the part next to its end that is inside the surface; a sheet has none.

    Parameters
    ----------
    caps : sequence of GeodesicCap
    surface : Surface
    """
    axes = cap_axes(caps)
    if not any(map(len, axes)):
        return axes
    points, cuts = np.concatenate(axes), np.cumsum([len(axis) for axis in axes])[:-1]
    depths, outside = np.split(surface.distance(points), cuts), np.split(~surface.contains(points), cuts)
    for row, (cap, axis) in enumerate(zip(caps, axes, strict=True)):
        if len(axis):
            is_sheet = np.median(depths[row]) < MIN_DEPTH * cap.radius
            first = np.flatnonzero(outside[row]).max(initial=-1) + 1
            axes[row] = axis[len(axis) if is_sheet else first :]
    return axes


def centered_axes(
    axes: list[NDArray[np.float64]], limb_radii: NDArray[np.float64], surface: Surface
) -> list[NDArray[np.float64]]:
    """Move the points of axes to the centroids of their cross-sections.

    Points are dropped whose section is far away, much wider than the limb, or has its centroid outside the surface.

    Parameters
    ----------
    axes : list of (k, 3) arrays of float
        At least one, each of at least two points.
    limb_radii : (l,) array of float
        The radius of the limb of each axis.
    surface : Surface
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
    own, points = (np.split(values, parts) for values in (is_own, sections.centroids))
    return [point[kept] for point, kept in zip(points, own, strict=True)]


def _levels(caps: Sequence[GeodesicCap]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Space the level sets of all caps: distances from the ends, and where those of each cap begin and end."""
    radii, lengths = np.array([[cap.radius, cap.length] for cap in caps]).T
    first = CAP_LENGTH * radii
    counts = 1 + np.minimum((lengths - first) / (LEVEL_SPACING * radii), MAX_LEVELS).astype(np.int64)
    begins = np.append(0, np.cumsum(counts))
    step = np.arange(begins[-1]) - np.repeat(begins[:-1], counts)
    return np.repeat((lengths - first) / counts, counts) * step + np.repeat(first, counts), begins


def _level_curves(caps: Sequence[GeodesicCap]) -> tuple[list[int], tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Compute where the curves of each cap begin and end, and the level and the centroid of each connected curve."""
    levels, begins = _levels(caps)
    corners, edges, distances = (
        np.concatenate([getattr(cap, name) for cap in caps]) for name in ("corners", "edges", "distances")
    )
    cap_of_face = np.repeat(np.arange(len(caps)), [len(cap.distances) for cap in caps])
    # the levels above the lowest corner of each face, up to its highest
    shift = 2 * float(levels.max(initial=1.0)) * np.arange(len(caps))  # so that the levels of all caps ascend
    ascending = levels + np.repeat(shift, np.diff(begins))
    bounds = [distances.min(axis=1), distances.max(axis=1)]
    lowest, highest = (
        _count_up_to(
            bound, np.searchsorted(ascending, bound + shift[cap_of_face], "right"), levels, begins, cap_of_face
        )
        for bound in bounds
    )
    n_crossed = highest - lowest
    face = np.repeat(np.arange(len(distances)), n_crossed)
    level = np.arange(len(face)) + np.repeat(lowest - np.cumsum(n_crossed) + n_crossed, n_crossed)
    is_above, heights = distances[face] >= levels[level, None], distances[face] - levels[level, None]
    is_cut = is_above != np.roll(is_above, -1, axis=1)  # two of the three edges of each face
    start, end = (corners[face][is_cut], np.roll(corners[face], -1, axis=1)[is_cut])
    low, high = heights[is_cut], np.roll(heights, -1, axis=1)[is_cut]
    points = (start + (low / (low - high))[:, None] * (end - start)).reshape(-1, 2, 3)
    segments = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    key = level[:, None] * (edges.max(initial=0) + 1) + edges[face][is_cut].reshape(-1, 2)
    crossings, ends = unique_inverse(key.ravel())
    ends = ends.reshape(-1, 2)
    _, curve = unique_inverse(component_roots(ends, np.zeros(len(crossings), dtype=np.int64))[ends[:, 0]])
    lengths = np.bincount(curve, segments)
    moments = np.stack([np.bincount(curve, axis * segments) for axis in points.mean(axis=1).T], axis=1)
    level_of_curve = np.zeros(len(lengths), dtype=np.int64)
    level_of_curve[curve] = level
    has_length = lengths > 0  # curves are numbered by their lowest crossing, and so by level
    level_of_curve, centroids = level_of_curve[has_length], moments[has_length] / lengths[has_length, None]
    return np.searchsorted(level_of_curve, begins).tolist(), (level_of_curve, centroids)


def _count_up_to(
    bounds: NDArray[np.float64],
    guesses: NDArray[np.int64],
    levels: NDArray[np.float64],
    begins: NDArray[np.int64],
    caps: NDArray[np.int64],
) -> NDArray[np.int64]:
    """(f,) the first level of its cap above each bound; a guess may be off by one because of rounding."""
    guesses = np.clip(guesses, begins[caps], begins[caps + 1])
    is_high = (guesses > begins[caps]) & (levels[guesses - 1] > bounds)
    guesses = guesses - is_high
    is_low = (guesses < begins[caps + 1]) & (levels[np.minimum(guesses, len(levels) - 1)] <= bounds)
    return np.asarray(guesses + is_low)


def find_geodesic_caps(mesh: Mesh, patch_of_vertex: NDArray[np.int64]) -> dict[int, GeodesicCap]:
    """Find the geodesic cap of each patch of a surface, by the number of the patch.

    Parameters
    ----------
    mesh : Mesh
    patch_of_vertex : (n,) array of int
        -1 for vertices of no patch. A patch without a border, or without inner vertices, has no cap.
    """
    V, patch, m = mesh.vertices, patch_of_vertex, len(mesh.faces)
    start, end = patch[mesh.edges].T
    border = np.unique(mesh.edges[start != end])
    border = border[patch[border] >= 0]
    if len(border) == 0:
        return {}
    graph = edge_length_graph(mesh, (start == end) & (start >= 0))
    depth = dijkstra(graph, directed=False, indices=border, min_only=True)
    inner = np.flatnonzero(np.isfinite(depth) & (depth > 0))
    inner = inner[np.lexsort((inner, -depth[inner]))]
    ends = inner[np.unique(patch[inner], return_index=True)[1]]
    if len(ends) == 0:
        return {}
    distances = dijkstra(graph, directed=False, indices=ends, min_only=True)
    face = np.flatnonzero(np.isfinite(distances[mesh.faces]).all(axis=1))
    patch_of_corner = patch[mesh.faces[face]]
    face = face[(patch_of_corner == patch_of_corner[:, :1]).all(axis=1)]
    lengths = np.full(int(patch.max()) + 1, np.inf)
    np.minimum.at(lengths, patch[border], distances[border])
    patch_of_face = patch[mesh.faces[face, 0]]
    is_near = distances[mesh.faces[face]].mean(axis=1) <= lengths[patch_of_face]
    face, patch_of_face = face[is_near], patch_of_face[is_near]
    order = stable_order(patch_of_face)
    face, cuts = face[order], np.searchsorted(patch_of_face[order], np.arange(len(lengths) + 1))
    areas, corners, of_corner = mesh.face_areas[face], V[mesh.faces[face]], distances[mesh.faces[face]]
    edges = np.stack([mesh.edge_of_half_edge[corner * m + face] for corner in (2, 0, 1)], axis=1)
    caps = {}
    for tip, number in zip(ends.tolist(), patch[ends].tolist(), strict=True):
        length, own = float(lengths[number]), slice(cuts[number], cuts[number + 1])
        radius = float(areas[own].sum()) / (2 * np.pi * length)
        caps[number] = GeodesicCap(V[tip], length, radius, corners[own], edges[own], of_corner[own])
    return caps
