"""The quality of a skeleton, measured on the points of a cloud alone.

No surface is made: a section is the points beside a node, near the plane across its branch; the cloud's own graph of
neighbors tells its parts, its regions, its ends, and the limbs at which the skeleton is cut
(:mod:`lbskel.evaluation.point_loops`). What takes a surface is not measured: cycles too many, and how near the surface
the skeleton is. Sections as in the measures of Huang et al. 2013 and Cornea, Silver, Min 2007,
https://doi.org/10.1109/TVCG.2007.1002. Lengths are in units of the local radius, the mean distance of the points of a
section.
"""

from __future__ import annotations

__all__ = ["score_points"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from lbskel.evaluation.measures import Score
from lbskel.evaluation.point_loops import count_cut_loops
from lbskel.evaluation.skeleton_shape import length_fraction, n_spurs, rms_curvature
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import PointCloud
from lbskel.skeleton.skeleton import Skeleton

MAX_POINTS, MAX_GRAPH_POINTS = 20_000, 3_000  # of a cloud for sections, and for its ends; guesses that bound the time
N_NEIGHBORS = 12  # of a point, linked with it where it is one of theirs, as those of an outlier are not; a guess
# Share of the points below which a part of the cloud is outliers or a crumb, and distance between the points of a part,
# in that of the whole cloud, above which it is one of outliers; guesses
MIN_PART, MAX_SPACING = 0.01, 3.0
MAX_SECTIONS = 200  # nodes whose sections are taken, evenly sampled; a guess that bounds the time
SECTION_REACH = 3.0  # of a section, in distances from the node to its nearest points; a guess
SECTION_WIDTH = 0.25  # half thickness of a section in the same unit, if that is more than two spacings; a guess
N_SECTORS = 24  # of a section; its outline is the nearest points in each; a guess
MAX_GAP = 0.75  # of a turn without points, beyond which a node is not among the points; a guess
JUNCTION_REACH = 2.0  # of a junction in its radii, within which a section is not that of one branch; a guess
MAX_OPEN = 0.25  # of a turn without points, beyond which a section has no center; a guess
N_SCALES = 5  # nodes whose median radius is that of an end, so that one point inside does not matter; a guess
N_SOURCES = 30  # points from which distances along the cloud are averaged; a guess
MIN_END, MIN_LIMB = 3.0, 6.0  # length of an end, and of a limb that must have a tip, in local radii; guesses
TIP_REACH, NODE_REACH = 3.0, 2.0  # of an end from its tip, and from any node, in local radii; guesses
# Distances from a peak in local radii, between which the cloud is in one part around an end, and in two around a point
# of a loop; half the way around a tube is 3.1. A guess
SHELL = (5.0, 7.0)
MIN_SHELL_SHARE = 0.1  # of the points between them, below which a part of them does not count; a guess
MAX_COVERED_DISTANCE = 2.0  # in local radii, as on meshes


def score_points(skeleton: Skeleton, cloud: PointCloud) -> Score:
    """Measure a skeleton on a cloud.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the cloud; its map, if it has one, is of the points.
    cloud : PointCloud
    """
    has_map = len(skeleton.node_of_vertex) > 0
    tree = cKDTree(skeleton.nodes)
    node = skeleton.node_of_vertex if has_map else tree.query(cloud.points)[1]
    points, graph, n_parts = _without_outliers(cloud.points[_spread(cloud.points, MAX_POINTS)])
    radii = cKDTree(points).query(skeleton.nodes)[0]
    gaps, errors = _sections(skeleton, points, radii)
    skeleton = replace(skeleton, radii=radii)
    is_among = np.isnan(gaps) | (gaps <= MAX_GAP)
    known = ~np.isnan(errors)
    by_branch = [errors[branch][known[branch]] for branch in skeleton.branches]
    ends, lengths, scales = _ends(points, graph, skeleton, tree)
    tips = skeleton.nodes[skeleton.degrees <= 1]
    to_tip = cKDTree(tips).query(ends)[0] if len(tips) and len(ends) else np.full(len(ends), np.inf)
    to_node = tree.query(ends)[0] if len(ends) else np.empty(0)
    missed, is_limb = (to_tip > TIP_REACH * scales) & (to_node > NODE_REACH * scales), lengths > MIN_LIMB * scales
    distances = np.linalg.norm(cloud.points - skeleton.nodes[node], axis=1)
    return Score(
        nodes_inside_fraction=float(is_among.mean()),
        inside_fraction=length_fraction(skeleton, is_among),
        centeredness_error=float(errors[known].mean()) if known.any() else None,
        centeredness_error_worst_branch=max((float(np.median(e)) for e in by_branch if len(e) >= 5), default=None),
        near_surface_fraction=None,
        coverage=float((distances <= MAX_COVERED_DISTANCE * _widths(skeleton, node, distances)[node]).mean()),
        extremities=len(ends),
        extremities_missed=int(missed.sum()),
        missed_limb_fraction=float(missed[is_limb].mean()) if is_limb.any() else 0.0,
        rms_curvature=rms_curvature(skeleton),
        extra_components=max(0, skeleton.n_components - n_parts),
        extra_cycles=None,
        tunnels_missed=max(0, count_cut_loops(skeleton, points, graph) - int(skeleton.report.get("loops_opened", 0))),
        connected_regions=None,
        adjacent_regions=None,
        shortcut_edges=None,
        spurs=n_spurs(skeleton),
    )


def _spread(points: NDArray[np.float64], limit: int) -> NDArray[np.int64]:
    """Choose at most some points, evenly in an order along the longest side."""
    n = len(points)
    if n <= limit:
        return np.arange(n)
    sides = np.ptp(points, axis=0)
    order = np.argsort(points[:, int(np.argmax(sides))], kind="stable")
    return np.sort(order[np.linspace(0, n - 1, limit).astype(np.int64)])


def _neighbor_graph(points: NDArray[np.float64]) -> csr_array:
    """Symmetric graph of the distances of neighbors that are near for both."""
    n = len(points)
    neighbors = cKDTree(points).query(points, k=min(N_NEIGHBORS + 1, n))[1][:, 1:]
    first, second = np.repeat(np.arange(n), neighbors.shape[1]), neighbors.ravel()
    key = np.sort(np.minimum(first, second) * n + np.maximum(first, second))
    links = np.stack(np.divmod(key[1:][key[1:] == key[:-1]], n), axis=1)  # of both to each other
    lengths = np.linalg.norm(points[links[:, 0]] - points[links[:, 1]], axis=1)
    graph = weighted_graph(links[lengths > 0], lengths[lengths > 0], n)
    return csr_array(graph + graph.T)


def _without_outliers(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], csr_array, int]:
    """Points of the parts that are no crumbs, the graph of their neighbors, and the number of these parts."""
    graph = _neighbor_graph(points)
    part = connected_components(graph, directed=False)[1]
    count = np.bincount(part)
    is_part = count >= min(MIN_PART * len(points), count.max())
    for number in np.flatnonzero(is_part & (count < count.max())):
        is_part[number] = np.median(graph[part == number].data) <= MAX_SPACING * np.median(graph.data)
    kept = np.flatnonzero(is_part[part])
    return points[kept], graph[kept][:, kept], int(is_part.sum())


