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
from lbskel.refinement.level_sets import find_geodesic_caps
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import clip_to_interior, extend_ends, recenter_points, trace_centerline
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
    extrema = find_extrema(proxy_mesh)
    missed = is_missed(extrema, proxy_mesh, inscribed_radii(skeleton, surface.proxy))
    is_on_missed = np.isin(extrema.limb_of_vertex, np.flatnonzero(missed))
    limb_of_vertex = np.where(is_on_missed, extrema.limb_of_vertex, -1)
    caps = find_geodesic_caps(proxy_mesh, limb_of_vertex)
    axes = {limb: axis for limb, cap in caps.items() if len(axis := clip_to_interior(cap, surface)) >= 2}
    if not axes:
        return skeleton
    skeleton = _without_misplaced_ends(skeleton, surface, extrema, missed, list(axes))
    centered = recenter_points(list(axes.values()), surface)
    onward = trace_centerline(
        surface, np.array([axis[-1] for axis in centered]), np.array([axis[-1] - axis[-2] for axis in centered])
    )
    node_of_vertex, limb_of_full_vertex = np.array(skeleton.node_of_vertex), surface.from_proxy(limb_of_vertex)
    starts: list[int] = []
    paths: list[list[NDArray[np.float64]]] = []
    for limb, axis, continuation in zip(axes, centered, onward, strict=True):
        path = np.array([*axis, *continuation])
        nearby = surface.on_proxy(skeleton.node_of_vertex)[_with_adjacent(limb_of_vertex == limb, proxy_mesh)]
        candidates = np.unique(nearby)
        distances = cdist(path, skeleton.nodes[candidates])
        touching = np.flatnonzero(distances.min(axis=1) <= extrema.radii[limb])
        first = touching[-1] + 1 if len(touching) else 0
        start = candidates[distances[max(first - 1, 0)].argmin()]
        if first < len(path):
            node_of_vertex[limb_of_full_vertex == limb] = start
            starts.append(start)
            paths.append(list(path[first:]))
    skeleton = replace(skeleton, node_of_vertex=node_of_vertex)
    return extend_ends(skeleton, surface, np.array(starts, dtype=np.int64), paths)


def _without_misplaced_ends(
    skeleton: Skeleton, surface: Surface, extrema: GeodesicExtrema, missed: NDArray[np.bool_], limbs: list[int]
) -> Skeleton:
    """Cut back end branches to which the vertices of a missed limb are mapped but which end elsewhere.

    Each is cut back to the node before the first that has vertices of the limb. The tip nearest to an end that is not
    missed belongs to that end.
    """
    node_of_vertex, tips = surface.on_proxy(skeleton.node_of_vertex), skeleton.tips
    reached = surface.proxy.mesh.vertices[extrema.vertices[~missed]]
    taken = tips[cdist(reached, skeleton.nodes[tips]).argmin(axis=1)] if len(reached) and len(tips) else tips[:0]
    target = np.arange(len(skeleton.nodes))
    for branch in skeleton.end_branches:
        if branch[-1] in taken:
            continue
        for limb in limbs:
            nodes_of_limb = node_of_vertex[extrema.limb_of_vertex == limb]
            if np.isin(nodes_of_limb, branch[1:]).mean() > MIN_SHARE:
                first = np.flatnonzero(np.isin(branch[1:], nodes_of_limb))[0]
                target[branch[first + 1 :]] = branch[first]
                break
    return contract_nodes(skeleton, target)


def _with_adjacent(is_chosen: NDArray[np.bool_], mesh: Mesh) -> NDArray[np.bool_]:
    """(n,) the chosen vertices and those adjacent to them."""
    is_near = np.array(is_chosen)
    is_near[mesh.edges[is_chosen[mesh.edges].any(axis=1)]] = True
    return is_near
