"""Missing branches: a branch is grown along every limb that contraction has left without one.

A limb that is short, or thin relative to the contracted faces, may be pulled into the body before it becomes a line.
Its end is found on the surface (:mod:`lbskel.refinement.extrema`), and its axis from the distance to that end
(:mod:`lbskel.refinement.level_sets`).
"""

from __future__ import annotations

__all__ = ["grow_missing_branches"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import GeodesicExtrema, find_extrema, is_missed
from lbskel.refinement.level_sets import find_geodesic_caps, interior_axes
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import extend_ends, recenter_points, trace_centerline
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

MIN_SHARE = 0.5  # fraction of a limb's vertices mapped to an end branch above which the branch is the limb's; a guess,
# benchmarks/results/constants.md


def grow_missing_branches(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb whose end is outside the skeleton's balls and has no tip near it.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    proxy_mesh = surface.proxy.mesh
    extrema = find_extrema(proxy_mesh, deadline=surface.deadline)
    missed = is_missed(extrema, proxy_mesh, inscribed_radii(skeleton, surface.proxy))
    is_on_missed = np.isin(extrema.limb_of_vertex, np.flatnonzero(missed))
    limb_of_vertex = np.where(is_on_missed, extrema.limb_of_vertex, -1)
    caps = find_geodesic_caps(proxy_mesh, limb_of_vertex)
    clipped = zip(caps, interior_axes(list(caps.values()), surface), strict=True)
    axes = {limb: axis for limb, axis in clipped if len(axis) >= 2}
    if not axes:
        return skeleton
    skeleton = _without_misplaced_ends(skeleton, surface, extrema, missed, list(axes))
    centered = recenter_points(list(axes.values()), surface)
    onward = trace_centerline(
        surface, np.array([axis[-1] for axis in centered]), np.array([axis[-1] - axis[-2] for axis in centered])
    )
    node_of_vertex, limb_of_full_vertex = np.array(skeleton.node_of_vertex), surface.from_proxy(limb_of_vertex)
    nearby = _nodes_near_limbs(surface.on_proxy(skeleton.node_of_vertex), limb_of_vertex, proxy_mesh)
    start_of_limb = np.full(len(extrema.radii), -1)
    starts: list[int] = []
    paths: list[list[NDArray[np.float64]]] = []
    for limb, axis, continuation in zip(axes, centered, onward, strict=True):
        path = np.array([*axis, *continuation])
        candidates = nearby[limb]
        distances = cdist(path, skeleton.nodes[candidates])
        touching = np.flatnonzero(distances.min(axis=1) <= extrema.radii[limb])
        first = touching[-1] + 1 if len(touching) else 0
        start = candidates[distances[max(first - 1, 0)].argmin()]
        if first < len(path):
            start_of_limb[limb] = start
            starts.append(start)
            paths.append(list(path[first:]))
    is_grown = (limb_of_full_vertex >= 0) & (start_of_limb[limb_of_full_vertex] >= 0)
    node_of_vertex[is_grown] = start_of_limb[limb_of_full_vertex[is_grown]]
    skeleton = replace(skeleton, node_of_vertex=node_of_vertex)
    return extend_ends(skeleton, surface, np.array(starts, dtype=np.int64), paths)


def _without_misplaced_ends(
    skeleton: Skeleton, surface: Surface, extrema: GeodesicExtrema, missed: NDArray[np.bool_], limbs: list[int]
) -> Skeleton:
    """Cut back the end branches to which the vertices of a missed limb are mapped, but which end elsewhere.

    Each is cut back to the node before the first that has vertices of the limb. A branch is kept if its tip is the one
    nearest to an end that is not missed.
    """
    node_of_vertex, tips = surface.on_proxy(skeleton.node_of_vertex), skeleton.tips
    reached = surface.proxy.mesh.vertices[extrema.vertices[~missed]]
    taken = tips[cdist(reached, skeleton.nodes[tips]).argmin(axis=1)] if len(reached) and len(tips) else tips[:0]
    target = np.arange(len(skeleton.nodes))
    branches = [branch for branch in skeleton.end_branches if branch[-1] not in taken]
    branch_of_node = np.full(len(skeleton.nodes), -1)
    for index, branch in enumerate(branches):
        branch_of_node[branch[1:]] = index
    nodes_of_limb = np.split(*_grouped(extrema.limb_of_vertex, node_of_vertex, len(extrema.radii)))
    is_cut = np.zeros(len(branches), dtype=bool)
    for limb in limbs:
        nodes = nodes_of_limb[limb]
        found, counts = np.unique(branch_of_node[nodes], return_counts=True)
        row = int(found[counts.argmax()])
        if row < 0 or is_cut[row] or not counts.max() > MIN_SHARE * len(nodes):
            continue
        first = np.flatnonzero(np.isin(branches[row][1:], nodes))[0]
        target[branches[row][first + 1 :]] = branches[row][first]
        is_cut[row] = True
    return contract_nodes(skeleton, target)


def _grouped(
    group: NDArray[np.int64], values: NDArray[np.int64], n_groups: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Values sorted by their group, without those of negative groups, and where all groups but the first begin."""
    order = np.argsort(group, kind="stable")
    order = order[group[order] >= 0]
    return values[order], np.searchsorted(group[order], np.arange(1, n_groups))


def _nodes_near_limbs(
    node_of_vertex: NDArray[np.int64], limb_of_vertex: NDArray[np.int64], mesh: Mesh
) -> dict[int, NDArray[np.int64]]:
    """For each limb, the nodes of its vertices and of those adjacent to them, in ascending order."""
    i, j = mesh.edges.T
    limbs = limb_of_vertex[np.concatenate([i, j, i, j])]
    nodes = node_of_vertex[np.concatenate([i, j, j, i])]
    pairs = np.unique(np.stack([limbs, nodes], axis=1)[limbs >= 0], axis=0)
    limbs, first = np.unique(pairs[:, 0], return_index=True)
    return dict(zip(limbs.tolist(), np.split(pairs[:, 1], first[1:]), strict=True))
