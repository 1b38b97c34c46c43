"""Cross-sections of a cloud of points: whether a skeleton is among the points, and how far from their middle.

A section is the points beside a place, near the plane across the skeleton there.
"""

from __future__ import annotations

__all__ = ["inside_fraction", "section_errors", "spread"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.point_tree import PointTree
from lbskel.geometry.normals import normalized
from lbskel.skeleton.skeleton import Skeleton

MAX_SPACING_POINTS = 3_000  # of a cloud whose spacing is measured; a guess that bounds the time
MAX_SECTIONS = 200  # at nodes, and again along the length, evenly sampled; a guess that bounds the time
SECTION_REACH = 3.0  # of a section, in distances from its place to the nearest points; a guess
SECTION_WIDTH = 0.25  # half thickness of a section in the same unit, if that is more than two spacings; a guess
N_SECTORS = 24  # of a section; its outline is the nearest points in each; a guess
MAX_GAP = 0.75  # of a turn without points, beyond which a place is not among the points; a guess
JUNCTION_REACH = 2.0  # of a junction in its radii, within which a section is not that of one branch; a guess
MAX_OPEN = 0.25  # of a turn without points, beyond which a section has no center; a guess


def spread(points: NDArray[np.float64], limit: int) -> NDArray[np.int64]:
    """Choose at most ``limit`` points, evenly in their order along the direction in which they extend farthest.

    Parameters
    ----------
    points : (n, 3) array of float
    limit : int
    """
    n = len(points)
    if n <= limit:
        return np.arange(n)
    offsets = points - points.mean(axis=0)
    principal = np.linalg.eigh(offsets.T @ offsets)[1][:, -1]
    order = np.argsort(offsets @ principal, kind="stable")
    return np.sort(order[np.linspace(0, n - 1, limit).astype(np.int64)])


def section_errors(
    skeleton: Skeleton, points: NDArray[np.float64], tree: PointTree
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """(k,) whether each node is among the points, and (k,) its distance from the middle of its section.

    The unit of the distance is the mean one of the outline from its center; NaN where it is not known. A node without
    a section of its own is among the points if the nearest node with one is, or, where no node has one, if it lies in
    the bounding box of the points.

    Parameters
    ----------
    skeleton : Skeleton
        Its radii are the distances of the nodes from the points.
    points : (n, 3) array of float
    tree : PointTree
        Of the points.
    """
    gaps, errors = np.full(len(skeleton.nodes), np.nan), np.full(len(skeleton.nodes), np.nan)
    _, middle, following = skeleton.triples
    axes = normalized(skeleton.nodes[following] - skeleton.nodes[middle])
    chosen = np.unique(np.linspace(0, len(middle) - 1, MAX_SECTIONS).astype(np.int64)) if len(middle) else middle
    chosen = chosen[axes[chosen].any(axis=1)]
    node = middle[chosen]
    gaps[node], errors[node] = _sections(skeleton.nodes[node], axes[chosen], skeleton.radii[node], points, tree)
    if len(skeleton.junctions):
        found = PointTree(skeleton.nodes[skeleton.junctions]).nearest(skeleton.nodes)
        to_junction, nearest = (column[:, 0] for column in found)
        errors[to_junction <= JUNCTION_REACH * skeleton.radii[skeleton.junctions][nearest]] = np.nan
    known = np.flatnonzero(~np.isnan(gaps))
    if len(known) == 0:
        is_in_box = (skeleton.nodes >= points.min(axis=0)) & (skeleton.nodes <= points.max(axis=0))
        return is_in_box.all(axis=1), errors
    nearest = PointTree(skeleton.nodes[known]).nearest(skeleton.nodes)[1][:, 0]
    return gaps[known][nearest] <= MAX_GAP, errors


def inside_fraction(skeleton: Skeleton, points: NDArray[np.float64], tree: PointTree) -> float | None:
    """Compute the fraction of the length that is among the points; None without length.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float
    tree : PointTree
        Of the points.
    """
    lengths = np.cumsum(skeleton.edge_lengths)
    if len(lengths) == 0 or lengths[-1] == 0:
        return None
    at = (np.arange(MAX_SECTIONS) + 0.5) / MAX_SECTIONS * lengths[-1]
    edge = np.searchsorted(lengths, at)
    start, end = skeleton.nodes[skeleton.edges[edge]].transpose(1, 0, 2)
    share = (lengths[edge] - at) / skeleton.edge_lengths[edge]
    places = end + share[:, None] * (start - end)
    gaps, _ = _sections(places, normalized(end - start), tree.nearest(places)[0][:, 0], points, tree)
    return float((gaps <= MAX_GAP).mean())


def _sections(
    places: NDArray[np.float64],
    axes: NDArray[np.float64],
    radii: NDArray[np.float64],
    points: NDArray[np.float64],
    tree: PointTree,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(s,) largest share of a turn without points around each place, and (s,) its distance from the middle.

    Radii are the distances of the places from the points.
    """
    if len(places) == 0:
        return np.empty(0), np.empty(0)
    some = points[spread(points, MAX_SPACING_POINTS)]
    spacing = float(np.median(tree.nearest(some, 3)[0][:, -1]))
    reach = SECTION_REACH * np.maximum(radii, spacing)
    near, counts = tree.in_disks(places, reach, axes, np.maximum(SECTION_WIDTH * radii, 2 * spacing))
    section = np.repeat(np.arange(len(places)), counts)
    return _outlines(points[near] - places[section], section, axes)


def _outlines(
    offsets: NDArray[np.float64], section: NDArray[np.int64], axes: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(s,) largest share of a turn without points, and (s,) distance of the origin from the center of the outline.

    The outline consists of the nearest points in each sector; the unit is its mean distance from its center. Offsets
    are those of points from the middles of their sections, whose axes have unit length.
    """
    n = len(axes)
    first = normalized(np.cross(axes, np.eye(3)[np.argmin(np.abs(axes), axis=1)]))
    x, y = (np.einsum("nk,nk->n", offsets, across[section]) for across in (first, np.cross(axes, first)))
    sector = ((np.arctan2(y, x) / (2 * np.pi) + 0.5) * N_SECTORS).astype(np.int64) % N_SECTORS
    place, distance = section * N_SECTORS + sector, np.hypot(x, y)
    nearest = np.full(n * N_SECTORS, np.inf)
    np.minimum.at(nearest, place, distance)
    # for each sector of two turns, the last sector with a point up to it
    turns = np.arange(2 * N_SECTORS)
    is_seen = np.isfinite(nearest).reshape(n, N_SECTORS)
    last = np.maximum.accumulate(np.where(np.tile(is_seen, 2), turns, -1), axis=1)
    gaps = np.minimum((turns - last).max(axis=1), N_SECTORS) / N_SECTORS
    is_outline = distance <= 1.5 * nearest[place]
    sums, count = (np.bincount(place[is_outline], some, n * N_SECTORS) for some in (distance[is_outline], None))
    angles = (turns[:N_SECTORS] + 0.5) * 2 * np.pi / N_SECTORS
    means = (sums / np.maximum(count, 1)).reshape(n, N_SECTORS)
    corners = means[..., None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # a sector without points has the corner of the last, which changes neither area nor center
    corners = corners[np.arange(n)[:, None], last[:, N_SECTORS:] % N_SECTORS]
    following = np.roll(corners, -1, axis=1)
    areas = (corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]) / 2
    area = areas.sum(axis=1)
    is_known = (gaps <= MAX_OPEN) & (area > 0)
    areas[is_known] /= area[is_known, None]
    center = ((corners + following) / 3 * areas[..., None]).sum(axis=1)
    radii = np.where(is_seen, np.linalg.norm(corners - center[:, None], axis=2), 0.0)[is_known]
    errors = np.full(n, np.nan)
    errors[is_known] = np.linalg.norm(center[is_known], axis=1) * is_seen[is_known].sum(axis=1) / radii.sum(axis=1)
    return gaps, errors
