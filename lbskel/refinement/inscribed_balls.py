"""Places in the middle of a solid: steps towards larger inscribed balls.

Straight away from the surface, the distance to the surface grows by the whole length of a step; where a second side is
as near, it grows more slowly. Its slope there is the cosine of half the angle between the directions to the two sides
(Lieutier 2004, "Any open bounded subset of R^n has the same homotopy type as its medial axis",
https://doi.org/10.1016/j.cad.2004.01.011, on the gradient of the distance function).
"""

from __future__ import annotations

__all__ = ["MIN_BALL_RATIO", "climb_to_middle"]

import itertools

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import Surface

# Growth of the ball's radius by length of the way, below which a point stays: it is 1 from one side to the middle, 0.5
# where the sides are 120 degrees apart, 0 along a tube. Rows "slope of" in benchmarks/results/refinement.md
MIN_SLOPE = 0.5
# Lower bound on the ball at a new place of a junction, as a share of that in the middle nearby or at the old place.
# Rows "ball ratio of" in benchmarks/results/refinement.md, measured when the fit of tubes had the same bound: with 0 a
# tube has a wrong graph, the error of hard shapes is larger by a tenth and the medial one of meshes by a quarter, with
# 0.95 that of tubes by a twentieth. Also the radius over that of a junction's ball from which a limb is as thick as the
# ball: by hand, 83 of 99 creatures are right with it and with 0.8, 82 with 0.6
MIN_BALL_RATIO = 0.9
FIRST_STEP = 0.25  # in radii of the first ball
N_STEPS = 12  # each moves or halves the step, so that the last is at most a thousandth of a radius where none moves
DIRECTIONS = normalized(np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)]))


def climb_to_middle(
    points: NDArray[np.float64], frames: NDArray[np.float64], surface: Surface
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Move points away from the near side of the surface until another side is as near.

    Parameters
    ----------
    points : (k, 3) array of float
        Inside the surface, which no step leaves: each is shorter than the radius of its ball.
    frames : (k, 3, 3) array of float
        For each point three orthogonal unit vectors as rows; steps go along these, their sums and their differences.
    surface : Surface

    Returns
    -------
    points : (k, 3) array of float
    radii : (k,) array of float
        Distances of these to the surface.
    """
    P, directions = np.array(points), DIRECTIONS @ frames
    radii, nearest = (np.array(found) for found in surface.closest(P))
    steps, rows = FIRST_STEP * radii, np.arange(len(P))
    for _ in range(N_STEPS):
        ahead = P[:, None] + steps[:, None, None] * directions
        targets = radii + MIN_SLOPE * steps
        # a ball grows no larger than the distance of the point of the surface that was nearest before
        around = vector_lengths(ahead - nearest[:, None])
        may_grow = around >= targets[:, None]
        around[~may_grow] = 0.0
        touched = np.zeros_like(ahead)
        around[may_grow], touched[may_grow] = surface.closest(ahead[may_grow])
        best = np.argmax(around, axis=1)
        grows = around[rows, best] >= targets
        P[grows], radii[grows], nearest[grows] = (of[rows, best][grows] for of in (ahead, around, touched))
        steps[~grows] /= 2
    return P, radii