def _sections(
    skeleton: Skeleton, points: NDArray[np.float64], radii: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k,) share of a turn around each node without points, and (k,) its distance from their center; NaN elsewhere."""
    tree = cKDTree(points)
    spacing = float(np.median(tree.query(points, k=min(3, len(points)))[0][:, -1]))
    gaps, errors = np.full(len(skeleton.nodes), np.nan), np.full(len(skeleton.nodes), np.nan)
    inner = [
        (int(b), int(a), int(c))
        for branch in skeleton.branches
        for a, b, c in zip(branch, branch[1:], branch[2:], strict=False)
    ]
    chosen = np.unique(np.linspace(0, len(inner) - 1, MAX_SECTIONS).astype(np.int64)).tolist() if inner else []
    for node, before, after in (inner[number] for number in chosen):
        center, axis = skeleton.nodes[node], skeleton.nodes[after] - skeleton.nodes[before]
        length = float(np.linalg.norm(axis))
        reach = SECTION_REACH * max(float(radii[node]), spacing)
        if length == 0:
            continue
        offsets = points[tree.query_ball_point(center, reach)] - center
        along = offsets @ (axis / length)
        flat = offsets - along[:, None] * (axis / length)
        flat = flat[np.abs(along) <= max(SECTION_WIDTH * radii[node], 2 * spacing)]
        gaps[node], errors[node] = _outline(flat, axis / length)
    if len(skeleton.junctions):
        to_junction, nearest = cKDTree(skeleton.nodes[skeleton.junctions]).query(skeleton.nodes)
        errors[to_junction <= JUNCTION_REACH * radii[skeleton.junctions][nearest]] = np.nan
    return gaps, errors


def _outline(flat: NDArray[np.float64], axis: NDArray[np.float64]) -> tuple[float, float]:
    """Largest share of a turn without points, and the distance of the origin from the center of the nearest points."""
    side = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, side)
    first /= np.linalg.norm(first)
    x, y = flat @ first, flat @ np.cross(axis, first)
    sector = ((np.arctan2(y, x) / (2 * np.pi) + 0.5) * N_SECTORS).astype(np.int64) % N_SECTORS
    distance = np.hypot(x, y)
    nearest = np.full(N_SECTORS, np.inf)
    np.minimum.at(nearest, sector, distance)
    seen = np.flatnonzero(np.isfinite(nearest))
    if len(seen) == 0:
        return 1.0, np.nan
    gap = (int(np.diff(np.append(seen, seen[0] + N_SECTORS)).max()) - 1) / N_SECTORS
    if gap > MAX_OPEN:
        return gap, np.nan
    is_outline = distance <= 1.5 * nearest[sector]
    sums = np.bincount(sector[is_outline], distance[is_outline], N_SECTORS)
    means = sums[seen] / np.bincount(sector[is_outline], minlength=N_SECTORS)[seen]
    angle = (seen + 0.5) * 2 * np.pi / N_SECTORS
    corners = means[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    following = np.roll(corners, -1, axis=0)
    areas = (corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]) / 2
    if not areas.sum() > 0:
        return gap, np.nan
    center = ((corners + following) / 3 * areas[:, None]).sum(axis=0) / areas.sum()
    return gap, float(np.linalg.norm(center) / np.linalg.norm(corners - center, axis=1).mean())


def _widths(skeleton: Skeleton, node: NDArray[np.int64], distances: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) mean distance of the points of a node, its median over the branch where that is more than their nearest."""
    count = np.bincount(node, minlength=len(skeleton.nodes))
    means = np.bincount(node, distances, len(skeleton.nodes)) / np.maximum(count, 1)
    widths = np.array(skeleton.radii)
    for branch in skeleton.branches:
        own = means[branch][count[branch] > 0]
        if len(own):
            widths[branch] = np.maximum(widths[branch], np.median(own))
    return widths


