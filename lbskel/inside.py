"""Keeping a skeleton inside its surface: what would cut across the outside is led another way."""

from __future__ import annotations

__all__ = ["keep_inside", "leaves", "length_inside", "ways_inside"]

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel.sampling import sample_edges
from lbskel.skeleton import Skeleton
from lbskel.surface import Surface

SAMPLES = 12  # places along an edge at which it is tested
JOINED = 4  # edges at most from one that leaves the shape to the next for both to be led another way together
SMOOTHINGS = 10
LEAST_LENGTH = 1e-12  # added to every edge, since no length would mean no edge
LEAST_DEPTH = 0.01  # of the extent


def length_inside(skeleton: Skeleton, surface: Surface) -> float:
    """Share of the length of the edges that lies inside, by samples along those that leave the surface somewhere."""
    if len(skeleton.edges) == 0:
        return float(surface.contains(skeleton.nodes).mean())
    is_bent = leaves(skeleton.nodes, skeleton.edges, surface)
    if not (is_bent.any() and skeleton.length > 0):
        return float(1 - is_bent.mean())
    points, _ = sample_edges(replace(skeleton, edges=skeleton.edges[is_bent]), surface.mesh.extent / 400)
    share_bent = skeleton.edge_lengths[is_bent].sum() / skeleton.length
    return float(1 - share_bent * (1 - surface.contains(points).mean()))


def _pushed_in(points: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """Each outer point as far inside as it was outside, or a little more, but not past the middle of the shape."""
    _, nearest = surface.closest(points)
    inward = nearest - points
    far = np.linalg.norm(inward, axis=1, keepdims=True)
    inward = np.divide(inward, far, out=np.zeros_like(inward), where=far > 0)
    entry = nearest + 1e-6 * surface.mesh.extent * inward
    depth = surface.ahead(entry, inward)
    depth = np.where(np.isfinite(depth), depth, 0.0)
    depth = np.minimum(0.5 * depth, np.maximum(far[:, 0], LEAST_DEPTH * surface.mesh.extent))
    return entry + depth[:, None] * inward


def keep_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Lead every stretch of a branch that leaves the surface another way, inside.

    Junctions and tips outside are pushed in. A stretch from one inner node to the next then goes straight where that
    stays inside, or else the shortest way under the surface.
    """
    P = np.array(skeleton.nodes)
    ends = np.flatnonzero(skeleton.degrees != 2)
    outer = ends[~surface.contains(P[ends])]
    P[outer] = _pushed_in(P[outer], surface)
    skeleton = replace(skeleton, nodes=P)
    is_bent = leaves(skeleton.nodes, skeleton.edges, surface)
    if not is_bent.any():
        return skeleton
    bent = {tuple(edge) for edge in skeleton.edges[is_bent].tolist()}
    stretches = [stretch for branch in skeleton.branches for stretch in _stretches(branch, bent)]
    ways = ways_inside(skeleton.nodes, np.array([(stretch[0], stretch[-1]) for stretch in stretches]), surface)
    return _rerouted(skeleton, surface, stretches, ways)


def leaves(nodes: NDArray[np.float64], edges: NDArray[np.int64], surface: Surface) -> NDArray[np.bool_]:
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


def ways_inside(P: NDArray[np.float64], pairs: NDArray[np.int64], surface: Surface) -> list[NDArray[np.float64]]:
    """For each pair of points those between them on a way that stays inside, one in the middle if it is straight.

    Otherwise the way runs along the edges of the mesh, its vertices pushed in to half the thickness of the shape, but
    no deeper than the nodes lie at most.
    """
    is_outside = leaves(P, pairs, surface)
    if not is_outside.any():
        return list(P[pairs].mean(axis=1, keepdims=True))
    V, edges = surface.rough.mesh.vertices, surface.rough.mesh.edges
    entry, inward, thickness = surface.rough.inward
    depths = surface.distance(P)[pairs].max(axis=1)
    ways = []
    for (start, end), depth, goes_out in zip(pairs.tolist(), depths, is_outside, strict=True):
        if not goes_out:
            ways.append(P[[start, end]].mean(axis=0, keepdims=True))
            continue
        under = entry + np.minimum(thickness / 2, depth)[:, None] * inward
        lengths = np.linalg.norm(under[edges[:, 0]] - under[edges[:, 1]], axis=1) + LEAST_LENGTH
        graph = coo_array((lengths, (edges[:, 0], edges[:, 1])), shape=(len(V), len(V))).tocsr()
        first, last = cKDTree(under).query(P[[start, end]])[1].tolist()
        before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
        walk = [last]
        while walk[-1] != first and before[walk[-1]] >= 0:
            walk.append(int(before[walk[-1]]))
        ways.append(_smoothed(np.concatenate([P[[start]], under[walk[::-1]], P[[end]]]), surface)[1:-1])
    return ways


def _smoothed(way: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """The way with each point at the mean of itself and its neighbours, as long as that is inside; its ends stay."""
    steps = np.stack([np.arange(len(way) - 1), np.arange(1, len(way))], axis=1)
    for _ in range(SMOOTHINGS):
        mean = np.array(way)
        mean[1:-1] = (way[:-2] + way[1:-1] + way[2:]) / 3
        if leaves(mean, steps, surface).any():
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
    edges = np.concatenate([kept, *chains]).astype(np.int64)
    stays = np.concatenate([target == np.arange(len(target)), np.ones(n_nodes - len(target), dtype=bool)])
    new_of = np.cumsum(stays) - 1
    return replace(
        skeleton,
        nodes=nodes[stays],
        edges=new_of[edges],
        radii=surface.distance(nodes[stays]),
        anchors=new_of[target[skeleton.anchors]],
        node_of_vertex=new_of[target[skeleton.node_of_vertex]],
    )
