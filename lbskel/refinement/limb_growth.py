"""Growth of limbs: a branch is grown along every limb that contraction has left without one.

A limb that is short, or thin relative to the contracted faces, may be pulled into the body before it becomes a line.
Its end is an extremum of the geodesic distance to which no tip is near (:mod:`lbskel.refinement.extrema`): so the short
ends of thick bodies are found, and now and then a corner of a plate, which is pruned as a flat end. Or the limb stands
out of the skeleton's balls (:mod:`lbskel.refinement.uncovered_limbs`): so limbs too short for the extrema are found.
The branch follows the limb's centerline (:mod:`lbskel.refinement.limb_centerlines`) to the center of its cap. It begins
at a node of the limb's vertices or of the vertices beside it: at the one that is farthest along the centerline, within
the radius of a ring of its center, or at the one nearest to the centerline's beginning. A limb with such a node in its
cap gets no branch. Later passes reroute a branch where it is outside a closed surface, and fit it to the limb.

Limbs that stand out and have no tip at all are grown before nodes are centered too: their nodes are centered with the
others, and limbs that leave them are found by the second growth.
"""

from __future__ import annotations

__all__ = ["grow_limbs", "grow_limbs_without_tip"]

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
from lbskel.refinement.limb_centerlines import trace_limbs
from lbskel.refinement.open_ends import NO_CUTS, are_at_rims, cuts_with_tips
from lbskel.refinement.radii import inscribed_radii
from lbskel.refinement.tips import extend_ends
from lbskel.refinement.uncovered_limbs import Limbs, find_limbs
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton


def grow_limbs(skeleton: Skeleton, surface: Surface, *, open_ends: NDArray[np.float64] = NO_CUTS) -> Skeleton:
    """Grow a branch along each limb that has no tip near its end, or stands out of the skeleton's balls.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    open_ends : (e, 7) array of float
        As for :func:`lbskel.refinement.open_ends.tips_at_open_ends`. The rim of a cut with a tip is not the end of a
        limb, though its teeth may stand out while the tip is not at its center yet.
    """
    mesh, balls = surface.proxy.mesh, _balls(skeleton, surface)
    extrema = find_extrema(mesh, deadline=surface.deadline)
    limbs = Limbs(extrema.vertices, extrema.radii, extrema.limb_of_vertex)
    cuts = cuts_with_tips(skeleton, surface, open_ends)
    missed = _without_rims(limbs.take(is_missed(extrema, mesh, balls)), mesh, cuts)
    grown, ends = _grown(skeleton, balls, _without_rims(find_limbs(balls, mesh, missed), mesh, cuts), surface)
    tips = ends[: len(missed.ends)]
    return _without_corners(grown, surface, tips[tips >= 0])


def grow_limbs_without_tip(
    skeleton: Skeleton, surface: Surface, *, open_ends: NDArray[np.float64] = NO_CUTS
) -> Skeleton:
    """Grow a branch along each limb that stands out of the skeleton's balls and whose vertices are mapped to no tip.

    Where nodes are not centered yet, tips end far before the ends of their limbs, and so no end tells of a lost limb.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    open_ends : (e, 7) array of float
        As for :func:`grow_limbs`.
    """
    balls, mesh = _balls(skeleton, surface), surface.proxy.mesh
    limbs = _without_rims(find_limbs(balls, mesh), mesh, cuts_with_tips(skeleton, surface, open_ends))
    has_tip = np.zeros(len(limbs.ends) + 1, dtype=bool)  # the last is for vertices of no limb
    has_tip[limbs.limb_of_vertex[balls.degrees[balls.node_of_vertex] <= 1]] = True
    return _grown(skeleton, balls, limbs.take(~has_tip[:-1]), surface)[0]


def _without_rims(limbs: Limbs, mesh: Mesh, cuts: NDArray[np.float64]) -> Limbs:
    """Leave out the limbs whose ends are at the rims of cuts."""
    return limbs.take(~are_at_rims(mesh.vertices[limbs.ends], cuts))


