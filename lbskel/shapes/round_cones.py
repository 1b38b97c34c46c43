"""Solids made of round cones along polylines, as implicit functions: negative inside, zero on the surface.

A round cone is the union of the spheres whose center and radius run linearly from one end of a segment to the other.
For a point at height t along a segment of length l and at distance q from its line, with radii that decrease by the
slope ``sin a = (r0 - r1) / l``, the signed distance is the minimum over s in [0, l] of the convex function
``hypot(t - s, q) - r(s)``, which lies at ``s = clip(t - q tan a, 0, l)``. (The same distance in another form: I.
Quilez, "Distance functions", https://iquilezles.org/articles/distfunctions/.)

The segments of one branch are united by the minimum of their distances, so that the branch does not bulge at its
joints. Branches are united by the quadratic smooth minimum (I. Quilez, https://iquilezles.org/articles/smin/) in order
of decreasing largest radius, each over a width of BLEND_WIDTH times its largest radius.
"""

from __future__ import annotations

__all__ = ["BLEND_WIDTH", "Branch", "Solid", "solid_of", "subdivide"]

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.shapes.truth import Truth

Branch: TypeAlias = tuple[Any, Any]  # two array_like: the (k, 3) points of a polyline; k radii, or one for all points

# Width over which a branch is blended with the others, relative to its largest radius; a choice of style.
BLEND_WIDTH = 0.5
# Upper bound on the length of a segment, relative to the smaller radius at its ends; a guess.
MAX_SEGMENT_LENGTH = 0.5
# Distance up to which two points are one, relative to the largest side of the bounding box; a guess, above rounding.
MERGE_TOLERANCE = 1e-9
# Distance beyond the cutoff up to which a branch is evaluated, in blend widths. The smooth minimum of two values is at
# most 1/4 width below the smaller one, and only if they differ by less than 1 width: 1.25, and 1.25 for a third value.
BLEND_REACH = 2.5
# Distance of a branch that is not evaluated, in the units of the solid: larger than any, and its square is finite.
OUT_OF_RANGE = 1e30


