"""Round tubes along the edges of a skeleton, and the places on their axes that are nearest to points.

A tube along an edge is the round cone between the balls at its ends: the union of the balls between them, whose centers
and radii change evenly. Its surface is nearest to a point along a normal, which a difference of the radii leans.
"""

from __future__ import annotations

__all__ = ["Feet", "Tubes", "feet_on_tubes", "nearby_edges", "tubes_around"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.skeleton.skeleton import Skeleton

# Balls, those with the least power of a vertex, among whose edges its nearest cone is searched; they bound the time.
# Rows "nearest balls of" in benchmarks/results/refinement.md
N_NEAREST = 4
# Lower bound on radii, in medians over the branch: zero, where the only vertex of a node is on the axis, makes the
# systems of a fit singular. Rows "smallest radius of" there
MIN_RADIUS = 0.01
EPSILON, TINY = float(np.finfo(np.float64).eps), float(np.finfo(np.float64).tiny)


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


def feet_on_tubes(
    tubes: Tubes, points: NDArray[np.float64], nearby: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> Feet:
    """Find the nearest cone of each point.

    Parameters
    ----------
    tubes : Tubes
    points : (n, 3) array of float
    nearby : tuple of arrays of int
        Rows of points and edges that may be nearest to them, by row: at least one edge for each point.
    """
    P, r = tubes.positions, tubes.radii
    rows, edges = nearby
    i, j = tubes.edges[edges].T
    axis, offset = P[j] - P[i], points[rows] - P[i]
    squared = np.maximum(np.einsum("ni,ni->n", axis, axis), TINY)
    share = np.einsum("ni,ni->n", offset, axis) / squared
    height = np.sqrt(np.maximum(np.einsum("ni,ni->n", offset, offset) - share**2 * squared, 0.0))
    # the sine of half the cone's angle; from 1 on, one ball is in the other
    slope = np.clip((r[i] - r[j]) / np.sqrt(squared), -1.0, 1.0)
    share = np.clip(share - height * slope / np.sqrt(np.maximum(1 - slope**2, EPSILON) * squared), 0.0, 1.0)
    normal = offset - share[:, None] * axis
    length = np.linalg.norm(normal, axis=1)
    radius = (1 - share) * r[i] + share * r[j]
    distance = length - radius
    begins = np.searchsorted(rows, np.arange(len(points)))
    is_least = distance == np.minimum.reduceat(distance, begins)[rows]
    best = np.flatnonzero(is_least)[np.searchsorted(rows[is_least], np.arange(len(points)))]
    normals = normal[best] / np.maximum(length[best], TINY)[:, None]
    return Feet(edges[best], share[best], radius[best], distance[best], normals)


def nearby_edges(tubes: Tubes, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of points and edges that may be nearest to them, by row: those at the N_NEAREST balls by their power.

    Parameters
    ----------
    tubes : Tubes
        At least one.
    points : (n, 3) array of float
    """
    used = np.unique(tubes.edges)
    P, r = tubes.positions[used], tubes.radii[used]
    lifted = np.column_stack([P, np.sqrt(np.maximum(r.max() ** 2 - r**2, 0.0))])  # distances there are powers
    n_nearest = min(N_NEAREST, len(P))
    near = used[cKDTree(lifted).query(np.column_stack([points, np.zeros(len(points))]), k=n_nearest)[1]]
    near = near.reshape(len(points), n_nearest)
    ends = tubes.edges.ravel()
    order = np.argsort(ends, kind="stable")
    sizes = np.bincount(ends)
    first = np.cumsum(sizes) - sizes
    counts = sizes[near.ravel()]
    rows = np.repeat(np.repeat(np.arange(len(points)), n_nearest), counts)
    place = np.arange(counts.sum()) + np.repeat(first[near.ravel()] - np.cumsum(counts) + counts, counts)
    edges = order[place] // 2
    first = np.sort(np.unique(rows * len(tubes.edges) + edges, return_index=True)[1])  # edges between two of the balls
    return rows[first], edges[first]
