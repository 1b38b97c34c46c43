"""Open ends: the tip of a tube that was cut, as a vessel at the border of a scan, lies at the center of the cut."""

from __future__ import annotations

__all__ = [
    "NO_CUTS",
    "are_at_rims",
    "are_within_cuts",
    "cuts_with_tips",
    "extend_to_open_ends",
    "normals_of_cuts",
    "tips_at_open_ends",
]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.normals import normalized, row_dots, vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import TIP_REACH
from lbskel.refinement.radii import axis_directions, mean_radii
from lbskel.refinement.tips import extend_ends
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

# Upper bound on the radius of a cut over that of the limb that ends there. Rows in benchmarks/results/cuts.md: with 2
# and less, ends that are cut obliquely or flare are not found; 4 is alike
MAX_CUT_RATIO = 2.5
# Lower bound on the area of a cut across the limb, as a share of the limb's section. It is 1 for a cut around a tube,
# however oblique. Rows in the same table: 0.25 to 0.5 are alike, with 0 faces missing in the sides of trees cut off 12
# of 168 ends, with 0.7 some jagged cuts are not found
MIN_CUT_SHARE = 0.5
# Upper bound on the distance from the center of a cut to its rim, in mean radii of the cut: it is 1.46 for a cut that
# is oblique by 75 degrees, and 1.63 at teeth of one. Rows in the same table: 1.5 to 3 are alike, with 1.25 a right
# skeleton fails, with 1 six of 90 cropped tubes have false branches; by hand, with 2 a twig beside a cut counts as rim
RIM_RATIO = 1.75
# Upper bound on the distance of a placed tip from the center of its cut, in radii of the cut. Rounding to single
# precision leaves 6e-8 of a coordinate: so much at 16,000 radii from the origin
AT_CENTER = 1e-3
NO_CUTS = np.empty((0, 7))


def tips_at_open_ends(
    skeleton: Skeleton, surface: Surface, open_ends: NDArray[np.float64]
) -> dict[int, NDArray[np.float64]]:
    """Find the tips that are in the open ends of tubes, and the cut of each.

    A tip ends at a cut if it is the nearest tip, at most ``TIP_REACH`` radii of the cut away, and not much thinner than
    that, not counting what lies within a radius of the cut. A cut that does not go around most of the limb is taken for
    a hole in its side. A tip at the center of a cut has been placed there, whatever became of the nodes before it.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
        The cuts may have been closed in its mesh.
    open_ends : (e, 7) array of float
        Center (3), mean radius (1) and vector area (3) of each cut, in the coordinates of the surface.
    """
    tips, cuts = skeleton.tips, dict[int, NDArray[np.float64]]()
    if len(tips) == 0 or len(open_ends) == 0:
        return cuts
    to_tip, nearest = cKDTree(skeleton.nodes[tips]).query(open_ends[:, :3])
    nearest_first = np.argsort(to_tip, kind="stable")  # of the ends that one tip could have, the nearest counts
    rows = nearest_first[to_tip[nearest_first] <= TIP_REACH * open_ends[nearest_first, 3]]
    if len(rows) == 0:
        return cuts
    widths, ways = mean_radii(skeleton, surface.mesh).radii, _ways_to_tips(skeleton)
    for tip, end in zip(tips[nearest[rows]].tolist(), open_ends[rows], strict=True):
        # a tip in the sharp edge of an oblique cut is thin, and one far from its cut has the surface from it to there
        width = widths[_before_cut(skeleton, ways[tip], end)[-2:]].min()
        is_limb = end[3] <= MAX_CUT_RATIO * width and _is_around(skeleton, ways[tip], end, np.pi * width**2)
        if is_limb or vector_lengths(skeleton.nodes[tip] - end[:3]) <= AT_CENTER * end[3]:
            cuts.setdefault(tip, end)
    return cuts


