"""The passes between the collapsed graph and the finished skeleton of one body.

::

    prune spurs -> merge junctions -> grow limbs -> recenter -> extend tips -> grow limbs -> prune blunt ends
                -> mirror -> reroute inside -> fit tubes (-> tips at surface) -> attach open ends and anchors
                -> map vertices

:func:`refine` runs these passes. Each makes a complete skeleton of a complete skeleton, so that any pass but the one of
open ends and anchors can be left out where no time is left for it, or where it moves a cycle off its tunnel.
"""

from __future__ import annotations

__all__ = ["refine"]

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError, UnknownChoice
from lbskel.geometry.deadline import Deadline
from lbskel.geometry.surface_queries import Surface
from lbskel.pipeline.anchoring import Anchors
from lbskel.pipeline.options import require_refinement_options
from lbskel.pipeline.preparation import Body
from lbskel.pipeline.profiling import StageTimer
from lbskel.refinement.anchors import attach_anchors
from lbskel.refinement.blunt_ends import prune_blunt_ends
from lbskel.refinement.centering import fit_to_centerlines, recenter
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import paths_outside, reroute_inside
from lbskel.refinement.flat_ends import prune_flat_ends
from lbskel.refinement.junctions import merge_junctions_by_axes
from lbskel.refinement.limb_growth import grow_limbs, grow_limbs_without_tip
from lbskel.refinement.mirror_symmetry import keep_mirror_symmetry, make_mirror_symmetric
from lbskel.refinement.open_ends import cuts_with_tips, extend_to_open_ends
from lbskel.refinement.radii import inscribed_radii, mean_radii
from lbskel.refinement.region_map import make_regions_connected, reassign_to_nearest_node
from lbskel.refinement.region_paths import reroute_through_regions
from lbskel.refinement.surface_tips import tips_at_surface
from lbskel.refinement.tips import extend_tips
from lbskel.refinement.trunks import split_junctions_along_trunks
from lbskel.refinement.tube_fit import fit_tubes, tube_radii
from lbskel.refinement.tunnel_sides import n_tunnels_missed, paths_that_pass
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO, merge_junctions, prune
from lbskel.skeleton.resampling import space_evenly
from lbskel.skeleton.skeleton import Skeleton

Pass: TypeAlias = Callable[[Skeleton, Surface], Skeleton]

# Distance of the nodes along a branch, in mean radii. It bounds the error between nodes, and the time:
# benchmarks/results/constants.md
SPACING = 0.5


def refine(
    skeleton: Skeleton,
    body: Body,
    *,
    min_branch_ratio: float = MIN_BRANCH_RATIO,
    tip_position: str = "inside",
    anchors: Anchors | None = None,
    timer: StageTimer | None = None,
) -> Skeleton:
    """Prune, center, extend and contain the skeleton of one body.

    Parameters
    ----------
    skeleton : Skeleton
        From :func:`to_skeleton`; its vertex map is that of the body's proxy.
    body : Body
    min_branch_ratio, tip_position
        As for :func:`skeletonize`.
    anchors : Anchors, optional
        Vertices and points of the body at which there must be nodes.
    timer : StageTimer, optional
        Measures each pass; passes are left out where its time limit leaves no time for them.

    Returns
    -------
    Skeleton
        In the body's coordinates, with inscribed and mean radii and a node for each vertex of the body.

    Raises
    ------
    UnknownChoice
        If the ratio is negative or NaN, the tip position is not a name in TIP_POSITIONS, or anchors are no Anchors.
    MeshError
        If the skeleton's map is not that of the body's proxy, or the skeleton lies elsewhere than the body.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> (body,) = lbskel.prepare(torus(1.0, 0.2)).bodies
    >>> skeleton = lbskel.to_skeleton(lbskel.collapse(lbskel.contract(body.proxy.mesh)))
    >>> len(lbskel.refine(skeleton, body).node_of_vertex) == len(body.mesh.vertices)
    True
    """
    require_refinement_options(min_branch_ratio, tip_position)
    n_mapped, n_vertices = len(skeleton.node_of_vertex), len(body.proxy.mesh.vertices)
    if n_mapped != n_vertices:
        raise MeshError(
            f"the skeleton maps {n_mapped} vertices to its nodes, and the proxy of the body has {n_vertices}: give the "
            "skeleton that to_skeleton made from body.proxy.mesh"
        )
    low, high = body.mesh.vertices.min(axis=0), body.mesh.vertices.max(axis=0)
    if ((skeleton.nodes < low) | (skeleton.nodes > high)).any(axis=1).mean() > 0.5:  # most of the nodes
        raise MeshError(
            "the skeleton lies elsewhere than the body, which lbskel.prepare has moved and scaled: contract "
            "body.proxy.mesh, and not the mesh that was prepared"
        )
    if anchors is not None and not isinstance(anchors, Anchors):
        raise UnknownChoice("anchors must be those that resolve_anchors of lbskel.pipeline.anchoring returns")
    timer = timer or StageTimer()

    def changed(stage: str, change: Pass, surface: Surface, *, is_needed: bool = False) -> Skeleton:
        def make(deadline: Deadline) -> Skeleton:
            after = change(skeleton, replace(surface, deadline=deadline))
            is_worse = n_tunnels_missed(after, body.surface) > n_tunnels_missed(skeleton, body.surface)
            return skeleton if is_worse else after

        return timer.optional(stage, make, skeleton, is_needed=is_needed)

    surface, proxy = body.surface, body.surface.proxy
    skeleton = mean_radii(skeleton, proxy.mesh)
    prune_spurs = partial(_without_spurs, min_branch_ratio=min(min_branch_ratio, MIN_BRANCH_RATIO))
    skeleton = changed("prune spurs", prune_spurs, proxy, is_needed=True)
    skeleton = changed("merge junctions", _with_merged_junctions, proxy)
    skeleton = replace(skeleton, node_of_vertex=body.proxy.vertex_map.pull_back(skeleton.node_of_vertex))
    prune_blunt = partial(prune_blunt_ends, min_branch_ratio=min_branch_ratio, open_ends=body.open_ends)
    passes: list[tuple[str, Pass]] = [
        ("grow limbs", partial(_with_limbs_without_tip, open_ends=body.open_ends)),
        ("recenter", recenter),
        ("extend tips", extend_tips),
        ("grow limbs", partial(grow_limbs, open_ends=body.open_ends)),
        ("prune blunt ends", prune_blunt),
        ("mirror", make_mirror_symmetric),
        ("reroute inside", _rerouted_inside),
        ("reroute inside", _evenly_spaced),
        ("fit tubes", _with_fitted_tubes),
    ]
    if tip_position == "surface":
        passes.append(("tips at surface", tips_at_surface))
    for stage, change in passes:
        skeleton = changed(stage, change, surface)
    with timer("attach open ends and anchors"):
        skeleton = extend_to_open_ends(inscribed_radii(skeleton, surface), surface, body.open_ends)
        if anchors is not None:
            skeleton = attach_anchors(skeleton, surface, anchors.vertices, anchors.points, anchors.numbers)
    skeleton = changed("map vertices", _with_own_regions, surface, is_needed=True)
    cuts = cuts_with_tips(skeleton, surface, body.open_ends)
    return replace(skeleton, mean_radii=tube_radii(skeleton, surface, cuts=cuts))