def _balls(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Return the skeleton with inscribed radii in the surface's proxy, and a node for each of its vertices."""
    on_proxy = replace(skeleton, node_of_vertex=surface.on_proxy(skeleton.node_of_vertex))
    return inscribed_radii(on_proxy, surface.proxy)


def _grown(skeleton: Skeleton, balls: Skeleton, limbs: Limbs, surface: Surface) -> tuple[Skeleton, NDArray[np.int64]]:
    """Grow a branch along each of u limbs; return the skeleton and (u,) its new tips, -1 where there is a branch.

    Parameters
    ----------
    skeleton : Skeleton
    balls : Skeleton
        With a node for each vertex of the surface's proxy.
    limbs : Limbs
    surface : Surface
    """
    if len(limbs.ends) == 0:
        return skeleton, limbs.ends
    bases, paths = _paths(balls, limbs, surface)
    lengths = np.array([len(path) for path in paths])
    base_of_vertex = np.append(np.where(lengths > 0, bases, -1), -1)[surface.from_proxy(limbs.limb_of_vertex)]
    node_of_vertex = np.where(base_of_vertex < 0, skeleton.node_of_vertex, base_of_vertex)
    grown = extend_ends(replace(skeleton, node_of_vertex=node_of_vertex), surface, bases, paths)
    return grown, np.where(lengths > 0, len(skeleton.nodes) - 1 + np.cumsum(lengths), -1)


def _paths(
    skeleton: Skeleton, limbs: Limbs, surface: Surface
) -> tuple[NDArray[np.int64], list[list[NDArray[np.float64]]]]:
    """Find the base of a branch along each limb, and the positions of its other nodes; none where there is a branch.

    Without a centerline inside, a branch leads straight from the node nearest to the end of its limb, to the center of
    a round cap or half the way.

    Parameters
    ----------
    skeleton : Skeleton
        With a node for each vertex of the surface's proxy.
    limbs : Limbs
    surface : Surface
    """
    mesh = surface.proxy.mesh
    lines, nodes_beside = trace_limbs(mesh, limbs), _nodes_beside(skeleton, limbs, mesh)
    is_inside = surface.contains(np.concatenate([points for points, _ in lines]))
    insides = np.split(is_inside, np.cumsum([len(points) for points, _ in lines])[:-1])
    bases, paths = np.empty(len(lines), dtype=np.int64), list[list[NDArray[np.float64]]]()
    for row, ((points, radii), inside, beside) in enumerate(zip(lines, insides, nodes_beside, strict=True)):
        nodes = skeleton.nodes[beside]
        if len(points) and inside.all():
            distances = np.linalg.norm(nodes[:, None] - points, axis=2)
            n_reached = int(np.flatnonzero(np.append(True, (distances < radii).any(axis=0)))[-1])
            base = beside[distances[:, max(n_reached - 1, 0)].argmin()]
            if n_reached == len(points) > 1 and skeleton.degrees[base] == 1:  # a tip may be short of the center
                n_reached -= (points[-1] - skeleton.nodes[base]) @ (points[-1] - points[-2]) > 0
            bases[row] = base
            paths.append([*points[n_reached:]])
        else:
            end = mesh.vertices[limbs.ends[row]]
            nearest = vector_lengths(nodes - end).argmin()
            bases[row], way = beside[nearest], end - nodes[nearest]
            paths.append([nodes[nearest] + max(1 - limbs.radii[row] / np.linalg.norm(way), 0.5) * way])
    return bases, paths


def _without_corners(skeleton: Skeleton, surface: Surface, tips: NDArray[np.int64]) -> Skeleton:
    """Contract those of the branches to some tips that are in corners of flat parts."""
    junctions = {int(end[0]) for end in skeleton.end_branches if end[-1] in tips}
    around = [end for end in skeleton.end_branches if int(end[0]) in junctions]  # which may be in sight of each other
    if not around:
        return skeleton
    corners = compress(around, is_corner(skeleton, surface, around, MIN_BRANCH_RATIO))
    return contract_branches(skeleton, [end for end in corners if end[-1] in tips])


def _nodes_beside(skeleton: Skeleton, limbs: Limbs, mesh: Mesh) -> list[NDArray[np.int64]]:
    """(u,) for each limb: the nodes of its vertices and of those adjacent to them."""
    i, j = mesh.edges.T
    limb = limbs.limb_of_vertex[np.concatenate([i, j, i, j])]
    node = skeleton.node_of_vertex[np.concatenate([i, j, j, i])]
    k = len(skeleton.nodes)
    limb, node = np.divmod(distinct((limb * k + node)[limb >= 0]), k)
    return np.split(node, np.searchsorted(limb, np.arange(1, len(limbs.ends))))
