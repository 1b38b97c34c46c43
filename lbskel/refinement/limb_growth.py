"""Growth of limbs: a branch is grown along every limb that contraction has left without one.

A limb that is short, or thin relative to the contracted faces, may be pulled into the body before it becomes a line.
Its end is an extremum of the geodesic distance to which no tip is near (:mod:`lbskel.refinement.extrema`): so the short
ends of thick bodies are found, and now and then a corner of a plate, which is pruned as a flat end. Or the limb stands
out of the skeleton's balls (:mod:`lbskel.refinement.uncovered_limbs`): so limbs too short for the extrema are found.
The branch leads straight to the center of the limb's cap, from the node nearest to the limb's end, among those of the
limb's vertices and of the vertices beside it. Later passes reroute a branch where it is outside a closed surface, and
fit it to the limb.
"""

from __future__ import annotations

__all__ = ["grow_limbs"]

from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import distinct
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.flat_ends import is_corner
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import extend_ends
from lbskel.refinement.uncovered_limbs import Limbs, find_limbs
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton


def grow_limbs(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Grow a branch along each limb that has no tip near its end, or stands out of the skeleton's balls.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    mesh = surface.proxy.mesh
    on_proxy = replace(skeleton, node_of_vertex=surface.on_proxy(skeleton.node_of_vertex))
    balls, extrema = inscribed_radii(on_proxy, surface.proxy), find_extrema(mesh, deadline=surface.deadline)
    missed = extrema.take(is_missed(extrema, mesh, balls))
    limbs = find_limbs(balls, mesh, missed)
    if len(limbs.ends) == 0:
        return skeleton
    bases = _nearest_nodes_beside(on_proxy, limbs, mesh)
    ways = mesh.vertices[limbs.ends] - skeleton.nodes[bases]
    lengths = vector_lengths(ways)
    shares = np.maximum(1 - limbs.radii / lengths, 0.5)  # the center of a round cap, or half the way to a flat one
    tips = skeleton.nodes[bases] + shares[:, None] * ways
    base_of_vertex = np.append(bases, -1)[surface.from_proxy(limbs.limb_of_vertex)]  # the last is for those of no limb
    node_of_vertex = np.where(base_of_vertex < 0, skeleton.node_of_vertex, base_of_vertex)
    grown = extend_ends(replace(skeleton, node_of_vertex=node_of_vertex), surface, bases, [[tip] for tip in tips])
    return _without_corners(grown, surface, len(skeleton.nodes) + np.arange(len(missed.vertices)))


def _without_corners(skeleton: Skeleton, surface: Surface, tips: NDArray[np.int64]) -> Skeleton:
    """Contract those of the branches to some tips that are in corners of flat parts."""
    junctions = {int(end[0]) for end in skeleton.end_branches if end[-1] in tips}
    around = [end for end in skeleton.end_branches if int(end[0]) in junctions]  # which may be in sight of each other
    if not around:
        return skeleton
    corners = compress(around, is_corner(skeleton, surface, around, MIN_BRANCH_RATIO))
    return contract_branches(skeleton, [end for end in corners if end[-1] in tips])


def _nearest_nodes_beside(skeleton: Skeleton, limbs: Limbs, mesh: Mesh) -> NDArray[np.int64]:
    """(u,) for each limb: of the nodes of its vertices and of those adjacent to them, the one nearest to its end."""
    i, j = mesh.edges.T
    limb = limbs.limb_of_vertex[np.concatenate([i, j, i, j])]
    node = skeleton.node_of_vertex[np.concatenate([i, j, j, i])]
    k = len(skeleton.nodes)
    limb, node = np.divmod(distinct((limb * k + node)[limb >= 0]), k)
    distances = vector_lengths(skeleton.nodes[node] - mesh.vertices[limbs.ends[limb]])
    order = np.lexsort((distances, limb))
    return np.asarray(node[order[np.unique(limb[order], return_index=True)[1]]])
