"""Open ends: the tip of a tube that was cut, as a vessel at the border of a scan, lies at the center of the cut."""

from __future__ import annotations

__all__ = ["extend_to_open_ends"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import TIP_REACH
from lbskel.refinement.radii import mean_radii
from lbskel.refinement.tips import extend_ends
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

MAX_CUT_RATIO = 2.5  # upper bound on the ratio of the radii of a cut and of the limb that ends there; a guess
# Upper bound on the angle between a branch and the way to the center of the cut at its end, in radians: however oblique
# a cut across a tube is, its center is on the axis. "Tried and not kept" in benchmarks/results/refinement.md has pi / 2
# and pi / 4
MAX_TURN = np.pi / 3


def extend_to_open_ends(skeleton: Skeleton, surface: Surface, open_ends: NDArray[np.float64]) -> Skeleton:
    """Extend the tips in the open ends of tubes to the centers of the cuts; radii there are those of the tubes.

    That is, of the node before the cut, or of a narrower cut. A tip ends at a cut if it is the nearest tip, at most
    ``TIP_REACH`` radii of the cut away, and about as thick, not counting what lies within a radius of the cut. The
    last nodes within a radius of the cut's center are left out, so that the branch does not turn back to it. A cut to
    which it would still turn by more than ``MAX_TURN`` is taken for a hole in its side, and changes nothing.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, which near a cut are smaller than the limb's.
    surface : Surface
        The cuts may have been closed in its mesh.
    open_ends : (e, 4) array of float
        Center (3) and mean radius (1) of each cut, in the coordinates of the surface.
    """
    tips = skeleton.tips
    if len(tips) == 0 or len(open_ends) == 0:
        return skeleton
    widths = mean_radii(skeleton, surface.mesh).radii
    ways = {int(way[-1]): way for branch in skeleton.branches for way in (branch, branch[::-1])}
    starts: dict[int, NDArray[np.float64]] = {}
    to_tip = cKDTree(skeleton.nodes[tips]).query(open_ends[:, :3])[0]
    for end in open_ends[np.argsort(to_tip, kind="stable")]:  # of the ends that one tip could have, the nearest
        distances = vector_lengths(skeleton.nodes[tips] - end[:3])
        tip = int(tips[distances.argmin()])
        width = widths[_before_cut(skeleton, ways[tip], end)[-1]]  # a tip in the sharp edge of an oblique cut is thin
        is_as_thick = end[3] / MAX_CUT_RATIO <= width <= end[3] * MAX_CUT_RATIO
        if 0 < distances.min() <= TIP_REACH * end[3] and is_as_thick and _is_ahead(skeleton, ways[tip], end):
            starts.setdefault(tip, end)
    if not starts:
        return skeleton
    target = np.arange(len(skeleton.nodes))
    for tip, end in starts.items():
        before = _before_cut(skeleton, ways[tip], end)
        target[ways[tip][len(before) :]] = before[-1]
    last = np.searchsorted(np.unique(target), target[list(starts)])
    skeleton = contract_nodes(skeleton, target)
    n_nodes = len(skeleton.nodes)
    extended = extend_ends(skeleton, surface, last, [[end[:3]] for end in starts.values()])
    radii = np.array(extended.radii)
    radii[n_nodes:] = np.minimum([end[3] for end in starts.values()], radii[last])
    return replace(extended, radii=radii)


def _before_cut(skeleton: Skeleton, way: NDArray[np.int64], cut: NDArray[np.float64]) -> NDArray[np.int64]:
    """Nodes of a branch before the first, in its outer half, that is within a radius of the center of a cut, or all.

    The outer halves of a branch with two tips, each of which may be at a cut, have no node in common.
    """
    n_inner = (len(way) + (1 if skeleton.degrees[way[0]] > 1 else 2)) // 2
    is_near = vector_lengths(skeleton.nodes[way[n_inner:]] - cut[:3]) < cut[3]
    return way[: n_inner + int(is_near.argmax())] if is_near.any() else way


def _is_ahead(skeleton: Skeleton, way: NDArray[np.int64], cut: NDArray[np.float64]) -> bool:
    """Whether a branch goes on to a cut without turning by more than MAX_TURN."""
    inner, last = skeleton.nodes[_before_cut(skeleton, way, cut)[-2:][[0, -1]]]
    before, after = last - inner, cut[:3] - last
    return bool(after @ before >= np.cos(MAX_TURN) * np.linalg.norm(after) * np.linalg.norm(before))