@dataclass(frozen=True, eq=False)
class Solid:
    """A union of round cones, grouped in branches in order of decreasing largest radius.

    Parameters
    ----------
    centers : (k, 3) array of float
        Sphere centers.
    segments : (s, 2) array of int
        Indices of the centers at both ends of each round cone; a ball has the same index twice.
    radii : (s, 2) array of float
        Radii at both ends of each segment. They belong to segments, not to centers, because branches of different
        radii may meet in one center.
    branch_of_segment : (s,) array of int
        Branch index of each segment.
    blend : float
        Width over which a branch is blended with the others, relative to its largest radius.
    """

    centers: NDArray[np.float64]
    segments: NDArray[np.int64]
    radii: NDArray[np.float64]
    branch_of_segment: NDArray[np.int64]
    blend: float = BLEND_WIDTH

    @property
    def _max_radii(self) -> NDArray[np.float64]:
        """The (b,) largest radius of each branch."""
        max_radii = np.zeros(self.branch_of_segment.max() + 1)
        np.maximum.at(max_radii, self.branch_of_segment, self.radii.max(axis=1))
        return max_radii

    def _branch_distances(
        self, points: NDArray[np.float64], cutoff: float
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Compute the distances to the branches near each point, where they can change values below the cutoff.

        Returns
        -------
        distances : (n, m) array of float
            In order of the branches; m is the largest number of branches near one point. OUT_OF_RANGE beyond the last.
        branches : (n, m) array of int
            The branch of each distance; 0 beyond the last.
        """
        start, end = self.centers[self.segments].transpose(1, 0, 2)
        lengths = np.linalg.norm(end - start, axis=1)
        margin = BLEND_REACH * self.blend * self._max_radii[self.branch_of_segment] * self.branch_of_segment.any()
        outer = lengths / 2 + self.radii.max(axis=1) + margin + cutoff
        nearby = cKDTree(points).query_ball_point((start + end) / 2, outer)
        segment = np.repeat(np.arange(len(nearby)), [len(found) for found in nearby])
        point = np.concatenate([np.asarray(found, dtype=np.int64) for found in nearby])

        divisors = np.where(lengths > 0, lengths, 1.0)
        slopes = (self.radii[:, 0] - self.radii[:, 1]) / divisors
        direction = ((end - start) / divisors[:, None])[segment]
        offset = points[point] - start[segment]
        t = (offset * direction).sum(axis=1)
        q = np.linalg.norm(offset - t[:, None] * direction, axis=1)
        s = np.clip(t - q * (slopes / np.sqrt(1 - slopes**2))[segment], 0.0, lengths[segment])
        values = np.hypot(t - s, q) - (self.radii[segment, 0] - s * slopes[segment])

        n_branches = len(self._max_radii)
        pairs, pair = np.unique(point * n_branches + self.branch_of_segment[segment], return_inverse=True)
        nearest = np.full(len(pairs), OUT_OF_RANGE)
        np.minimum.at(nearest, pair, values)
        row, branch = np.divmod(pairs, n_branches)
        n_near = np.bincount(row, minlength=len(points))
        column = np.arange(len(pairs)) - np.repeat(np.cumsum(n_near) - n_near, n_near)
        shape = (len(points), max(int(n_near.max(initial=0)), 1))
        distances, branches = np.full(shape, OUT_OF_RANGE), np.zeros(shape, dtype=np.int64)
        distances[row, column], branches[row, column] = nearest, branch
        return distances, branches

    def distance(self, points: NDArray[np.float64], *, cutoff: float = 0.0) -> NDArray[np.float64]:
        """Evaluate the implicit function: (n,) values, exact where below ``cutoff`` and at least that elsewhere.

        Parameters
        ----------
        points : (n, 3) array of float
            Coordinates in the units of the solid.
        cutoff : float
            Not negative, in the units of the solid.
        """
        distances, branches = self._branch_distances(points, cutoff)
        widths = self.blend * self._max_radii[branches]
        total: NDArray[np.float64] = distances[:, 0]
        for other, width in zip(distances.T[1:], widths.T[1:], strict=True):
            share = np.clip(0.5 + 0.5 * (other - total) / width, 0.0, 1.0)
            total = share * total + (1 - share) * other - width * share * (1 - share)
        return total

    def gradient(self, points: NDArray[np.float64], *, step: float) -> NDArray[np.float64]:
        """Approximate the (n, 3) gradient of :meth:`distance` near the surface by central differences.

        Parameters
        ----------
        points : (n, 3) array of float
            Coordinates in the units of the solid.
        step : float
            Half the distance between the two points of a difference, in the units of the solid.
        """
        displaced = points[None, None] + step * np.stack([np.eye(3), -np.eye(3)])[:, :, None]
        ahead, behind = self.distance(displaced.reshape(-1, 3), cutoff=step).reshape(2, 3, len(points))
        return (ahead - behind).T / (2 * step)

    def nearest_branches(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """(n,) the branch that each point near the surface is nearest to, or deepest inside of.

        Parameters
        ----------
        points : (n, 3) array of float
            Coordinates in the units of the solid.
        """
        distances, branches = self._branch_distances(points, float(self._max_radii.max()))
        nearest: NDArray[np.int64] = branches[np.arange(len(points)), distances.argmin(axis=1)]
        return nearest

    @property
    def truth(self) -> Truth:
        """The axes of all branches; a node's radius is that of the largest sphere around it inside a single branch."""
        inscribed = -self._branch_distances(self.centers, 0.0)[0].min(axis=1)
        return Truth(self.centers, self.segments, inscribed)


def solid_of(branches: Sequence[Branch], *, blend: float = BLEND_WIDTH) -> Solid:
    """Build a solid around polylines.

    Parameters
    ----------
    branches : sequence of Branch
        The points of each polyline and the radii at them, or one radius for all. Branches that share a point are
        joined there. A polyline of one point is a ball; one that ends at its first point is a loop.
    blend : float
        Width over which a branch is blended with the others, relative to its largest radius.

    Raises
    ------
    MeshError
        If one of two neighboring spheres contains the other, so that there is no cone between them.
    """
    spheres_of_branch = [
        subdivide(np.atleast_2d(P), np.ravel(R), f"branch {number}") for number, (P, R) in enumerate(branches)
    ]
    spheres_of_branch.sort(key=lambda spheres: -spheres[:, 3].max())
    branch = np.repeat(np.arange(len(spheres_of_branch)), list(map(len, spheres_of_branch)))
    first = np.flatnonzero(np.diff(branch) == 0)
    segments = np.stack([first, first + 1], axis=1)
    spheres = np.concatenate(spheres_of_branch)
    size = np.ptp(spheres[:, :3], axis=0).max() or 1.0
    rounded = np.round(spheres[:, :3] / (MERGE_TOLERANCE * size)) + 0.0  # no negative zeros
    _, row_of_center, center = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return Solid(spheres[row_of_center, :3], center[segments], spheres[segments, 3], branch[first], blend)


def subdivide(points: NDArray[Any], radii: NDArray[Any], name: str) -> NDArray[np.float64]:
    """Sample a polyline by segments of at most MAX_SEGMENT_LENGTH: (k, 4) centers and radii; a single point twice.

    Parameters
    ----------
    points : (n, 3) array of float
    radii : (n,) or (1,) array of float
    name : str
        What the error calls the polyline.

    Raises
    ------
    MeshError
        If one of two neighboring spheres contains the other, so that there is no cone between them.
    """
    spheres = np.column_stack([points, np.broadcast_to(radii, len(points))]).astype(np.float64)
    if len(spheres) == 1:
        return np.repeat(spheres, 2, axis=0)
    lengths, radii = np.linalg.norm(np.diff(spheres[:, :3], axis=0), axis=1), spheres[:, 3]
    if (np.abs(np.diff(radii)) >= lengths).any():
        raise MeshError(f"{name} has a sphere inside its neighbor: move them apart or make their radii more similar")
    n_pieces = np.ceil(lengths / (MAX_SEGMENT_LENGTH * np.minimum(radii[1:], radii[:-1]))).astype(np.int64)
    parameters = np.concatenate([*(i + np.arange(k) / k for i, k in enumerate(n_pieces)), [len(spheres) - 1.0]])
    return np.stack([np.interp(parameters, np.arange(len(spheres)), column) for column in spheres.T], axis=1)