def cuts_with_tips(skeleton: Skeleton, surface: Surface, open_ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """(c, 7) the open ends that have a tip.

    Parameters
    ----------
    skeleton, surface, open_ends
        As for :func:`tips_at_open_ends`.
    """
    return np.array([*tips_at_open_ends(skeleton, surface, open_ends).values()]).reshape(-1, 7)


def normals_of_cuts(skeleton: Skeleton, open_ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) unit normal, out of its branch, of the cut that each tip is at the center of; zero for all other nodes.

    Parameters
    ----------
    skeleton, open_ends
        As for :func:`tips_at_open_ends`.
    """
    normals, tips = np.zeros_like(skeleton.nodes), skeleton.tips
    if len(tips) == 0 or len(open_ends) == 0:
        return normals
    distances, nearest = cKDTree(skeleton.nodes[tips]).query(open_ends[:, :3])
    is_at_center = distances <= AT_CENTER * open_ends[:, 3]
    ends = tips[nearest[is_at_center]]
    normals[ends] = normalized(open_ends[is_at_center, 4:])
    normals[ends] *= np.sign(row_dots(normals[ends], axis_directions(skeleton)[ends]))[:, None]
    return normals


def are_at_rims(points: NDArray[np.float64], cuts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether points of the surface are at the rim of a cut: its teeth are no ends of limbs.

    Parameters
    ----------
    points : (k, 3) array of float
    cuts : (c, 7) array of float
        Center (3), mean radius (1) and vector area (3) of each cut.
    """
    return are_within_cuts(points, cuts, share=RIM_RATIO)


def are_within_cuts(points: NDArray[np.float64], cuts: NDArray[np.float64], *, share: float = 1.0) -> NDArray[np.bool_]:
    """(k,) whether points are within a share of the radius of a cut from its center.

    Parameters
    ----------
    points : (k, 3) array of float
    cuts : (c, 7) array of float
        Center (3), mean radius (1) and vector area (3) of each cut.
    share : float
        Of the radius of each cut, within which points count.
    """
    are_within = np.zeros(len(points), dtype=bool)
    if len(cuts) and len(points):
        for found in cKDTree(points).query_ball_point(cuts[:, :3], share * cuts[:, 3]):
            are_within[found] = True
    return are_within


def extend_to_open_ends(skeleton: Skeleton, surface: Surface, open_ends: NDArray[np.float64]) -> Skeleton:
    """Extend the tips in the open ends of tubes to the centers of the cuts; radii there are those of the tubes.

    That is, of the node before the cut, or of a narrower cut. The last nodes within a radius of the cut's center are
    left out, so that the branch does not turn back to it.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, which near a cut are smaller than the limb's.
    surface, open_ends
        As for :func:`tips_at_open_ends`.
    """
    cuts = tips_at_open_ends(skeleton, surface, open_ends)
    cuts = {tip: cut for tip, cut in cuts.items() if (skeleton.nodes[tip] != cut[:3]).any()}
    if not cuts:
        return skeleton
    target, ways = np.arange(len(skeleton.nodes)), _ways_to_tips(skeleton)
    for tip, cut in cuts.items():
        before = _before_cut(skeleton, ways[tip], cut)
        target[ways[tip][len(before) :]] = before[-1]
    last = np.searchsorted(np.unique(target), target[list(cuts)])
    skeleton = contract_nodes(skeleton, target)
    n_nodes = len(skeleton.nodes)
    extended = extend_ends(skeleton, surface, last, [[cut[:3]] for cut in cuts.values()])
    radii = np.array(extended.radii)
    radii[n_nodes:] = np.minimum([cut[3] for cut in cuts.values()], radii[last])
    return replace(extended, radii=radii)


def _ways_to_tips(skeleton: Skeleton) -> dict[int, NDArray[np.int64]]:
    """Nodes of the branch to each tip, which comes last."""
    return {int(way[-1]): way for branch in skeleton.branches for way in (branch, branch[::-1])}


def _before_cut(skeleton: Skeleton, way: NDArray[np.int64], cut: NDArray[np.float64]) -> NDArray[np.int64]:
    """Nodes of a branch before the first, in its outer half, that is within a radius of the center of a cut, or all.

    The outer halves of a branch with two tips, each of which may be at a cut, have no node in common.
    """
    n_inner = (len(way) + (1 if skeleton.degrees[way[0]] > 1 else 2)) // 2
    is_near = vector_lengths(skeleton.nodes[way[n_inner:]] - cut[:3]) < cut[3]
    return way[: n_inner + int(is_near.argmax())] if is_near.any() else way


def _is_around(skeleton: Skeleton, way: NDArray[np.int64], cut: NDArray[np.float64], section: float) -> bool:
    """Whether a cut goes around most of the section of the branch that ends there."""
    before = skeleton.nodes[_before_cut(skeleton, way, cut)[-2:]]
    along = before[-1] - before[0] if len(before) == 2 else cut[:3] - before[0]
    return bool(abs(cut[4:] @ along) >= MIN_CUT_SHARE * section * np.linalg.norm(along))
