"""Round tubes along the edges of a skeleton, and the places on their axes that are nearest to points.

A tube along an edge is the round cone between the balls at its ends: the union of the balls between them, whose centers
and radii change evenly. Its surface is nearest to a point along a normal, which a difference of the radii leans.
"""

from __future__ import annotations

__all__ = ["Feet", "Tubes", "feet_on_tubes", "nearest_balls_by_power", "tubes_around"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel._kernels.round_cones import nearest_cones
from lbskel.skeleton.skeleton import Skeleton

# Balls, those with the least power of a vertex, among whose edges its nearest cone is searched; they bound the time.
# Rows "nearest balls of" in benchmarks/results/refinement.md
N_NEAREST = 4
# Lower bound on radii, in medians over the branch: zero, where the only vertex of a node is on the axis, makes the
# systems of a fit singular. Rows "smallest radius of" there
MIN_RADIUS = 0.01


@dataclass(frozen=True, eq=False)
class Tubes:
    """Round cones along m edges, (m, 2), between k nodes: positions, (k, 3), and radii, (k,)."""

    edges: NDArray[np.int64]
    positions: NDArray[np.float64]
    radii: NDArray[np.float64]

    @property
    def unknowns(self) -> NDArray[np.float64]:
        """(4 k,) position and radius of one node after the other."""
        return np.column_stack([self.positions, self.radii]).ravel()


@dataclass(frozen=True, eq=False)
class Feet:
    """Where the axes are nearest to n vertices, as seen from the cones.

    Parameters
    ----------
    edges : (n,) array of int
        The edge of the cone that is nearest.
    shares : (n,) array of float
        The place along it, from 0 to 1.
    radii : (n,) array of float
        Of the cone at that place.
    distances : (n,) array of float
        From the surface of the cone, negative inside it.
    normals : (n, 3) array of float
        Unit vectors from the axis to the vertices.
    """

    edges: NDArray[np.int64]
    shares: NDArray[np.float64]
    radii: NDArray[np.float64]
    distances: NDArray[np.float64]
    normals: NDArray[np.float64]


def tubes_around(skeleton: Skeleton, radii: NDArray[np.float64], diameter_bound: float) -> Tubes:
    """Make tubes around the edges of a skeleton, with radii that are not nearly zero.

    Parameters
    ----------
    skeleton : Skeleton
    radii : (k,) array of float
    diameter_bound : float
        Upper bound on the extent of the shape, for branches without any radius.
    """
    least = np.maximum(MIN_RADIUS * skeleton.branch_medians(radii), MIN_RADIUS**2 * diameter_bound)
    return Tubes(skeleton.edges, skeleton.nodes, np.maximum(radii, least))


def nearest_balls_by_power(tubes: Tubes, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n, N_NEAREST) the nodes whose balls have the least power of each point, or all nodes if there are fewer.

    Parameters
    ----------
    tubes : Tubes
        At least one.
    points : (n, 3) array of float
    """
    used = np.unique(tubes.edges)
    P, r = tubes.positions[used], tubes.radii[used]
    # a tree of lifted centers separates no balls that are nearer than its largest radius: a soma has a tree of its own
    is_large = r > np.sqrt(np.median(r) * r.max())
    found = [_least_powers(P, r, group, points) for group in map(np.flatnonzero, (~is_large, is_large)) if len(group)]
    powers, numbers = (np.concatenate(each, axis=1) for each in zip(*found, strict=True))
    order = np.argsort(powers, axis=1, kind="stable")[:, :N_NEAREST]
    balls: NDArray[np.int64] = used[np.take_along_axis(numbers, order, axis=1)]
    return balls


def _least_powers(
    P: NDArray[np.float64], r: NDArray[np.float64], group: NDArray[np.int64], points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(n, k) powers of each point for the k of some balls where they are least, and (n, k) their numbers."""
    squares = r[group] ** 2
    tree = cKDTree(np.column_stack([P[group], np.sqrt(squares.max() - squares)]))  # squared distances: shifted powers
    ranks = np.arange(1, min(N_NEAREST, len(group)) + 1)
    distances, rows = tree.query(np.column_stack([points, np.zeros(len(points))]), k=ranks)
    return distances**2 - squares.max(), group[rows]


def feet_on_tubes(tubes: Tubes, points: NDArray[np.float64], balls: NDArray[np.int64]) -> Feet:
    """Find the nearest cone of each point.

    Parameters
    ----------
    tubes : Tubes
    points : (n, 3) array of float
    balls : (n, b) array of int
        For each point, nodes at whose edges the nearest cone may be.
    """
    ends = tubes.edges.ravel()
    first = np.append(0, np.cumsum(np.bincount(ends, minlength=len(tubes.radii))))
    edges_of_ball = np.argsort(ends, kind="stable") // 2
    nearest, feet = nearest_cones(
        np.ascontiguousarray(points), balls, tubes.positions, tubes.radii, tubes.edges, first, edges_of_ball
    )
    return Feet(nearest, shares=feet[:, 0], radii=feet[:, 1], distances=feet[:, 2], normals=feet[:, 3:])
