"""Keeping a skeleton inside its surface: what would cut across the outside is led another way."""

from __future__ import annotations

__all__ = ["inside_fraction", "interior_paths", "reroute_inside", "segments_outside"]

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.edge_sampling import sample_edges
from lbskel.skeleton.skeleton import Skeleton

SAMPLES = 12  # places along an edge at which it is tested
JOINED = 4  # edges at most from one that leaves the shape to the next for both to be led another way together
SMOOTHINGS = 10
LEAST_LENGTH = 1e-12  # added to every edge, since no length would mean no edge
LEAST_DEPTH = 0.01  # of the extent
AT_FIRST = 2.0  # times half the gap and the depth, within which a way round it is looked for first


def inside_fraction(skeleton: Skeleton, surface: Surface) -> float:
    """Share of the length of the edges that lies inside, by samples along those that leave the surface somewhere."""
    if len(skeleton.edges) == 0:
        return float(surface.contains(skeleton.nodes).mean())
    is_bent = segments_outside(skeleton.nodes, skeleton.edges, surface)
    if not (is_bent.any() and skeleton.length > 0):
        return float(1 - is_bent.mean())
    points, _ = sample_edges(replace(skeleton, edges=skeleton.edges[is_bent]), surface.mesh.diameter_bound / 400)
    share_bent = skeleton.edge_lengths[is_bent].sum() / skeleton.length
    return float(1 - share_bent * (1 - surface.contains(points).mean()))


