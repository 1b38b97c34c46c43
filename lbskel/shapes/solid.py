"""Solids made of round cones along polylines, as implicit functions: negative inside, zero on the surface.

A round cone is the union of the spheres whose center and radius run linearly from one end of a segment to the other.
For a point at height t along a segment of length l and at distance q from its line, with radii that fall by the slope
``sin a = (r0 - r1) / l``, the signed distance is the minimum over s in [0, l] of the convex function
``hypot(t - s, q) - r(s)``, which lies at ``s = clip(t - q tan a, 0, l)``. (The same distance in another form: I.
Quilez, "Distance functions", https://iquilezles.org/articles/distfunctions/.)

Segments of one branch are united by the plain minimum, so that nothing bulges along it; branches by the quadratic
smooth minimum (I. Quilez, https://iquilezles.org/articles/smin/), the thickest branch first, each over a width of BLEND
times its largest radius.
"""

from __future__ import annotations

__all__ = ["BLEND", "Branch", "Solid", "solid_of"]

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.shapes.truth import Truth

Branch: TypeAlias = tuple[Any, Any]  # two array_like: the (k, 3) points of a polyline; the radii there, or one

BLEND = 0.5
LONGEST_SEGMENT = 0.5  # in units of the smaller radius at its ends
SAME_POINT = 1e-9  # of the extent
INFLUENCE = 2.5  # in blending widths: 1.25 for a smooth union of two that may be zero, and as much for a third
FAR = 1e30


@dataclass(frozen=True, eq=False)
class Solid:
    """Round cones between spheres, grouped in branches of which the thickest comes first.

    Parameters
    ----------
    centers : (k, 3) array of float
    segments : (s, 2) array of int
        Pairs of centers; twice the same one is a ball.
    radii : (s, 2) array of float
        At both ends of each segment, since branches of different thickness may meet in one center.
    branch_of_segment : (s,) array of int
    """

    centers: NDArray[np.float64]
    segments: NDArray[np.int64]
    radii: NDArray[np.float64]
    branch_of_segment: NDArray[np.int64]

    @property
    def _thickest(self) -> NDArray[np.float64]:
        """(branches,) largest radius of each branch."""
        thickest = np.zeros(self.branch_of_segment.max() + 1)
        np.maximum.at(thickest, self.branch_of_segment, self.radii.max(axis=1))
        return thickest

    def _of_branches(self, points: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
        """(n, branches) distance to each branch; FAR where it is above ``reach`` and too far to blend."""
        start, end = self.centers[self.segments].transpose(1, 0, 2)
        lengths = np.linalg.norm(end - start, axis=1)
        influence = INFLUENCE * BLEND * self._thickest[self.branch_of_segment] * self.branch_of_segment.any()
        outer = lengths / 2 + self.radii.max(axis=1) + influence + reach
        near = cKDTree(points).query_ball_point((start + end) / 2, outer)
        segment = np.repeat(np.arange(len(near)), [len(found) for found in near])
        point = np.concatenate([np.asarray(found, dtype=np.int64) for found in near])

        divisors = np.where(lengths > 0, lengths, 1.0)
        slopes = (self.radii[:, 0] - self.radii[:, 1]) / divisors
        direction = ((end - start) / divisors[:, None])[segment]
        offset = points[point] - start[segment]
        t = (offset * direction).sum(axis=1)
        q = np.linalg.norm(offset - t[:, None] * direction, axis=1)
        s = np.clip(t - q * (slopes / np.sqrt(1 - slopes**2))[segment], 0.0, lengths[segment])
        distances = np.full((len(points), len(self._thickest)), FAR)
        cells = point * distances.shape[1] + self.branch_of_segment[segment]
        np.minimum.at(distances.reshape(-1), cells, np.hypot(t - s, q) - (self.radii[segment, 0] - s * slopes[segment]))
        return distances

    def distance(self, points: NDArray[np.float64], *, reach: float = 0.0) -> NDArray[np.float64]:
        """(n,) value of the implicit function, right where it is less than ``reach`` and not less than that elsewhere.

        Parameters
        ----------
        points : (n, 3) array of float
        reach : float
            Not negative, in the units of the solid.
        """
        total, *others = self._of_branches(points, reach).T
        for other, thickest in zip(others, self._thickest[1:], strict=True):
            width = BLEND * thickest
            share = np.clip(0.5 + 0.5 * (other - total) / width, 0.0, 1.0)
            total = share * total + (1 - share) * other - width * share * (1 - share)
        return total

    def gradient(self, points: NDArray[np.float64], *, step: float) -> NDArray[np.float64]:
        """(n, 3) central differences of :meth:`distance` near the surface."""
        sides = points[None, None] + step * np.stack([np.eye(3), -np.eye(3)])[:, :, None]
        ahead, behind = self.distance(sides.reshape(-1, 3), reach=step).reshape(2, 3, len(points))
        return (ahead - behind).T / (2 * step)

    @property
    def truth(self) -> Truth:
        """The axes of all branches; the radius at a node is that of the largest sphere around it inside one branch."""
        inscribed = -self._of_branches(self.centers, 0.0).min(axis=1)
        return Truth(self.centers, self.segments, inscribed)


def solid_of(branches: Sequence[Branch]) -> Solid:
    """The solid around some polylines, each given by its points and the radius at each of them or everywhere.

    Branches meet where they share a point. A polyline of one point is a ball; one that ends where it starts is a loop.

    Raises
    ------
    MeshError
        If one of two neighboring spheres swallows the other, so that there is no cone between them.
    """
    cut = [_finely(np.atleast_2d(P), np.ravel(R), f"branch {number}") for number, (P, R) in enumerate(branches)]
    cut.sort(key=lambda spheres: -spheres[:, 3].max())
    branch = np.repeat(np.arange(len(cut)), list(map(len, cut)))
    first = np.flatnonzero(np.diff(branch) == 0)
    segments = np.stack([first, first + 1], axis=1)
    spheres = np.concatenate(cut)
    extent = np.ptp(spheres[:, :3], axis=0).max() or 1.0
    places = np.round(spheres[:, :3] / (SAME_POINT * extent)) + 0.0  # no negative zeros
    _, row_of_center, center = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return Solid(spheres[row_of_center, :3], center[segments], spheres[segments, 3], branch[first])


def _finely(points: NDArray, radii: NDArray, name: str) -> NDArray[np.float64]:
    """(k, 4) centers and radii along a polyline whose segments are cut to LONGEST_SEGMENT; a ball's twice."""
    spheres = np.column_stack([points, np.broadcast_to(radii, len(points))]).astype(np.float64)
    if len(spheres) == 1:
        return np.repeat(spheres, 2, axis=0)
    lengths, radii = np.linalg.norm(np.diff(spheres[:, :3], axis=0), axis=1), spheres[:, 3]
    if (np.abs(np.diff(radii)) >= lengths).any():
        raise MeshError(f"{name} has a sphere inside its neighbor: place them further apart or make them more alike")
    pieces = np.ceil(lengths / (LONGEST_SEGMENT * np.minimum(radii[1:], radii[:-1]))).astype(np.int64)
    at = np.concatenate([*(i + np.arange(k) / k for i, k in enumerate(pieces)), [len(spheres) - 1.0]])
    return np.stack([np.interp(at, np.arange(len(spheres)), column) for column in spheres.T], axis=1)
