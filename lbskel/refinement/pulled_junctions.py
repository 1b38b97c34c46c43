"""Junctions that contraction has pulled into another part of the solid, such as that of a head into the chest.

Contraction draws a short, thick part into a thicker one beside it. The junction of the part would then be merged with
that of the other, though their regions on the surface are apart. It is moved back to the centroid of its region.
"""

from __future__ import annotations

__all__ = ["move_pulled_junctions_back"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.weights import ring_areas
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import paths_outside
from lbskel.refinement.radii import mean_radii
from lbskel.refinement.tunnel_sides import keep_sides
from lbskel.skeleton.pruning import inner_branch_lengths
from lbskel.skeleton.skeleton import Skeleton

# Distance of a pulled junction from the centroid of its region, in mean radii of the junction. Rows "shift of" in
# benchmarks/results/refinement.md; by hand, with 0.6 the junction of a noisy hand moved too (0.031 -> 0.068)
MIN_SHIFT = 0.65
# Depth of that centroid below the surface, in mean distances of the region from it: else the region is flat, or bent
# around something. Rows "depth of" there; by hand, without it that of the coarse dinosaur moved (0.051 -> 0.100)
MIN_DEPTH = 0.3


def move_pulled_junctions_back(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move junctions that would be merged, though their regions are apart, to the centroids of their regions.

    Nodes of the branches that end there are moved in proportion to their distance from the other end. A junction stays
    if a branch to another junction would leave a closed surface, or pass another side of a tunnel.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, and a node for each vertex of the mesh.
    surface : Surface
        Two junctions would be merged if the branch between them is shorter than the larger of their radii.
    """
    lengths, ends = inner_branch_lengths(skeleton)
    limits = skeleton.radii[ends].max(axis=1)
    is_short = lengths < limits
    if not is_short.any():
        return skeleton
    centroids, distances = _regions(skeleton, surface.mesh)
    is_apart = np.linalg.norm(centroids[ends[:, 0]] - centroids[ends[:, 1]], axis=1) >= limits
    junctions = np.unique(ends[is_short & is_apart])
    radii, places = mean_radii(skeleton, surface.mesh).radii[junctions], centroids[junctions]
    is_pulled = np.linalg.norm(places - skeleton.nodes[junctions], axis=1) > MIN_SHIFT * radii
    is_pulled &= surface.contains(places) & (surface.distance(places) >= MIN_DEPTH * distances[junctions])
    if not is_pulled.any():
        return skeleton
    moves = np.zeros_like(skeleton.nodes)
    moves[junctions[is_pulled]] = (places - skeleton.nodes[junctions])[is_pulled]
    branches = [branch for branch in skeleton.branches if moves[branch[[0, -1]]].any()]
    nodes = _moved(skeleton.nodes, moves, branches)
    if surface.mesh.is_closed:
        inner = [branch for branch in branches if (skeleton.degrees[branch[[0, -1]]] >= 3).all()]
        leaves = paths_outside([nodes[branch] for branch in inner], surface)
        leaves &= ~paths_outside([skeleton.nodes[branch] for branch in inner], surface)
        for row in np.flatnonzero(leaves).tolist():
            moves[inner[row][[0, -1]]] = 0.0
        nodes = _moved(skeleton.nodes, moves, branches)
    return replace(skeleton, nodes=keep_sides(skeleton, nodes, surface))


def _regions(skeleton: Skeleton, mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) centroid of the region of each node, the node if it has none, and (k,) mean distance of the region."""
    node, k, areas = skeleton.node_of_vertex, len(skeleton.nodes), ring_areas(mesh)
    total = np.bincount(node, areas, k)
    share = np.divide(areas, total[node], out=np.zeros(len(node)), where=total[node] > 0)
    centroids: NDArray[np.float64] = np.stack([np.bincount(node, share * x, k) for x in mesh.vertices.T], axis=1)
    centroids[total == 0] = skeleton.nodes[total == 0]
    from_centroid = np.linalg.norm(mesh.vertices - centroids[node], axis=1)
    distances = np.bincount(node, share * from_centroid, k).astype(np.float64)
    return centroids, distances


def _moved(
    nodes: NDArray[np.float64], moves: NDArray[np.float64], branches: list[NDArray[np.int64]]
) -> NDArray[np.float64]:
    """(n, 3) nodes after the moves of the ends of branches, between which their inner nodes are interpolated."""
    moved = nodes + moves
    for branch in branches:
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(nodes[branch], axis=0), axis=1)))
        first, last = moves[branch[[0, -1]]]
        inner, share = branch[1:-1], along[1:-1, None] / max(along[-1], np.finfo(np.float64).tiny)
        moved[inner] = nodes[inner] + (1 - share) * first + share * last
    return moved
