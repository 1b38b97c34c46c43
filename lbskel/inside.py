"""Keeping a skeleton inside its surface: nodes pushed in, edges bent round what they would cut across."""

from __future__ import annotations

__all__ = ["keep_inside", "length_inside"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.quality import sample_edges
from lbskel.skeleton import Skeleton
from lbskel.surface import Surface

SAMPLES = 8  # places along an edge at which it is tested
ROUNDS = 5
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
    """Push outer nodes in, and split edges that leave the surface at a point that is pushed in.

    What cannot be brought in within a few rounds stays where it is.
    """
    outer = np.flatnonzero(~surface.contains(skeleton.nodes))
    if len(outer):
        P = np.array(skeleton.nodes)
        P[outer] = _pushed_in(P[outer], surface)
        skeleton = replace(skeleton, nodes=P)
    for _ in range(ROUNDS):
        start, end = skeleton.nodes[skeleton.edges].transpose(1, 0, 2)
        share = (np.arange(SAMPLES) + 0.5) / SAMPLES
        along = start[:, None, :] + share[:, None] * (end - start)[:, None, :]
        outside = ~surface.contains(along.reshape(-1, 3)).reshape(-1, SAMPLES)
        bent = np.flatnonzero(outside.any(axis=1))
        if len(bent) == 0:
            break
        weights = outside[bent] / outside[bent].sum(axis=1, keepdims=True)
        middle = _pushed_in(np.einsum("es,esi->ei", weights, along[bent]), surface)
        new = len(skeleton.nodes) + np.arange(len(bent))
        i, j = skeleton.edges[bent].T
        edges = [np.delete(skeleton.edges, bent, axis=0), np.stack([i, new], axis=1), np.stack([j, new], axis=1)]
        skeleton = replace(
            skeleton,
            nodes=np.concatenate([skeleton.nodes, middle]),
            edges=np.concatenate(edges),
            radii=np.concatenate([skeleton.radii, surface.distance(middle)]),
        )
    return skeleton
