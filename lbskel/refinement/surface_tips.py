"""Tips at the surface, where they are asked for there and not at the centers of the last inscribed balls."""

from __future__ import annotations

__all__ = ["tips_at_surface"]

import numpy as np

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.radii import axis_directions
from lbskel.refinement.tips import extend_ends
from lbskel.skeleton.skeleton import Skeleton

MAX_TIP_DISTANCE = 2.0  # to the surface straight ahead of a tip that ends a branch, in radii of its ball; a guess,
# with no effect from 1.4 to 2.8 in benchmarks/results/constants.md


def tips_at_surface(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Extend every tip to the surface: straight ahead, or to its nearest point if it is far ahead.

    Parameters
    ----------
    skeleton : Skeleton
        With its tips at the centers of the last inscribed balls.
    surface : Surface
    """
    tips = skeleton.tips
    if len(tips) == 0:
        return skeleton
    P = skeleton.nodes[tips]
    directions = axis_directions(skeleton)[tips]
    ahead, (radii, nearest) = surface.ray_distance(P, directions), surface.closest(P)
    is_near = ahead < MAX_TIP_DISTANCE * radii
    ends = np.where(is_near[:, None], P + np.where(is_near, ahead, 0)[:, None] * directions, nearest)
    return extend_ends(skeleton, surface, tips, [[end] for end in ends])