def _pushed_in(points: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """Each outer point as far inside as it was outside, or a little more, but not past the middle of the shape."""
    _, nearest = surface.closest(points)
    inward = nearest - points
    far = np.linalg.norm(inward, axis=1, keepdims=True)
    inward = np.divide(inward, far, out=np.zeros_like(inward), where=far > 0)
    entry = nearest + 1e-6 * surface.mesh.diameter_bound * inward
    depth = surface.ray_distance(entry, inward)
    depth = np.where(np.isfinite(depth), depth, 0.0)
    depth = np.minimum(0.5 * depth, np.maximum(far[:, 0], LEAST_DEPTH * surface.mesh.diameter_bound))
    return entry + depth[:, None] * inward


def reroute_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Lead every stretch of a branch that leaves the surface another way, inside.

    Junctions and tips outside are pushed in. A stretch from one inner node to the next then goes straight where that
    stays inside, or else the shortest way under the surface.
    """
    P = np.array(skeleton.nodes)
    ends = np.flatnonzero(skeleton.degrees != 2)
    outer = ends[~surface.contains(P[ends])]
    P[outer] = _pushed_in(P[outer], surface)
    skeleton = replace(skeleton, nodes=P)
    is_bent = segments_outside(skeleton.nodes, skeleton.edges, surface)
    if not is_bent.any():
        return skeleton
    bent = {tuple(edge) for edge in skeleton.edges[is_bent].tolist()}
    stretches = [stretch for branch in skeleton.branches for stretch in _stretches(branch, bent)]
    ways = interior_paths(skeleton.nodes, np.array([(stretch[0], stretch[-1]) for stretch in stretches]), surface)
    return _rerouted(skeleton, surface, stretches, ways)


def segments_outside(nodes: NDArray[np.float64], edges: NDArray[np.int64], surface: Surface) -> NDArray[np.bool_]:
    """(m,) which edges between (n, 3) nodes are outside somewhere."""
    P, Q = nodes[edges].transpose(1, 0, 2)
    is_inside = surface.contains(nodes)
    is_outside = ~(is_inside[edges[:, 0]] & is_inside[edges[:, 1]])
    clear = surface.clearance(nodes)[edges].sum(axis=1)
    crosses = np.flatnonzero(~is_outside & (np.linalg.norm(Q - P, axis=1) >= clear))  # the balls do not cover it
    share = ((np.arange(SAMPLES) + 0.5) / SAMPLES)[:, None]
    along = P[crosses, None] + share * (Q - P)[crosses, None]
    is_outside[crosses] = ~surface.contains(along.reshape(-1, 3)).reshape(-1, SAMPLES).all(axis=1)
    return is_outside


def _stretches(branch: NDArray[np.int64], bent: set[tuple[int, int]]) -> list[NDArray[np.int64]]:
    """The runs of nodes whose edges leave the surface, those that all but touch joined to one."""
    is_bent = np.array([(min(a, b), max(a, b)) in bent for a, b in itertools.pairwise(branch.tolist())])
    at = np.flatnonzero(is_bent)
    runs = np.split(at, np.flatnonzero(np.diff(at) > JOINED) + 1) if len(at) else []
    stretches = [branch[run[0] : run[-1] + 2] for run in runs]
    if len(stretches) == 1 and stretches[0][0] == stretches[0][-1]:  # all of a loop, which has to stay one
        third = len(branch) // 3
        return [branch[: third + 1], branch[third : 2 * third + 1], branch[2 * third :]]
    return stretches


def interior_paths(P: NDArray[np.float64], pairs: NDArray[np.int64], surface: Surface) -> list[NDArray[np.float64]]:
    """For each pair of points those between them on a way that stays inside, one in the middle if it is straight.

    Otherwise the way runs along the edges of the mesh, its vertices pushed in to half the thickness of the shape, but
    no deeper than the nodes lie at most.
    """
    is_outside = segments_outside(P, pairs, surface)
    if not is_outside.any():
        return list(P[pairs].mean(axis=1, keepdims=True))
    depths = surface.distance(P)[pairs].max(axis=1)
    return [
        _smoothed(np.concatenate([ends[:1], _under(ends[0], ends[1], depth, surface.proxy), ends[1:]]), surface)[1:-1]
        if goes_out
        else ends.mean(axis=0, keepdims=True)
        for ends, depth, goes_out in zip(P[pairs], depths, is_outside, strict=True)
    ]


def _under(start: NDArray[np.float64], end: NDArray[np.float64], depth: float, surface: Surface) -> NDArray[np.float64]:
    """The shortest way under the surface from near one point to near another, as :func:`interior_paths` says.

    It is looked for about the two, further and further: once it is shorter than any that leads out of where it was
    looked for, it is the shortest of all.
    """
    V, edges, middle = surface.mesh.vertices, surface.mesh.edges, (start + end) / 2
    far, half = np.linalg.norm(V - middle, axis=1), float(np.linalg.norm(end - start)) / 2
    reach = AT_FIRST * max(half + depth, LEAST_DEPTH * surface.mesh.diameter_bound)
    while True:
        near = np.flatnonzero(far <= reach)
        is_all, outer = (
            len(near) == len(V),
            reach - depth,
        )  # how far what is not looked at lies from the middle at least
        if len(near):
            entry, inward, thickness = surface.inner_offset(near)
            under = entry + np.minimum(thickness / 2, depth)[:, None] * inward
            (off_start, off_end), (first, last) = cKDTree(under).query([start, end])
            number = np.full(len(V), -1)
            number[near] = np.arange(len(near))
            here = number[edges[(far[edges] <= reach).all(axis=1)]]
            lengths = np.linalg.norm(under[here[:, 0]] - under[here[:, 1]], axis=1) + LEAST_LENGTH
            graph = weighted_graph(here, lengths, len(near))
            length, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
            out = 2 * outer - np.linalg.norm(under[[first, last]] - middle, axis=1).sum()
            if is_all or (max(off_start, off_end) <= outer - half and length[last] <= out):
                break
        reach *= 2
    walk = [int(last)]
    while walk[-1] != first and before[walk[-1]] >= 0:
        walk.append(int(before[walk[-1]]))
    return under[walk[::-1]]


def _smoothed(way: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """The way with each point at the mean of itself and its neighbors, as long as that is inside; its ends stay."""
    steps = np.stack([np.arange(len(way) - 1), np.arange(1, len(way))], axis=1)
    for _ in range(SMOOTHINGS):
        mean = np.array(way)
        mean[1:-1] = (way[:-2] + way[1:-1] + way[2:]) / 3
        if segments_outside(mean, steps, surface).any():
            break
        way = mean
    return way


def _rerouted(
    skeleton: Skeleton, surface: Surface, stretches: list[NDArray[np.int64]], ways: list[NDArray[np.float64]]
) -> Skeleton:
    """The skeleton with the inner nodes of each stretch replaced by its way; their vertices go to its first node."""
    target = np.arange(len(skeleton.nodes))
    dropped: set[tuple[int, int]] = set()
    chains, n_nodes = [], len(skeleton.nodes)
    for stretch, way in zip(stretches, ways, strict=True):
        target[stretch[1:-1]] = stretch[0]
        dropped.update((min(a, b), max(a, b)) for a, b in itertools.pairwise(stretch.tolist()))
        chain = np.concatenate([stretch[:1], n_nodes + np.arange(len(way)), stretch[-1:]])
        chains.append(np.stack([chain[:-1], chain[1:]], axis=1))
        n_nodes += len(way)
    kept = np.array([edge for edge in skeleton.edges.tolist() if tuple(edge) not in dropped]).reshape(-1, 2)
    nodes = np.concatenate([skeleton.nodes, *ways])
    outer = np.flatnonzero(~surface.contains(nodes))
    nodes[outer] = _pushed_in(nodes[outer], surface)
    radii = np.concatenate([skeleton.radii, np.zeros(n_nodes - len(target))])
    moved = np.union1d(outer, np.arange(len(target), n_nodes))
    radii[moved] = surface.distance(nodes[moved])
    edges = np.concatenate([kept, *chains]).astype(np.int64)
    stays = np.concatenate([target == np.arange(len(target)), np.ones(n_nodes - len(target), dtype=bool)])
    new_of = np.cumsum(stays) - 1
    return replace(
        skeleton,
        nodes=nodes[stays],
        edges=new_of[edges],
        radii=radii[stays],
        anchors=new_of[target[skeleton.anchors]],
        node_of_vertex=new_of[target[skeleton.node_of_vertex]],
    )
