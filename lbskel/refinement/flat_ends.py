"""Flat ends: the branches that contraction leaves in the corners of a flat part are no limbs.

A flat part contracts towards its medial surface, and this surface to a curve that forks where the end of the part is as
near as its sides. Two measures tell the branch of a corner from a limb: from the fork its surface does not reach far
beyond the half width of the part, neither along the part nor across it; and the line of sight from it to the other
branches of the fork stays inside, since no gap separates them.

Contraction may leave nodes outside a thin part, and the point one local radius below its corner may be there; they are
moved inside before both are measured.

The half width a >= b is that of the rectangle with the area A and the perimeter L of a cross-section: 4 (a + b) = L and
4 a b = A.
"""

from __future__ import annotations

__all__ = ["first_parts", "is_corner", "prune_flat_ends", "ways_from_nodes"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.sorting import distinct, first_in_groups, group_medians
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import N_SAMPLES, moved_inside
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.pruning import farthest_vertices
from lbskel.skeleton.skeleton import Skeleton

# Distance by which a line of sight may leave the surface, in lengths of the line. Rows "gap of" in
# benchmarks/results/refinement.md: from 0.04 on ends are missed; by hand, bent ribbons need 0.02
MAX_GAP = 0.02


def prune_flat_ends(skeleton: Skeleton, surface: Surface, *, min_branch_ratio: float) -> Skeleton:
    """Remove the end branches in the corners of flat parts; a fork that loses all of them ends at its junction.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    surface : Surface
        Of the mesh that ``node_of_vertex`` belongs to.
    min_branch_ratio : float
        An end branch is kept where its surface reaches farther than this many half widths from its junction, along
        the part or across it.
    """
    while ends := skeleton.end_branches:
        corners = np.flatnonzero(is_corner(skeleton, surface, ends, min_branch_ratio)).tolist()
        if not corners:
            break
        skeleton = contract_branches(skeleton, [ends[row] for row in corners])
    return skeleton


def is_corner(
    skeleton: Skeleton, surface: Surface, ends: list[NDArray[np.int64]], min_branch_ratio: float
) -> NDArray[np.bool_]:
    """(e,) whether each end branch is in a corner: short for its fork's half width, and in sight of its neighbors.

    Parameters
    ----------
    skeleton, surface, min_branch_ratio
        As for :func:`prune_flat_ends`.
    ends : list of (k,) arrays of int
        Some of the end branches, the junction first.
    """
    ways_from = ways_from_nodes(skeleton)
    pairs = [(row, way) for row, end in enumerate(ends) for way in ways_from[int(end[0])] if way[-1] != end[-1]]
    around, nodes = distinct(np.concatenate([way for _, way in pairs])), np.array(skeleton.nodes)
    nodes[around] = moved_inside(nodes[around], surface)
    junctions = np.array([end[0] for end in ends])
    farthest, reaches = farthest_vertices(replace(skeleton, nodes=nodes), surface.mesh, ends)
    entry, inward, _ = surface.inner_offset(farthest)
    depths = local_radii(surface.mesh, deadline=surface.deadline)[farthest]
    peaks = moved_inside(entry + depths[:, None] * inward, surface)
    owner = np.array([row for row, _ in pairs])
    ways = first_parts(nodes, [way for _, way in pairs], reaches[owner])
    last = np.array([way[-1] for way in ways])
    row_of_tip = np.full(len(nodes), -1)
    row_of_tip[[end[-1] for end in ends]] = np.arange(len(ends))
    is_facing_tip = (row_of_tip[last] >= 0)[:, None]
    points = np.where(is_facing_tip, peaks[row_of_tip[last]], nodes[last])
    starts = nodes[junctions[owner]]
    offsets = nodes[last] - starts
    cosines = np.einsum("ij,ij->i", offsets, peaks[owner] - starts) / np.maximum(vector_lengths(offsets), 1e-300)
    most_opposite = np.lexsort((cosines, owner))[np.searchsorted(owner, np.arange(len(ends)))]
    opposite = [nodes[ways[pair]] for pair in most_opposite.tolist()]
    is_hidden = ~_sees(peaks[owner], points, surface)
    sees = np.bincount(owner, is_hidden, len(ends)) == 0
    if not sees.any():
        return np.zeros(len(ends), dtype=bool)
    half_widths = np.zeros(len(ends))
    half_widths[sees] = _half_widths([opposite[row] for row in np.flatnonzero(sees)], surface)
    ascending, widest = np.argsort(half_widths, kind="stable"), np.zeros(len(nodes), dtype=np.int64)
    widest[junctions[ascending]] = ascending  # the last assignment counts
    parts = widest[junctions]
    axes = np.array([opposite[row][0] - opposite[row][-1] for row in parts.tolist()])
    extents = _extents(surface.mesh.vertices[farthest] - nodes[junctions], axes)
    return np.asarray(sees & (extents <= min_branch_ratio * half_widths[parts]))


def _extents(offsets: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(e,) extent of each offset along its axis or across it, whichever is larger."""
    axes = axes / np.maximum(vector_lengths(axes)[:, None], 1e-300)
    along = np.einsum("ij,ij->i", offsets, axes)
    across = vector_lengths(offsets - along[:, None] * axes)
    return np.asarray(np.maximum(np.abs(along), across))


def ways_from_nodes(skeleton: Skeleton) -> dict[int, list[NDArray[np.int64]]]:
    """List the branches that leave each junction and each tip, a loop in both directions.

    Parameters
    ----------
    skeleton : Skeleton
    """
    ways: dict[int, list[NDArray[np.int64]]] = {}
    for branch in skeleton.branches:
        for way in (branch, branch[::-1]):
            ways.setdefault(int(way[0]), []).append(way)
    return ways


def first_parts(
    nodes: NDArray[np.float64], ways: list[NDArray[np.int64]], reaches: NDArray[np.float64]
) -> list[NDArray[np.int64]]:
    """Cut each path off after its first node that is at least a reach away from its start.

    Parameters
    ----------
    nodes : (k, 3) array of float
    ways : list of w arrays of int
        At least one, of two nodes or more.
    reaches : (w,) array of float
    """
    along, begins = np.concatenate(ways), np.cumsum([0, *map(len, ways)])
    way_of, firsts = np.repeat(np.arange(len(ways)), np.diff(begins)), begins[:-1]
    is_beyond = vector_lengths(nodes[along] - nodes[along[firsts]][way_of]) >= reaches[way_of]
    cuts = np.maximum(first_in_groups(is_beyond, begins) - firsts, 1)
    return [way[: cut + 1] for way, cut in zip(ways, cuts.tolist(), strict=True)]


def _half_widths(ways: list[NDArray[np.float64]], surface: Surface) -> NDArray[np.float64]:
    """(w,) median half width of the cross-sections at the points of each path; 0 at a point outside its section."""
    points = np.concatenate(ways)
    tangents = np.concatenate([np.gradient(way, axis=0) for way in ways])
    tangents /= np.maximum(vector_lengths(tangents)[:, None], 1e-300)
    sections = cross_sections(surface.mesh, points, tangents, deadline=surface.deadline)
    mean = sections.lengths / 8
    widths = mean + np.sqrt(np.maximum(mean**2 - sections.areas / 4, 0))
    return group_medians(np.where(sections.surrounds, widths, 0), np.cumsum([0, *map(len, ways)]))


def _sees(points: NDArray[np.float64], others: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """(s,) whether each segment stays inside, or leaves the surface by at most MAX_GAP of its length."""
    shares = ((np.arange(N_SAMPLES) + 0.5) / N_SAMPLES)[:, None, None]
    samples, limits = (1 - shares) * points + shares * others, MAX_GAP * vector_lengths(others - points)
    sees = np.ones(len(points), dtype=bool)
    middle = N_SAMPLES // 2
    for tested in (samples[[middle]], np.delete(samples, middle, axis=0)):  # most that leave are outside in the middle
        rows = np.flatnonzero(sees)
        rest = tested[:, rows].reshape(-1, 3)
        gaps, is_outside = np.zeros(len(rest)), ~surface.contains(rest)
        gaps[is_outside] = surface.distance(rest[is_outside])
        sees[rows] = gaps.reshape(len(tested), -1).max(axis=0) <= limits[rows]
    return sees