def _ends(
    points: NDArray[np.float64], graph: csr_array, skeleton: Skeleton, tree: cKDTree
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(e, 3) ends of the cloud, (e,) length by which each stands out, and (e,) local radius there.

    An end is a peak of the mean distance along the cloud to points spread over it, as high above the pass to a higher
    peak as it is long.
    """
    if len(points) > MAX_GRAPH_POINTS:
        points = points[_spread(points, MAX_GRAPH_POINTS)]
        graph = _neighbor_graph(points)
    part = connected_components(graph, directed=False)[1]
    height = np.full(len(points), -np.inf)
    for number in np.flatnonzero(np.bincount(part) >= MIN_PART * len(points)):
        own = np.flatnonzero(part == number)
        sources = own[np.linspace(0, len(own) - 1, min(N_SOURCES, len(own))).astype(np.int64)]
        height[own] = dijkstra(graph, directed=False, indices=sources)[:, own].mean(axis=0)
    peaks, lengths = _peaks(graph, height)
    k = min(N_SCALES, len(skeleton.nodes))
    near = tree.query(points[peaks], k=k)[1].reshape(len(peaks), k)
    scales = np.median(skeleton.radii[near], axis=1)
    is_end = lengths > MIN_END * scales
    is_end[is_end] = [
        _is_at_end(graph, *peak) for peak in zip(peaks[is_end].tolist(), scales[is_end].tolist(), strict=True)
    ]
    return points[peaks[is_end]], lengths[is_end], scales[is_end]


def _peaks(graph: csr_array, height: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Peaks of a function on a graph, and the height of each above the pass to a higher one, or above the lowest."""
    pointers, neighbors, heights = graph.indptr.tolist(), graph.indices.tolist(), height.tolist()
    root = [-1] * len(heights)
    lengths: dict[int, float] = {}

    def find(node: int) -> int:
        while root[node] != node:
            root[node] = root[root[node]]
            node = root[node]
        return node

    reached = np.argsort(-height, kind="stable")[: np.count_nonzero(np.isfinite(height))]
    for node in reached.tolist():
        groups = {find(other) for other in neighbors[pointers[node] : pointers[node + 1]] if root[other] >= 0}
        root[node] = node
        if groups:
            highest = max(groups, key=lambda peak: (heights[peak], -peak))
            for peak in groups - {highest}:
                lengths[peak] = heights[peak] - heights[node]
                root[peak] = highest
            root[node] = highest
    lengths.update({node: np.inf for node, parent in enumerate(root) if parent == node})
    peaks = np.array(sorted(lengths), dtype=np.int64)
    return peaks, np.array([lengths[peak] for peak in peaks.tolist()])


def _is_at_end(graph: csr_array, peak: int, scale: float) -> bool:
    """Whether the cloud leads away from a peak in one direction, as from the end of a limb, and not in two."""
    near, far = SHELL[0] * scale, SHELL[1] * scale
    distances = dijkstra(graph, directed=False, indices=peak, limit=far)
    shell = np.flatnonzero(np.isfinite(distances) & (distances > near))
    if len(shell) == 0:
        return True
    sizes = np.bincount(connected_components(graph[shell][:, shell], directed=False)[1])
    return int((sizes >= MIN_SHELL_SHARE * len(shell)).sum()) == 1
