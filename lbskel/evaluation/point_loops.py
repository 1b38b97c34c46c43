"""Loops of a cloud that its skeleton lacks, found on the points alone.

Each point is assigned to the node nearest to it. Where points of two nodes are neighbors, the nodes should be near each
other along the skeleton. Links between points whose nodes are far apart along it have five causes: two limbs that
touch, where the links lie between them; two limbs that part slowly, where the detours along the skeleton grow with the
distance from their junction; the web between two fingers, where the links lie beside the middle of their nodes; a part
of a surface that is nearest to another limb, with points inside its border; and a limb at which the skeleton is cut,
where the links go once around the empty middle of a section, with equal detours. Only the last cause counts.
"""

from __future__ import annotations

__all__ = ["count_cut_loops"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from lbskel._kernels.point_tree import PointTree
from lbskel.geometry.graphs import weighted_graph
from lbskel.skeleton.skeleton import Skeleton

# All constants are swept in benchmarks/results/point_constants.md, "Cut loops".
# Lower bound on the length along the skeleton between the two ends of a cut, in mean distances of its links from its
# middle: half the way around a tube is 3.1, and regions of branches meet beside a junction
MIN_DETOUR = 10.0
# Sectors of a turn around a section, which is also the least number of links that show a cut limb; and upper bound on
# the share of the turn without links in a cut limb
N_SECTORS, MAX_OPEN = 16, 0.35
# Lower bound on the distance of the nearest point from the middle of the links, in their mean distance
MIN_HOLLOW = 0.6
# Upper bound on the difference of the detours of the links, without the highest and lowest tenth, in their mean
# distance from their middle: half the way around a tube, by which the points of one section may lie apart
MAX_SPREAD = np.pi
# Upper bound on the distance of the mean of the links from their middle, in their mean distance: the links of a web
# between two fingers lie beside the middle of their nodes, by hand at 0.57 to 1.5; with 0.35 four more cuts are missed
MAX_OFFSET = 0.5


def count_cut_loops(
    skeleton: Skeleton, points: NDArray[np.float64], graph: csr_array, nodes: PointTree, tree: PointTree
) -> int:
    """Count the limbs of a cloud at which the skeleton is cut, although another part of it joins the two sides.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float
    graph : (n, n) csr_array
        Symmetric; links neighboring points, whose distances are not zero.
    nodes, tree : PointTree
        Of the nodes of the skeleton, and of the points.
    """
    node = nodes.nearest(points)[1][:, 0]
    first, second = np.repeat(np.arange(len(points)), np.diff(graph.indptr)), graph.indices
    is_between = (first < second) & (node[first] != node[second])
    links = np.stack([first[is_between], second[is_between]], axis=1)
    detours = _distances(skeleton, np.sort(node[links], axis=1))
    scale = np.linalg.norm(points[links] - skeleton.nodes[node[links]], axis=2).mean(axis=1)
    # half of the bound, since a link tells the radius but roughly; _is_cut applies it in the mean distance of all links
    is_far = np.isfinite(detours) & (detours > MIN_DETOUR / 2 * scale)
    links, detours = links[is_far], detours[is_far]
    if len(links) < N_SECTORS:
        return 0
    is_near = np.zeros(len(points), dtype=bool)
    is_near[links] = True
    is_near |= graph @ is_near > 0  # with their neighbors, so that the links of a section are in one group
    near = np.flatnonzero(is_near)
    group = connected_components(graph[near][:, near], directed=False)[1][np.searchsorted(near, links[:, 0])]
    return sum(
        _is_cut(points[links[own]].mean(axis=1), skeleton.nodes[node[links[own]]].mean(axis=(0, 1)), detours[own], tree)
        for own in (group == number for number in range(int(group.max()) + 1))
    )


def _distances(skeleton: Skeleton, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """(p,) distances along the skeleton between pairs of nodes."""
    lengths = np.maximum(skeleton.edge_lengths, np.finfo(float).tiny)
    graph = weighted_graph(skeleton.edges, lengths, len(skeleton.nodes))
    sources, row = np.unique(pairs[:, 0], return_inverse=True)
    found = np.empty(len(pairs))
    for first in range(0, len(sources), 500):  # of the rows of a table that could be large
        own = (row >= first) & (row < first + 500)
        table = dijkstra(graph, directed=False, indices=sources[first : first + 500])
        found[own] = table[row[own] - first, pairs[own, 1]]
    return found


def _is_cut(
    places: NDArray[np.float64], middle: NDArray[np.float64], detours: NDArray[np.float64], points: PointTree
) -> bool:
    """Whether links with the given midpoints go once around a middle without points, as around a limb that is cut."""
    if len(places) < N_SECTORS:
        return False
    offsets = places - middle
    across = np.linalg.svd(places - places.mean(axis=0), full_matrices=False)[2][:2]
    x, y = across @ offsets.T
    radius = np.hypot(x, y).mean()
    if np.linalg.norm(offsets.mean(axis=0)) > MAX_OFFSET * radius:
        return False
    low, median, high = np.quantile(detours, [0.1, 0.5, 0.9])
    if median <= MIN_DETOUR * radius or high - low > MAX_SPREAD * radius:
        return False
    if points.nearest(middle[None])[0][0, 0] < MIN_HOLLOW * radius:
        return False
    sectors = np.unique(((np.arctan2(y, x) / (2 * np.pi) + 0.5) * N_SECTORS).astype(np.int64) % N_SECTORS)
    gap = int(np.diff(np.append(sectors, sectors[0] + N_SECTORS)).max()) - 1
    return gap <= MAX_OPEN * N_SECTORS
