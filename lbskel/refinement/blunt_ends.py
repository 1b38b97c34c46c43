"""Blunt ends: a branch that is shorter than its own radius is a corner of the end of a limb, not a limb.

A limb that ends as wide as it is, such as a foot or a bar, has corners at its end. Contraction may leave a branch in a
corner which reaches farther than is pruned, since the inscribed radius is small there; whether it does depends on the
steps. Such a branch is wider than long, as no limb is: from the junction to the center of its last inscribed ball it is
shorter than the mean distance of its surface from it.

A short branch is kept if it leads to an end that :func:`lbskel.refinement.extrema.find_extrema` finds, other than a
tooth at the rim of a cut, or if its tip is the nearest to a cut. The end of the body itself may be short, too, such as
a wrist from which a thumb leaves. It is kept where the other branches of its junction all leave at acute angles to each
other: without it, one would turn back into another.
"""

from __future__ import annotations

__all__ = ["prune_blunt_ends"]

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import group_medians
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import find_extrema
from lbskel.refinement.flat_ends import first_parts, ways_from_nodes
from lbskel.refinement.open_ends import are_at_rims, cuts_with_tips
from lbskel.refinement.radii import mean_axis_distances
from lbskel.refinement.tips import extend_tips
from lbskel.skeleton.editing import contract_branches
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

# Length from which an end branch is kept, in mean distances of its surface from it. "Tips that all variants have" in
# benchmarks/results/stability.md
MIN_LENGTH = 1.0
TINY = float(np.finfo(np.float64).tiny)


def prune_blunt_ends(
    skeleton: Skeleton, surface: Surface, *, min_branch_ratio: float, open_ends: NDArray[np.float64]
) -> Skeleton:
    """Remove the end branches that are shorter than their radius; where a fork loses all, its limb is extended.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``, and with tips in the centers of the last inscribed balls.
    surface : Surface
        Of the mesh that ``node_of_vertex`` belongs to.
    min_branch_ratio : float
        As for :func:`lbskel.skeletonize`. Below its default, the length from which a branch is kept shrinks in
        proportion.
    open_ends : (e, 7) array of float
        As for :func:`lbskel.refinement.open_ends.tips_at_open_ends`. The branch with the nearest tip is kept: its limb
        goes on to the cut.
    """
    min_length = MIN_LENGTH * min(min_branch_ratio / MIN_BRANCH_RATIO, 1.0)
    while ends := _blunt_ends(skeleton, surface, min_length, open_ends):
        junctions, removed = np.unique([end[0] for end in ends]), np.sort(np.concatenate([end[1:] for end in ends]))
        skeleton = contract_branches(skeleton, ends)
        junctions -= np.searchsorted(removed, junctions)  # their numbers without the nodes that were removed
        skeleton = extend_tips(skeleton, surface, junctions[skeleton.degrees[junctions] == 1])
    return skeleton


def _blunt_ends(
    skeleton: Skeleton, surface: Surface, min_length: float, open_ends: NDArray[np.float64]
) -> list[NDArray[np.int64]]:
    """Find the end branches that are too short; where nothing else is left at their junction, all but two."""
    ends, tips, degrees = skeleton.end_branches, skeleton.tips, skeleton.degrees
    if not ends:
        return []
    widths, junctions = mean_axis_distances(skeleton, surface.mesh.vertices), np.array([end[0] for end in ends])
    lengths = np.array([vector_lengths(np.diff(skeleton.nodes[end], axis=0)).sum() for end in ends])
    outer = [end[1:] for end in ends]
    medians = group_medians(widths[np.concatenate(outer)], np.cumsum([0, *map(len, outer)]))
    ratios = lengths / np.maximum(medians, TINY)
    is_kept = np.zeros(len(degrees), dtype=bool)
    is_kept[tips[cKDTree(skeleton.nodes[tips]).query(open_ends[:, :3])[1]]] = True
    found = find_extrema(surface.proxy.mesh, deadline=surface.deadline).vertices
    at_rims = are_at_rims(surface.proxy.mesh.vertices[found], cuts_with_tips(skeleton, surface, open_ends))
    is_kept[surface.on_proxy(skeleton.node_of_vertex)[found[~at_rims]]] = True
    short = np.flatnonzero((ratios < min_length) & [not is_kept[each].any() for each in outer])
    short = short[np.lexsort((ratios[short], junctions[short]))]
    ways = ways_from_nodes(skeleton)
    turns = [_others_turn_back(skeleton, ends[row], ways[int(ends[row][0])], widths[junctions[row]]) for row in short]
    short = short[~np.array(turns, dtype=bool)]
    at = junctions[short]
    rank, n_short = np.arange(len(short)) - np.searchsorted(at, at), np.bincount(at, minlength=len(degrees))
    n_removed = np.where(n_short < degrees, n_short, degrees - 2)
    return [ends[row] for row in short[rank < n_removed[at]].tolist()]


def _others_turn_back(skeleton: Skeleton, end: NDArray[np.int64], ways: list[NDArray[np.int64]], reach: float) -> bool:
    """Whether the ways from the junction of an end branch, but for this, leave at acute angles, over a reach."""
    others = [way for way in ways if way[-1] != end[-1]]
    parts = first_parts(skeleton.nodes, others, np.full(len(others), reach))
    chords = np.array([skeleton.nodes[part[-1]] - skeleton.nodes[part[0]] for part in parts])
    return bool((chords @ chords.T > 0).all())
