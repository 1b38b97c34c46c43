"""The quality of a skeleton, measured on the points of a cloud alone.

No surface is made: a section is the points beside a node, near the plane across its branch. The cloud's own graph of
neighbors shows its parts, its ends, and the limbs at which the skeleton is cut
(:mod:`lbskel.evaluation.point_loops`). What takes a surface is not measured: surplus cycles, the regions of the vertex
map, and how near the surface the skeleton is. Sections as in the measures of Huang et al. 2013 and Cornea, Silver, Min
2007, https://doi.org/10.1109/TVCG.2007.1002. Centeredness is in units of the mean distance of a section's outline from
its center, other lengths in units of the local radius, the distance from a node to the nearest point.
"""

from __future__ import annotations

__all__ = ["SCORED_NEIGHBORS", "score_points"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from lbskel._kernels.point_tree import PointTree
from lbskel.evaluation.measures import Score
from lbskel.evaluation.point_loops import count_cut_loops
from lbskel.evaluation.skeleton_shape import length_fraction, mean_and_worst_branch, n_spurs, rms_curvature
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import PointCloud
from lbskel.geometry.normals import normalized
from lbskel.geometry.sorting import stable_order
from lbskel.skeleton.skeleton import Skeleton

MAX_POINTS, MAX_GRAPH_POINTS = 20_000, 3_000  # of a cloud for sections, and for its ends; guesses that bound the time
# Nearest points of a point, itself included, linked with it where it is one of theirs, as those of an outlier are not;
# a guess
SCORED_NEIGHBORS = 13
# Share of the points below which a part of the cloud counts as outliers or a crumb, and ratio of the distance between
# the points of a part to that of the whole cloud above which the part counts as outliers; guesses
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
# Distances from a peak in local radii, between which the cloud has one part if the peak is an end, and two if it is a
# point of a loop; half the way around a tube is 3.1. A guess
SHELL = (5.0, 7.0)
MIN_SHELL_SHARE = 0.1  # of the points between them, below which a part of them does not count; a guess
MAX_COVERED_DISTANCE = 2.0  # in local radii, as on meshes


def score_points(skeleton: Skeleton, cloud: PointCloud, neighbors: NDArray[np.int64] | None = None) -> Score:
    """Measure a skeleton on a cloud.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the cloud. Its vertex map, if it has one, maps the points; its radii are not used.
    cloud : PointCloud
    neighbors : (n, SCORED_NEIGHBORS) array of int, optional
        The nearest points of each point, itself first, where they are known.
    """
    has_map = len(skeleton.node_of_vertex) > 0
    tree = PointTree(skeleton.nodes)
    node = skeleton.node_of_vertex if has_map else tree.nearest(cloud.points)[1][:, 0]
    some = _spread(cloud.points, MAX_POINTS)
    neighbors = neighbors if len(some) == len(cloud.points) else None
    points, point_tree, graph, n_parts = _without_outliers(cloud.points[some], neighbors)
    radii = point_tree.nearest(skeleton.nodes)[0][:, 0]
    gaps, errors = _sections(skeleton, points, point_tree, radii)
    skeleton = replace(skeleton, radii=radii)
    is_among = np.isnan(gaps) | (gaps <= MAX_GAP)
    mean_error, worst_branch_error = mean_and_worst_branch(skeleton, errors)
    ends, lengths, scales = _ends(points, graph, skeleton, tree)
    tips = skeleton.nodes[skeleton.degrees <= 1]
    to_tip = PointTree(tips).nearest(ends)[0][:, 0] if len(tips) else np.full(len(ends), np.inf)
    to_node = tree.nearest(ends)[0][:, 0]
    missed, is_limb = (to_tip > TIP_REACH * scales) & (to_node > NODE_REACH * scales), lengths > MIN_LIMB * scales
    distances = np.linalg.norm(cloud.points - skeleton.nodes[node], axis=1)
    return Score(
        nodes_inside_fraction=float(is_among.mean()),
        inside_fraction=length_fraction(skeleton, is_among),
        centeredness_error=mean_error,
        centeredness_error_worst_branch=worst_branch_error,
        medial_accuracy_95=None,
        medial_coverage_98=None,
        uncovered_parts=None,
        near_surface_fraction=None,
        coverage=float((distances <= MAX_COVERED_DISTANCE * _widths(skeleton, node, distances)[node]).mean()),
        extremities=len(ends),
        extremities_missed=int(missed.sum()),
        missed_limb_fraction=float(missed[is_limb].mean()) if is_limb.any() else 0.0,
        rms_curvature=rms_curvature(skeleton),
        extra_components=max(0, skeleton.n_components - n_parts),
        extra_cycles=None,
        tunnels_missed=max(
            0, count_cut_loops(skeleton, points, graph, tree, point_tree) - int(skeleton.report.get("loops_opened", 0))
        ),
        connected_regions=None,
        adjacent_regions=None,
        shortcut_edges=None,
        spurs=n_spurs(skeleton),
    )


def _spread(points: NDArray[np.float64], limit: int) -> NDArray[np.int64]:
    """Choose at most ``limit`` points, evenly in their order along the longest side of the bounding box."""
    n = len(points)
    if n <= limit:
        return np.arange(n)
    sides = np.ptp(points, axis=0)
    order = np.argsort(points[:, int(np.argmax(sides))], kind="stable")
    return np.sort(order[np.linspace(0, n - 1, limit).astype(np.int64)])


def _neighbor_graph(points: NDArray[np.float64], neighbors: NDArray[np.int64]) -> csr_array:
    """Symmetric graph of the distances between points that are each among the other's nearest neighbors."""
    n = len(points)
    first, second = np.repeat(np.arange(n), neighbors.shape[1] - 1), neighbors[:, 1:].ravel()
    key = np.sort(np.minimum(first, second) * n + np.maximum(first, second))
    links = np.stack(np.divmod(key[1:][key[1:] == key[:-1]], n), axis=1)  # of both to each other
    lengths = np.linalg.norm(points[links[:, 0]] - points[links[:, 1]], axis=1)
    links, lengths = links[lengths > 0], lengths[lengths > 0]
    return weighted_graph(np.concatenate([links, links[:, ::-1]]), np.tile(lengths, 2), n)


def _without_outliers(
    points: NDArray[np.float64], neighbors: NDArray[np.int64] | None
) -> tuple[NDArray[np.float64], PointTree, csr_array, int]:
    """Points of parts that are no crumbs, their tree, the graph of their neighbors, and the number of these parts."""
    tree = PointTree(points)
    graph = _neighbor_graph(points, tree.neighbors(SCORED_NEIGHBORS)[1] if neighbors is None else neighbors)
    part = connected_components(graph, directed=False)[1]
    count = np.bincount(part)
    is_part = count >= min(MIN_PART * len(points), count.max())
    for number in np.flatnonzero(is_part & (count < count.max())):
        lengths = graph[part == number].data  # none around a point alone
        is_part[number] = len(lengths) and np.median(lengths) <= MAX_SPACING * np.median(graph.data)
    if is_part.all():
        return points, tree, graph, len(is_part)
    kept = np.flatnonzero(is_part[part])
    return points[kept], PointTree(points[kept]), graph[kept][:, kept], int(is_part.sum())


def _sections(
    skeleton: Skeleton, points: NDArray[np.float64], tree: PointTree, radii: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k,) largest share of a turn around each node without points, and (k,) centeredness error; NaN elsewhere."""
    some = points[_spread(points, MAX_GRAPH_POINTS)]
    spacing = float(np.median(tree.nearest(some, 3)[0][:, -1]))
    gaps, errors = np.full(len(skeleton.nodes), np.nan), np.full(len(skeleton.nodes), np.nan)
    inner = [
        (int(b), int(a), int(c))
        for branch in skeleton.branches
        for a, b, c in zip(branch, branch[1:], branch[2:], strict=False)
    ]
    numbers = np.array(inner, dtype=np.int64).reshape(-1, 3)
    axes = normalized(skeleton.nodes[numbers[:, 2]] - skeleton.nodes[numbers[:, 1]])
    chosen = np.unique(np.linspace(0, len(inner) - 1, MAX_SECTIONS).astype(np.int64)) if inner else numbers[:, 0]
    chosen = chosen[axes[chosen].any(axis=1)]
    if len(chosen):
        node, axes = numbers[chosen, 0], axes[chosen]
        reach = SECTION_REACH * np.maximum(radii[node], spacing)
        width = np.maximum(SECTION_WIDTH * radii[node], 2 * spacing)
        near, counts = tree.in_disks(skeleton.nodes[node], reach, axes, width)
        section = np.repeat(np.arange(len(node)), counts)
        gaps[node], errors[node] = _outlines(points[near] - skeleton.nodes[node][section], section, axes)
    if len(skeleton.junctions):
        found = PointTree(skeleton.nodes[skeleton.junctions]).nearest(skeleton.nodes)
        to_junction, nearest = (column[:, 0] for column in found)
        errors[to_junction <= JUNCTION_REACH * radii[skeleton.junctions][nearest]] = np.nan
    return gaps, errors


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


def _widths(skeleton: Skeleton, node: NDArray[np.int64], distances: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) radius of each node, or the median over its branch of the nodes' mean distances of points if larger."""
    count = np.bincount(node, minlength=len(skeleton.nodes))
    means = np.bincount(node, distances, len(skeleton.nodes)) / np.maximum(count, 1)
    widths = np.array(skeleton.radii)
    for branch in skeleton.branches:
        own = means[branch][count[branch] > 0]
        if len(own):
            widths[branch] = np.maximum(widths[branch], np.median(own))
    return widths


def _ends(
    points: NDArray[np.float64], graph: csr_array, skeleton: Skeleton, tree: PointTree
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(e, 3) ends of the cloud, (e,) length by which each stands out, and (e,) local radius there.

    An end is a peak of the mean distance along the cloud to points spread over it; its length is its height above the
    pass to a higher peak.
    """
    if len(points) > MAX_GRAPH_POINTS:
        points = points[_spread(points, MAX_GRAPH_POINTS)]
        graph = _neighbor_graph(points, PointTree(points).neighbors(SCORED_NEIGHBORS)[1])
    part = connected_components(graph, directed=False)[1]
    height = np.full(len(points), -np.inf)
    for number in np.flatnonzero(np.bincount(part) >= MIN_PART * len(points)):
        own = np.flatnonzero(part == number)
        sources = own[np.linspace(0, len(own) - 1, min(N_SOURCES, len(own))).astype(np.int64)]
        height[own] = dijkstra(graph, indices=sources)[:, own].mean(axis=0)
    peaks, lengths = _peaks(graph, height)
    near = tree.nearest(points[peaks], N_SCALES)[1]
    scales = np.median(skeleton.radii[near], axis=1)
    is_end = lengths > MIN_END * scales
    is_end[is_end] = [
        _is_at_end(graph, *peak) for peak in zip(peaks[is_end].tolist(), scales[is_end].tolist(), strict=True)
    ]
    return points[peaks[is_end]], lengths[is_end], scales[is_end]


def _peaks(graph: csr_array, height: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Peaks of a function on a graph, and the height of each above the pass to a higher one, or above the lowest."""
    reached = np.argsort(-height, kind="stable")[: np.count_nonzero(np.isfinite(height))]
    rank = np.full(len(height), len(height))  # 0 for the highest
    rank[reached] = np.arange(len(reached))
    first, second = rank[np.repeat(np.arange(len(height)), np.diff(graph.indptr))], rank[graph.indices]
    is_once = (first < second) & (second < len(height))
    links = np.stack([first[is_once], second[is_once]], axis=1)  # from here on, nodes by their rank
    top = np.arange(len(reached))
    np.minimum.at(top, links[:, 1], links[:, 0])  # the highest neighbor, and on to the peak
    while (top[top] != top).any():
        top = top[top]
    sides = np.sort(top[links], axis=1)
    order = stable_order(links[:, 1])  # the highest pass first
    order = order[sides[order, 0] != sides[order, 1]]
    order = order[np.sort(np.unique(sides[order] @ [len(height), 1], return_index=True)[1])]
    root, lengths = list(range(len(reached))), np.full(len(reached), np.inf)

    def find(node: int) -> int:
        while root[node] != node:
            root[node] = root[root[node]]
            node = root[node]
        return node

    for one, other, low in np.column_stack([sides, links[:, 1]])[order].tolist():
        higher, lower = sorted([find(one), find(other)])
        if higher != lower:
            lengths[lower] = height[reached[lower]] - height[reached[low]]
            root[lower] = higher
    peaks = np.unique(top)
    peaks = peaks[np.argsort(reached[peaks])]
    return reached[peaks], lengths[peaks]


def _is_at_end(graph: csr_array, peak: int, scale: float) -> bool:
    """Whether the cloud leads away from a peak in one direction, as from the end of a limb, and not in two."""
    near, far = SHELL[0] * scale, SHELL[1] * scale
    distances = dijkstra(graph, indices=peak, limit=far)
    shell = np.flatnonzero(np.isfinite(distances) & (distances > near))
    if len(shell) == 0:
        return True
    sizes = np.bincount(connected_components(graph[shell][:, shell], directed=False)[1])
    return int((sizes >= MIN_SHELL_SHARE * len(shell)).sum()) == 1
