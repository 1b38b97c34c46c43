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

__all__ = ["first_part", "is_corner", "prune_flat_ends", "ways_from_nodes"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import N_SAMPLES, moved_inside
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.pruning import farthest_vertices
from lbskel.skeleton.skeleton import Skeleton

# Distance by which a line of sight may leave the surface, in lengths of the line. Rows "gap of" in
# benchmarks/results/refinement.md: from 0.08 on ears count as corners of a head; by hand, bent ribbons need 0.02
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
    skeleton : Skeleton
        With ``node_of_vertex``.
    surface : Surface
        Of the mesh that ``node_of_vertex`` belongs to.
    ends : list of (k,) arrays of int
        Some of the end branches, the junction first.
    min_branch_ratio : float
        As for :func:`prune_flat_ends`.
    """
    skeleton = replace(skeleton, nodes=moved_inside(skeleton.nodes, surface))
    nodes, junctions = skeleton.nodes, np.array([end[0] for end in ends])
    farthest, reaches = farthest_vertices(skeleton, surface.mesh, ends)
    entry, inward, _ = surface.inner_offset(farthest)
    depths = local_radii(surface.mesh, deadline=surface.deadline)[farthest]
    peaks = moved_inside(entry + depths[:, None] * inward, surface)
    row_of_tip = {int(end[-1]): row for row, end in enumerate(ends)}
    ways_from = ways_from_nodes(skeleton)
    sights: list[tuple[int, NDArray[np.float64]]] = []
    opposite = []
    for row, (end, reach) in enumerate(zip(ends, reaches.tolist(), strict=True)):
        ways = [first_part(nodes, way, reach) for way in ways_from[int(end[0])] if way[-1] != end[-1]]
        facing = [
            peaks[row_of_tip[tip]] if (tip := int(way[-1])) in row_of_tip else _at_reach(nodes, way, reach)
            for way in ways
        ]
        sights += [(row, point) for point in facing]
        offsets = np.array([nodes[way[-1]] - nodes[end[0]] for way in ways])
        cosines = offsets @ (peaks[row] - nodes[end[0]]) / np.maximum(vector_lengths(offsets), 1e-300)
        opposite.append(nodes[ways[int(cosines.argmin())]])
    owner, points = np.array([row for row, _ in sights]), np.array([point for _, point in sights])
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


def first_part(nodes: NDArray[np.float64], way: NDArray[np.int64], reach: float) -> NDArray[np.int64]:
    """Cut a path off after its first node that is at least a reach away from its start.

    Parameters
    ----------
    nodes : (k, 3) array of float
    way : (m,) array of int
    reach : float
    """
    beyond = np.flatnonzero(vector_lengths(nodes[way] - nodes[way[0]]) >= reach)
    return way[: max(beyond[0], 1) + 1] if len(beyond) else way


def _at_reach(nodes: NDArray[np.float64], way: NDArray[np.int64], reach: float) -> NDArray[np.float64]:
    """(3,) point on the last edge of a path, about a reach from its start; the end of the path if that is nearer."""
    before, last = nodes[way[-2:]]
    near, far = vector_lengths(nodes[way[-2:]] - nodes[way[0]])
    share = np.clip((reach - near) / max(far - near, 1e-300), 0, 1)
    return np.asarray(before + share * (last - before))


def _half_widths(ways: list[NDArray[np.float64]], surface: Surface) -> NDArray[np.float64]:
    """(w,) median half width of the cross-sections at the points of each path; 0 at a point outside its section."""
    points = np.concatenate(ways)
    tangents = np.concatenate([np.gradient(way, axis=0) for way in ways])
    tangents /= np.maximum(vector_lengths(tangents)[:, None], 1e-300)
    sections = cross_sections(surface.mesh, points, tangents, deadline=surface.deadline)
    mean = sections.lengths / 8
    widths = mean + np.sqrt(np.maximum(mean**2 - sections.areas / 4, 0))
    parts = np.cumsum([len(way) for way in ways])[:-1]
    return np.array([np.median(part) for part in np.split(np.where(sections.surrounds, widths, 0), parts)])


def _sees(points: NDArray[np.float64], others: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """(s,) whether each segment stays inside, or leaves the surface by at most MAX_GAP of its length."""
    shares = ((np.arange(N_SAMPLES) + 0.5) / N_SAMPLES)[:, None, None]
    samples = ((1 - shares) * points + shares * others).reshape(-1, 3)
    is_outside = ~surface.contains(samples).reshape(N_SAMPLES, -1)
    limits = MAX_GAP * vector_lengths(others - points)
    by_segment = samples.reshape(N_SAMPLES, -1, 3)
    sees = np.asarray(~is_outside.any(axis=0))
    # the outside sample nearest to the middle of each segment is tested first: it is usually too far out
    rows = np.flatnonzero(~sees)
    inward = np.argsort(np.abs(np.arange(N_SAMPLES) - (N_SAMPLES - 1) / 2), kind="stable")
    middle = inward[is_outside[inward][:, rows].argmax(axis=0)]
    rows = rows[surface.distance(by_segment[middle, rows]) <= limits[rows]]
    gaps = np.zeros((N_SAMPLES, len(rows)))
    left = is_outside[:, rows]
    gaps[left] = surface.distance(by_segment[:, rows][left])
    sees[rows] = gaps.max(axis=0, initial=0.0) <= limits[rows]
    return sees