def _without_spurs(skeleton: Skeleton, surface: Surface, *, min_branch_ratio: float) -> Skeleton:
    """Prune corners of flat parts and spurs, merge near junctions, space the nodes evenly.

    Corners come first: of two at the end of a flat part, the longer one is no spur and would bend the end.
    """
    pruned = prune_flat_ends(skeleton, surface, min_branch_ratio=min_branch_ratio)
    pruned = prune(pruned, surface.mesh, min_branch_ratio=min_branch_ratio)
    regions = _regions_before(skeleton, pruned)
    skeleton = reroute_through_regions(mean_radii(pruned, surface.mesh), surface, regions)
    merged = merge_junctions(inscribed_radii(skeleton, surface))
    is_worse = n_tunnels_missed(merged, surface) > n_tunnels_missed(skeleton, surface)
    return _evenly_spaced(skeleton if is_worse else merged, surface)


def _regions_before(skeleton: Skeleton, pruned: Skeleton) -> NDArray[np.int64]:
    """(n,) node whose region each vertex was in before pruning, -1 where the node is pruned.

    A node takes over the regions of the branches pruned at it; a path through these may pass another side of a tunnel.
    """
    row = cKDTree(pruned.nodes).query(skeleton.nodes)[1]
    is_left = (pruned.nodes[row] == skeleton.nodes).all(axis=1)
    regions: NDArray[np.int64] = np.where(is_left, row, -1)[skeleton.node_of_vertex]
    return regions


def _with_own_regions(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Map the vertices to nodes near them, so that regions are connected."""
    near = reassign_to_nearest_node(skeleton, surface.mesh)
    surface.deadline.check()
    return make_regions_connected(near, surface.mesh)


def _with_merged_junctions(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Merge junctions whose branches point to one place, split those along trunks, and move nodes to the axes."""
    centers = find_section_centers(skeleton, surface)
    merged = merge_junctions_by_axes(inscribed_radii(skeleton, surface), centers, surface)
    if len(merged.nodes) < len(skeleton.nodes):
        skeleton = mean_radii(merged, surface.mesh)
        centers = find_section_centers(skeleton, surface)
    split, centers = split_junctions_along_trunks(skeleton, centers, surface)
    if split is not skeleton:
        skeleton = mean_radii(split, surface.mesh)
    return fit_to_centerlines(skeleton, centers, surface)


def _with_limbs_without_tip(skeleton: Skeleton, surface: Surface, *, open_ends: NDArray[np.float64]) -> Skeleton:
    """Grow limbs that have no tip, so that they are centered as the others are, and twigs on them are found later."""
    grown = grow_limbs_without_tip(skeleton, surface, open_ends=open_ends)
    return grown if grown is skeleton else _evenly_spaced(grown, surface)


def _rerouted_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Reroute branches inside a closed surface; leave those of an open one."""
    return reroute_inside(skeleton, surface) if surface.mesh.is_closed else skeleton


def _evenly_spaced(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Space the nodes evenly, in mean radii; in inscribed radii, flat limbs would get a node per thickness."""
    return space_evenly(mean_radii(skeleton, surface.mesh), SPACING, partial(_must_stay, surface=surface))


def _with_fitted_tubes(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Fit round tubes to the surface, alike on both sides of a symmetric one.

    The regions that contraction left are not those of the nodes near it.
    """
    near = reassign_to_nearest_node(skeleton, surface.mesh)
    fitted = fit_tubes(near, surface)
    return fitted if fitted is near else keep_mirror_symmetry(near, fitted, surface)


def _must_stay(olds: list[NDArray[np.float64]], news: list[NDArray[np.float64]], surface: Surface) -> NDArray[np.bool_]:
    """(p,) whether a path with its new inner nodes passes another side of a tunnel, or leaves a closed surface anew."""
    must_stay = paths_that_pass(olds, news, surface)
    if surface.mesh.is_closed:
        whole = [np.concatenate([old[:1], new, old[-1:]]) for old, new in zip(olds, news, strict=True)]
        leaving = np.flatnonzero(paths_outside(whole, surface))
        must_stay[leaving] |= ~paths_outside([olds[row] for row in leaving], surface)
    return must_stay
