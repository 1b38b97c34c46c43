"""The quality of a skeleton, measured on the points of a cloud alone.

No surface is made: cross-sections are those of :mod:`lbskel.evaluation.point_sections`. The cloud's own graph of
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
from lbskel.evaluation.point_sections import inside_fraction, section_errors, spread
from lbskel.evaluation.skeleton_shape import mean_and_worst_branch, n_spurs, rms_curvature
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import PointCloud
from lbskel.geometry.point_stars import MIN_VARIATION, distinct_points, surface_variation
from lbskel.geometry.sorting import stable_order
from lbskel.skeleton.short_loops import n_opened_loops
from lbskel.skeleton.skeleton import Skeleton

MAX_POINTS, MAX_GRAPH_POINTS = 20_000, 3_000  # of a cloud for sections, and for its ends; guesses that bound the time
# Nearest points of a point, itself included, linked with it where it is one of theirs, as those of an outlier are not;
# a guess
SCORED_NEIGHBORS = 13
# Share of the points below which a part of the cloud counts as outliers or a crumb, and ratio of the distance between
# the points of a part to that of the whole cloud above which the part counts as outliers if it fills space; guesses
MIN_PART, MAX_SPACING = 0.01, 3.0
N_SCALES = 5  # nodes whose median radius is that of an end, so that one point inside does not matter; a guess
N_SOURCES = 30  # points from which distances along the cloud are averaged; a guess
MIN_END, MIN_LIMB = 3.0, 6.0  # length of an end, and of a limb that must have a tip, in local radii; guesses
TIP_REACH, NODE_REACH = 3.0, 2.0  # of an end from its tip, and from any node, in local radii; guesses
# Distances from a peak in local radii, between which the cloud has one part if the peak is an end, and two if it is a
# point of a loop; half the way around a tube is 3.1. A guess
SHELL = (5.0, 7.0)
MIN_SHELL_SHARE = 0.1  # of the points between them, below which a part of them does not count; a guess
MAX_COVERED_DISTANCE = 2.0  # in local radii, as on meshes
MIN_COVERED = 0.5  # share of the points of a part without nodes below which it has no skeleton: most of them; a guess


def score_points(
    skeleton: Skeleton,
    cloud: PointCloud,
    neighbors: NDArray[np.int64] | None = None,
    is_joining: NDArray[np.bool_] | None = None,
) -> Score:
    """Measure a skeleton on a cloud.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the cloud. Its vertex map, if it has one, maps the points; its radii are not used.
    cloud : PointCloud
    neighbors : (n, SCORED_NEIGHBORS) array of int, optional
        The nearest points of each point, itself first, where they are known.
    is_joining : (e,) array of bool, optional
        Edges that joined bodies. They are left out where they join different parts of the cloud.
    """
    has_map = len(skeleton.node_of_vertex) > 0
    tree = PointTree(skeleton.nodes)
    node = skeleton.node_of_vertex if has_map else tree.nearest(cloud.points)[1][:, 0]
    some = cloud.points[spread(cloud.points, MAX_POINTS)]
    # copies of a point would be all of its nearest neighbors
    distinct = some[distinct_points(some)[0]]
    neighbors = neighbors if len(distinct) == len(cloud.points) else None
    points, point_tree, graph, part = _without_outliers(distinct, neighbors)
    to_points, nearest = point_tree.nearest(skeleton.nodes, SCORED_NEIGHBORS)
    if is_joining is not None:
        i, j = part[nearest[skeleton.edges, 0]].T
        skeleton = replace(skeleton, edges=skeleton.edges[~is_joining | (i == j)])
    skeleton = replace(skeleton, radii=to_points[:, 0])
    is_among, errors = section_errors(skeleton, points, point_tree)
    inside = inside_fraction(skeleton, points, point_tree)
    # the distance of a node outside to the points would be the larger, the farther the node is
    radii = np.where(is_among, skeleton.radii, 0.0)
    skeleton = replace(skeleton, radii=radii)
    mean_error, worst_branch_error = mean_and_worst_branch(skeleton, errors)
    distances = np.linalg.norm(cloud.points - skeleton.nodes[node], axis=1)
    widths = _widths(skeleton, node, distances)
    alone = _parts_alone(points, part, nearest[:, 0], MAX_COVERED_DISTANCE * widths, tree)
    # noise makes the distance to the nearest point small, and a limb without a branch makes the width large
    thick = np.where(is_among, np.minimum(widths, to_points[:, -1]), 0.0)
    ends, lengths, scales = _ends(points, graph, np.maximum(thick, skeleton.branch_medians(thick)), tree)
    tips = skeleton.nodes[skeleton.degrees <= 1]
    to_tip = PointTree(tips).nearest(ends)[0][:, 0] if len(tips) else np.full(len(ends), np.inf)
    to_node = tree.nearest(ends)[0][:, 0]
    missed, is_limb = (to_tip > TIP_REACH * scales) & (to_node > NODE_REACH * scales), lengths > MIN_LIMB * scales
    return Score(
        nodes_inside_fraction=float(is_among.mean()),
        inside_fraction=float(is_among.mean()) if inside is None else inside,
        centeredness_error=mean_error,
        centeredness_error_worst_branch=worst_branch_error,
        medial_accuracy_95=None,
        medial_coverage_98=None,
        uncovered_parts=None,
        near_surface_fraction=None,
        coverage=float((distances <= MAX_COVERED_DISTANCE * widths[node]).mean()),
        extremities=len(ends),
        extremities_missed=int(missed.sum()),
        missed_limb_fraction=float(missed[is_limb].mean()) if is_limb.any() else 0.0,
        rms_curvature=rms_curvature(skeleton),
        # a sparse limb may be in several parts
        extra_components=-alone or max(0, skeleton.n_components - int(part.max()) - 1),
        extra_cycles=None,
        tunnels_missed=max(0, count_cut_loops(skeleton, points, graph, tree, point_tree) - n_opened_loops(skeleton)),
        connected_regions=None,
        adjacent_regions=None,
        shortcut_edges=None,
        spurs=n_spurs(skeleton),
    )


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
) -> tuple[NDArray[np.float64], PointTree, csr_array, NDArray[np.int64]]:
    """Points of parts that are no crumbs, their tree, the graph of their neighbors, and the part of each."""
    tree = PointTree(points)
    neighbors = tree.neighbors(SCORED_NEIGHBORS)[1] if neighbors is None else neighbors
    graph = _neighbor_graph(points, neighbors)
    part = connected_components(graph, directed=False)[1]
    count = np.bincount(part)
    is_part = count >= min(MIN_PART * len(points), count.max())
    for number in np.flatnonzero(is_part & (count < count.max())):
        lengths = graph[part == number].data  # none around a point alone
        is_part[number] = len(lengths) and (
            np.median(lengths) <= MAX_SPACING * np.median(graph.data)
            or np.median(surface_variation(points, neighbors[part == number])) <= MIN_VARIATION
        )
    if is_part.all():
        return points, tree, graph, part
    kept = np.flatnonzero(is_part[part])
    return points[kept], PointTree(points[kept]), graph[kept][:, kept], (np.cumsum(is_part) - 1)[part[kept]]


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


def _parts_alone(
    points: NDArray[np.float64],
    part: NDArray[np.int64],
    nearest: NDArray[np.int64],
    reach: NDArray[np.float64],
    tree: PointTree,
) -> int:
    """Count the parts of a cloud without a skeleton: no node is nearest to them, and most points are far from nodes.

    The second condition spares what is a part only because points lie on lines that are far apart, as those of a scan.
    Each node has its nearest point, and the distance up to which it covers points.
    """
    distances, node = (column[:, 0] for column in tree.nearest(points))
    covered = np.bincount(part, distances <= reach[node]) / np.bincount(part)
    return int((covered[np.setdiff1d(part, part[nearest])] < MIN_COVERED).sum())


def _ends(
    points: NDArray[np.float64], graph: csr_array, radii: NDArray[np.float64], tree: PointTree
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(e, 3) ends of the cloud, (e,) length by which each stands out, and (e,) local radius there.

    An end is a peak of the mean distance along the cloud to points spread over it; its length is its height above the
    pass to a higher peak.
    """
    if len(points) > MAX_GRAPH_POINTS:
        points = points[spread(points, MAX_GRAPH_POINTS)]
        graph = _neighbor_graph(points, PointTree(points).neighbors(SCORED_NEIGHBORS)[1])
    part = connected_components(graph, directed=False)[1]
    height = np.full(len(points), -np.inf)
    for number in np.flatnonzero(np.bincount(part) >= MIN_PART * len(points)):
        own = np.flatnonzero(part == number)
        sources = own[np.linspace(0, len(own) - 1, min(N_SOURCES, len(own))).astype(np.int64)]
        height[own] = dijkstra(graph, indices=sources)[:, own].mean(axis=0)
    peaks, lengths = _peaks(graph, height)
    near = tree.nearest(points[peaks], N_SCALES)[1]
    scales = np.median(radii[near], axis=1)
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
