"""Limbs that contraction has left without a branch: one is grown along each.

A limb that is short, or thin beside the faces that were contracted, may be drawn into the body before it has become a
line. Its end is found on the surface (:mod:`lbskel.refinement.extrema`), its axis from that end (:mod:`lbskel.refinement.level_sets`).
"""

from __future__ import annotations

__all__ = ["grow_missing_branches"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import inscribed_radii, mean_radii
from lbskel.refinement.extrema import GeodesicExtrema, find_extrema, is_missed
from lbskel.refinement.level_sets import find_geodesic_caps
from lbskel.refinement.tips import append_paths, clip_to_interior, recenter_points, trace_centerline
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

STRAY = 0.5  # share of a limb's vertices from which on the branch that stands for them is the limb's


def grow_missing_branches(skeleton: Skeleton, surface: Surface, *, ratio: float = 1.5) -> Skeleton:
    """A branch for each limb that stands out of the skeleton and has no tip near its end.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    ratio : float
        The end of a limb is further than so many local radii from the node that the branch begins at, as in
        :func:`lbskel.skeleton.pruning.prune`.
    """
    mesh = surface.proxy.mesh
    found = find_extrema(mesh)
    missed = is_missed(found, mesh, inscribed_radii(skeleton, surface.proxy))
    limb_of_vertex = np.where(np.isin(found.limb_of_vertex, np.flatnonzero(missed)), found.limb_of_vertex, -1)
    axes = {
        number: clip_to_interior(limb, surface) for number, limb in find_geodesic_caps(mesh, limb_of_vertex).items()
    }
    axes = {number: axis for number, axis in axes.items() if len(axis) >= 2}
    if not axes:
        return skeleton
    skeleton, strayed = _without_strays(skeleton, surface, found, missed, list(axes))
    widths = mean_radii(skeleton, surface.mesh).radii
    centers = recenter_points(list(axes.values()), surface)
    onward = trace_centerline(
        surface, np.array([way[-1] for way in centers]), np.array([way[-1] - way[-2] for way in centers])
    )
    node_of_vertex, full_limb = np.array(skeleton.node_of_vertex), surface.from_proxy(limb_of_vertex)
    bases, ways = [], []
    for number, center, path in zip(axes, centers, onward, strict=True):
        way = np.array([*center, *path])
        near = np.unique(surface.on_proxy(skeleton.node_of_vertex)[_with_border(limb_of_vertex == number, mesh)])
        apart = cdist(way, skeleton.nodes[near])
        leaves = np.flatnonzero(apart.min(axis=1) <= found.radii[number])
        first = leaves[-1] + 1 if len(leaves) else 0
        base = near[apart[max(first - 1, 0)].argmin()]
        far = np.linalg.norm(mesh.vertices[found.vertices[number]] - skeleton.nodes[base])
        if first < len(way) and (number in strayed or far > ratio * widths[base]):
            node_of_vertex[full_limb == number] = base
            bases.append(base)
            ways.append(list(way[first:]))
    skeleton = replace(skeleton, node_of_vertex=node_of_vertex)
    return append_paths(skeleton, surface, np.array(bases, dtype=np.int64), ways)


def _without_strays(
    skeleton: Skeleton, surface: Surface, found: GeodesicExtrema, missed: NDArray[np.bool_], limbs: list[int]
) -> tuple[Skeleton, list[int]]:
    """End branches that stand for one of these limbs but end elsewhere cut back to where they begin to, and the limbs.

    The tip nearest to the end of another limb is that one's.
    """
    node, tips = surface.on_proxy(skeleton.node_of_vertex), skeleton.tips
    reached = surface.proxy.mesh.vertices[found.vertices[~missed]]
    taken = tips[cdist(reached, skeleton.nodes[tips]).argmin(axis=1)] if len(reached) and len(tips) else tips[:0]
    target, strayed = np.arange(len(skeleton.nodes)), []
    for way in skeleton.end_branches:
        if way[-1] in taken:
            continue
        for limb in limbs:
            mine = node[found.limb_of_vertex == limb]
            if np.isin(mine, way[1:]).mean() > STRAY:
                stands = np.flatnonzero(np.isin(way[1:], mine))
                target[way[stands[0] + 1 :]] = way[stands[0]]
                strayed.append(limb)
                break
    return contract_nodes(skeleton, target), strayed


def _with_border(is_chosen: NDArray[np.bool_], mesh: Mesh) -> NDArray[np.bool_]:
    """Some vertices, and those beside them."""
    is_near = np.array(is_chosen)
    is_near[mesh.edges[is_chosen[mesh.edges].any(axis=1)]] = True
    return is_near
