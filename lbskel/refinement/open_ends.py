"""Open ends: the tip of a tube that was cut, as a vessel at the border of a scan, lies at the center of the cut."""

from __future__ import annotations

__all__ = ["extend_to_open_ends"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.radii import mean_radii
from lbskel.refinement.tips import TIP_REACH, extend_ends
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

MAX_CUT_RATIO = 2.5  # upper bound on the ratio of the radii of a cut and of the limb that ends there; a guess


def extend_to_open_ends(skeleton: Skeleton, surface: Surface, open_ends: NDArray[np.float64]) -> Skeleton:
    """Extend the tips in the open ends of tubes to the centers of the cuts; radii there are those of the cuts.

    A tip ends at a cut if it is the nearest tip, at most ``TIP_REACH`` radii of the cut away, and about as thick. The
    last nodes within a radius of the cut's center are left out, so that the branch does not turn back to it.

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
    starts: dict[int, NDArray[np.float64]] = {}
    to_tip = cKDTree(skeleton.nodes[tips]).query(open_ends[:, :3])[0]
    for end in open_ends[np.argsort(to_tip, kind="stable")]:  # of the ends that one tip could have, the nearest
        distances = np.linalg.norm(skeleton.nodes[tips] - end[:3], axis=1)
        tip = int(tips[distances.argmin()])
        is_as_thick = end[3] / MAX_CUT_RATIO <= widths[tip] <= end[3] * MAX_CUT_RATIO
        if 0 < distances.min() <= TIP_REACH * end[3] and is_as_thick:
            starts.setdefault(tip, end)
    if not starts:
        return skeleton
    skeleton, last = _cut_back(skeleton, starts)
    n_nodes = len(skeleton.nodes)
    extended = extend_ends(skeleton, surface, last, [[end[:3]] for end in starts.values()])
    radii = np.array(extended.radii)
    radii[n_nodes:] = [end[3] for end in starts.values()]
    return replace(extended, radii=radii)


def _cut_back(skeleton: Skeleton, cut_of_tip: dict[int, NDArray[np.float64]]) -> tuple[Skeleton, NDArray[np.int64]]:
    """Contract the last nodes of branches near their cuts, in their outer half; and the node at which each tip is then.

    Nodes farther along the branch than one near the cut, such as those beyond it, are contracted too.
    """
    target = np.arange(len(skeleton.nodes))
    for branch in skeleton.branches:
        for way in (branch, branch[::-1]):
            if (cut := cut_of_tip.get(int(way[-1]))) is not None:
                outer = way[(len(way) + 1) // 2 :]
                is_near = np.linalg.norm(skeleton.nodes[outer] - cut[:3], axis=1) < cut[3]
                if is_near.any():
                    first = len(way) - len(outer) + int(is_near.argmax())
                    target[way[first:]] = way[first - 1]
    kept = np.unique(target)
    return contract_nodes(skeleton, target), np.searchsorted(kept, target[list(cut_of_tip)])
