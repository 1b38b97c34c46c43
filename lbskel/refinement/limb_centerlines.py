"""Centerlines of limbs: the centroids of rings around each limb, all points of which are equally far from its end.

The end of a limb is the vertex farthest from its rim, along the edges of the surface: in a limb that bends, the vertex
farthest from the body may be at the bend. The rings are level sets of the distance from that end along the edges. The
limb goes on, beyond its rim too, as long as its rings grow by less than they would in a wide cone. Its centerline
ends at the center of its cap: where it is as far from the end, along the centroids, as the rings are thick.

Lazarus and Verroust 1999, "Level set diagrams of polyhedral objects", https://doi.org/10.1145/304012.304025, join such
centroids to skeletons.
"""

from __future__ import annotations

__all__ = ["trace_limbs"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from lbskel._kernels.traversal import sums_along_paths
from lbskel.geometry.graphs import positive_edge_lengths, weighted_graph
from lbskel.geometry.level_segments import level_segments
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import distinct, first_in_groups
from lbskel.refinement.uncovered_limbs import Limbs

# Distance of the rings, in radii of the limb: about that of the nodes of the skeleton. Rows "distance of rings" in
# benchmarks/results/limbs.md: 0.25 to 1 are alike
SPACING = 0.5
# Upper bound on the growth of the radius of a ring by its distance from the one before, below the cap: half of that on
# a flat surface, and that of a cone with an angle of 30 degrees between axis and side. Rows "growth of rings" in the
# same table: 0.3 to 0.7 are alike
MAX_GROWTH = 0.5
MAX_RINGS = 64  # of a limb, which bounds the time; a guess
TINY = float(np.finfo(np.float64).tiny)


def trace_limbs(mesh: Mesh, limbs: Limbs) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Trace the centerline of each of u limbs, from the body to the center of its cap.

    Parameters
    ----------
    mesh : Mesh
    limbs : Limbs
        At least one.

    Returns
    -------
    list of u pairs
        The (k, 3) points, and the (k,) radii of circles as long as the rings around them; k is 0 for a limb that has no
        ring as far from its end as it is thick.
    """
    ends, distances, limb_of_vertex, reaches = _distances_from_ends(mesh, limbs)
    n_rings = np.ceil(reaches / np.maximum(SPACING * limbs.radii, TINY)).clip(0, MAX_RINGS).astype(np.int64)
    centers, radii = _rings(mesh, limb_of_vertex, distances, reaches, n_rings)
    max_growths = MAX_GROWTH * reaches / np.maximum(n_rings, 1)
    return _from_caps(mesh.vertices[ends], centers, radii, np.append(0, np.cumsum(n_rings)), max_growths)


def _from_caps(
    ends: NDArray[np.float64],
    centers: NDArray[np.float64],
    radii: NDArray[np.float64],
    begins: NDArray[np.int64],
    max_growths: NDArray[np.float64],
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Take the rings of each limb from the body to the center of its cap; the first is the nearest to the end."""
    rings, limb = np.column_stack([centers, radii]), np.repeat(np.arange(len(ends)), np.diff(begins))
    before = np.roll(rings, 1, axis=0)
    is_first = np.append(True, limb[1:] != limb[:-1])[: len(limb)]
    before[is_first] = np.column_stack([ends, np.zeros(len(ends))])[limb[is_first]]
    steps = vector_lengths(rings[:, :3] - before[:, :3])
    depths = sums_along_paths(steps, begins) + steps[begins[limb]] - radii
    firsts = first_in_groups(depths > 0, begins)  # below the cap
    is_body = (np.arange(len(limb)) >= firsts[limb]) & (radii - before[:, 3] > max_growths[limb])
    stops = first_in_groups(is_body, begins)
    is_between = (begins[:-1] < firsts) & (firsts < stops)  # the center of the cap is between two rings
    below, above = firsts[is_between], firsts[is_between] - 1
    share = depths[below] / (depths[below] - depths[above])
    rings[above] = rings[below] + share[:, None] * (rings[above] - rings[below])
    lines = [rings[first:stop][::-1] for first, stop in zip(firsts - is_between, stops, strict=True)]
    return [(line[:, :3], line[:, 3]) for line in lines]


def _distances_from_ends(
    mesh: Mesh, limbs: Limbs
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Find the end of each limb, the distance of each vertex from the nearest end, whose it is, and how far it counts.

    The distances of a limb count up to its farthest vertex, and up to the nearest vertex beside those of another limb.
    """
    limb, lengths = limbs.limb_of_vertex, positive_edge_lengths(mesh)
    i, j = mesh.edges.T
    is_inner = (limb[i] == limb[j]) & (limb[i] >= 0)
    rim = distinct(mesh.edges[~is_inner].ravel())
    within = weighted_graph(mesh.edges[is_inner], lengths[is_inner], len(limb))
    depths = dijkstra(within, directed=False, indices=rim[limb[rim] >= 0], min_only=True)
    inner = np.flatnonzero(limb >= 0)
    ascending = inner[np.argsort(depths[inner], kind="stable")]
    ends = np.array(limbs.ends)
    ends[limb[ascending]] = ascending  # the last assignment counts
    whole = weighted_graph(mesh.edges, lengths, len(limb))
    distances, _, sources = dijkstra(whole, directed=False, indices=ends, min_only=True, return_predecessors=True)
    limb_of_end = np.full(len(limb) + 1, -1)  # the last is for vertices that no end reaches
    limb_of_end[ends] = np.arange(len(ends))
    nearest = limb_of_end[np.where(sources >= 0, sources, -1)]
    reaches, own = np.zeros(len(ends)), inner[nearest[inner] == limb[inner]]
    np.maximum.at(reaches, limb[own], distances[own])
    beside = mesh.edges[(nearest[i] != nearest[j]) & (nearest[i] >= 0) & (nearest[j] >= 0)]
    np.minimum.at(reaches, nearest[beside], distances[beside])
    return ends, distances, nearest, reaches


def _rings(
    mesh: Mesh,
    limb_of_vertex: NDArray[np.int64],
    distances: NDArray[np.float64],
    reaches: NDArray[np.float64],
    n_rings: NDArray[np.int64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(r, 3) centroids of the rings of all limbs, from their ends on, and (r,) radii of circles as long."""
    limb = limb_of_vertex[mesh.faces]
    is_inner = (limb[:, 0] >= 0) & (limb == limb[:, :1]).all(axis=1) & (n_rings[limb[:, 0]] > 0)
    corners, limb = mesh.faces[is_inner], limb[is_inner, 0]
    # rings have whole numbers; the last is half a step before the rim, which may be a level set itself
    numbers = distances[corners] * (n_rings / np.maximum(reaches, TINY))[limb, None] + 0.5
    beyond = n_rings[limb] + 1
    first, last = (np.ceil(np.minimum(each, beyond)).astype(np.int64) for each in (numbers.min(1), numbers.max(1)))
    first, last = np.maximum(first, 1), np.minimum(last, beyond)
    counts = np.maximum(last - first, 0)
    face = np.repeat(np.arange(len(corners)), counts)
    ring = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts) + first[face]
    segments = level_segments(mesh.vertices, corners[face].T, numbers[face].T - ring)
    lengths = vector_lengths(segments.stops - segments.starts)
    row, r = (np.cumsum(n_rings) - n_rings)[limb[face]] + ring - 1, int(n_rings.sum())
    totals = np.bincount(row, lengths, r)
    moments = np.stack([np.bincount(row, x * lengths, r) for x in (segments.starts + segments.stops).T / 2], axis=1)
    return moments / np.maximum(totals, TINY)[:, None], totals / (2 * np.pi)
