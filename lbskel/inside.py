"""Keeping a skeleton inside its surface: nodes pushed in, edges bent round what they would cut across."""

from __future__ import annotations

__all__ = ["keep_inside", "length_inside"]

from dataclasses import replace

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel.quality import sample_edges
from lbskel.skeleton import Skeleton
from lbskel.surface import Surface

SAMPLES = 8  # places along an edge at which it is tested
ROUNDS = 3
LEAST_LENGTH = 1e-12  # added to every edge, since no length would mean no edge
LEAST_DEPTH = 0.01  # of the diagonal


def length_inside(skeleton: Skeleton, surface: Surface) -> float:
    """Share of the length of the edges that lies inside, by samples a four-hundredth of the diagonal apart."""
    if len(skeleton.edges) == 0:
        return float(surface.contains(skeleton.nodes).mean())
    return float(surface.contains(sample_edges(skeleton, surface.mesh.diagonal / 400)[0]).mean())


def _pushed_in(points: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """Each outer point as far inside as it was outside, or a little more, but not past the middle of the shape."""
    _, nearest = surface.closest(points)
    inward = nearest - points
    far = np.linalg.norm(inward, axis=1, keepdims=True)
    inward = np.divide(inward, far, out=np.zeros_like(inward), where=far > 0)
    entry = nearest + 1e-6 * surface.mesh.diagonal * inward
    depth = surface.ahead(entry, inward)
    depth = np.where(np.isfinite(depth), depth, 0.0)
    depth = np.minimum(0.5 * depth, np.maximum(far[:, 0], LEAST_DEPTH * surface.mesh.diagonal))
    return entry + depth[:, None] * inward


def keep_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Push outer nodes in, and bend edges that leave the surface round what they would cut across.

    An edge is first split at a point that is pushed in. One that is still outside after a few rounds spans a gap
    between two parts of the shape, and goes the shortest way along the surface, under it, instead.
    """
    outer = np.flatnonzero(~surface.contains(skeleton.nodes))
    if len(outer):
        P = np.array(skeleton.nodes)
        P[outer] = _pushed_in(P[outer], surface)
        skeleton = replace(skeleton, nodes=P)
    for _ in range(ROUNDS):
        bent, outside, along = _bent(skeleton, surface)
        if len(bent) == 0:
            return skeleton
        weights = outside / outside.sum(axis=1, keepdims=True)
        middles = _pushed_in(np.einsum("es,esi->ei", weights, along), surface)
        skeleton = _with_ways(skeleton, surface, bent, [middle[None] for middle in middles])
    bent, _, _ = _bent(skeleton, surface)
    return _with_ways(skeleton, surface, bent, _under_surface(skeleton, surface, bent))


def _bent(skeleton: Skeleton, surface: Surface) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.float64]]:
    """Edges that are outside somewhere, and for each of them which samples are, and the samples."""
    start, end = skeleton.nodes[skeleton.edges].transpose(1, 0, 2)
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    along = start[:, None, :] + share[:, None] * (end - start)[:, None, :]
    outside = ~surface.contains(along.reshape(-1, 3)).reshape(-1, SAMPLES)
    bent = np.flatnonzero(outside.any(axis=1))
    return bent, outside[bent], along[bent]


def _with_ways(
    skeleton: Skeleton, surface: Surface, edges: NDArray[np.int64], ways: list[NDArray[np.float64]]
) -> Skeleton:
    """Each of the edges replaced by a chain through the points of its way."""
    chains = [np.delete(skeleton.edges, edges, axis=0)]
    n_nodes = len(skeleton.nodes)
    for (start, end), way in zip(skeleton.edges[edges].tolist(), ways, strict=True):
        chain = np.concatenate([[start], n_nodes + np.arange(len(way)), [end]])
        chains.append(np.stack([chain[:-1], chain[1:]], axis=1))
        n_nodes += len(way)
    new = np.concatenate([np.empty((0, 3)), *ways])
    return replace(
        skeleton,
        nodes=np.concatenate([skeleton.nodes, new]),
        edges=np.concatenate(chains),
        radii=np.concatenate([skeleton.radii, surface.distance(new)]) if len(new) else skeleton.radii,
    )


def _under_surface(skeleton: Skeleton, surface: Surface, edges: NDArray[np.int64]) -> list[NDArray[np.float64]]:
    """For each edge, the shortest way along the edges of the mesh, pushed in as deep as its ends lie at most."""
    V, pairs = surface.mesh.vertices, surface.mesh.edges
    lengths = np.linalg.norm(V[pairs[:, 0]] - V[pairs[:, 1]], axis=1)
    graph = coo_array((lengths + LEAST_LENGTH, (pairs[:, 0], pairs[:, 1])), shape=(len(V), len(V))).tocsr()
    inward = -igl.per_vertex_normals(V, surface.mesh.faces, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE)
    if surface.mesh.volume < 0:
        inward = -inward
    ends = cKDTree(V).query(skeleton.nodes[skeleton.edges[edges]])[1].reshape(-1, 2)
    depths = surface.distance(skeleton.nodes)[skeleton.edges[edges]].max(axis=1) if len(edges) else np.empty(0)
    ways = []
    for (start, end), depth in zip(ends.tolist(), depths, strict=True):
        before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)[1]
        walk = [end]
        while walk[-1] != start and before[walk[-1]] >= 0:
            walk.append(int(before[walk[-1]]))
        way = np.array(walk[::-1])
        entry = V[way] + 1e-6 * surface.mesh.diagonal * inward[way]
        chord = surface.ahead(entry, inward[way])
        ways.append(entry + np.minimum(0.5 * np.where(np.isfinite(chord), chord, 0.0), depth)[:, None] * inward[way])
    return ways
