"""Solids made of round cones along polylines, as implicit functions: negative inside, zero on the surface.

A round cone is the union of the spheres whose centre and radius run linearly from one end of a segment to the other.
With a point at height t along a segment of length l and at distance q from its line, and radii that fall by the slope
``sin a = (r0 - r1) / l``, the signed distance is the minimum over s in [0, l] of the convex function
``hypot(t - s, q) - r(s)``, which lies at ``s = clip(t - q tan a, 0, l)``. (The same distance in another form: I. Quilez,
"Distance functions", https://iquilezles.org/articles/distfunctions/.)

Segments of one branch are united by the plain minimum, so that nothing bulges along it; branches by the quadratic
smooth minimum (I. Quilez, https://iquilezles.org/articles/smin/) over a width of BLEND times the smaller radius there.
"""

from __future__ import annotations

__all__ = ["BLEND", "Branch", "Solid", "solid_of"]

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.shapes.truth import Truth

Branch: TypeAlias = tuple[ArrayLike, ArrayLike]

BLEND = 0.5
LONGEST_SEGMENT = 0.5  # in units of the smaller radius at its ends
SAME_CENTRE = 9  # decimals; the shapes have sizes near 1
FAR = 1e30


@dataclass(frozen=True, eq=False)
class Solid:
    """Round cones between spheres, grouped in branches.

    Parameters
    ----------
    centres : (k, 3) array of float
    segments : (s, 2) array of int
        Pairs of centres; twice the same one is a ball.
    radii : (s, 2) array of float
        At both ends of each segment, since branches of different thickness may meet in one centre.
    branch_of_segment : (s,) array of int
    """

    centres: NDArray[np.float64]
    segments: NDArray[np.int64]
    radii: NDArray[np.float64]
    branch_of_segment: NDArray[np.int64]

    def _by_branch(self, points: NDArray[np.float64], reach: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n, branches) distance to each branch, FAR where it is out of reach, and its radius at the foot point.

        In reach is a segment that can be nearer than ``reach``, or change a smooth union that is.
        """
        start, end = self.centres[self.segments].transpose(1, 0, 2)
        lengths = np.linalg.norm(end - start, axis=1)
        thickest = self.radii.max(axis=1)
        influence = 1.25 * BLEND * thickest if self.branch_of_segment.any() else 0.0
        outer = lengths / 2 + thickest + influence + reach
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
        r = self.radii[segment, 0] - s * slopes[segment]
        d = np.hypot(t - s, q) - r

        shape = (len(points), int(self.branch_of_segment.max()) + 1)
        distance, radius = np.full(shape, FAR), np.zeros(shape)
        cell = point * shape[1] + self.branch_of_segment[segment]
        np.minimum.at(distance.reshape(-1), cell, d)
        foot = d == distance.flat[cell]
        radius.flat[cell[foot]] = r[foot]
        return distance, radius

    def distance(self, points: NDArray[np.float64], *, reach: float = 0.0) -> NDArray[np.float64]:
        """(n,) value of the implicit function, reliable where it is less than ``reach`` and not less elsewhere.

        Parameters
        ----------
        points : (n, 3) array of float
        reach : float
            Not negative, in the units of the solid.
        """
        distances, radii = self._by_branch(points, reach)
        total, radius = distances[:, 0], radii[:, 0]
        for other, other_radius in zip(distances.T[1:], radii.T[1:], strict=True):
            width = np.maximum(BLEND * np.minimum(radius, other_radius), 1 / FAR)
            share = np.clip(0.5 + 0.5 * (other - total) / width, 0.0, 1.0)
            total = share * total + (1 - share) * other - width * share * (1 - share)
            radius = share * radius + (1 - share) * other_radius
        return total

    def gradient(self, points: NDArray[np.float64], *, step: float) -> NDArray[np.float64]:
        """(n, 3) central differences of :meth:`distance` near the surface."""
        sides = points[None, None] + step * np.stack([np.eye(3), -np.eye(3)])[:, :, None]
        ahead, behind = self.distance(sides.reshape(-1, 3), reach=step).reshape(2, 3, len(points))
        return (ahead - behind).T / (2 * step)

    @property
    def truth(self) -> Truth:
        """The axes of all branches; the radius at a node is that of the largest sphere of one branch that fits there."""
        inscribed = -self._by_branch(self.centres, 0.0)[0].min(axis=1)
        return Truth(self.centres, self.segments, inscribed)


def solid_of(branches: Sequence[Branch]) -> Solid:
    """The solid around some polylines, each given by its points and the radius at each of them or everywhere.

    Branches meet where they share a point. A polyline of one point is a ball; one that ends where it starts is a loop.

    Raises
    ------
    MeshError
        If one of two neighbouring spheres swallows the other, so that there is no cone between them.
    """
    points, radii, segments, owners = [], [], [], []
    for number, (polyline, thickness) in enumerate(branches):
        P = np.atleast_2d(np.asarray(polyline, dtype=np.float64))
        R = np.broadcast_to(np.asarray(thickness, dtype=np.float64), len(P))
        lengths = np.linalg.norm(np.diff(P, axis=0), axis=1)
        if (np.abs(np.diff(R)) >= lengths).any():
            raise MeshError(f"branch {number} has a sphere inside its neighbour: place them further apart")
        pieces = np.ceil(lengths / (LONGEST_SEGMENT * np.minimum(R[1:], R[:-1]))).astype(int)
        at = np.concatenate([i + np.arange(k) / k for i, k in enumerate(pieces)] + [[len(P) - 1.0]])
        first = sum(map(len, points))
        points.append(np.stack([np.interp(at, np.arange(len(P)), axis) for axis in P.T], axis=1))
        ends = (
            np.stack([np.arange(len(at) - 1), np.arange(1, len(at))], axis=1) if len(at) > 1 else np.zeros((1, 2), int)
        )
        radii.append(np.interp(at, np.arange(len(P)), R)[ends])
        segments.append(ends + first)
        owners.append(np.full(len(ends), number))
    rounded = np.round(np.concatenate(points), SAME_CENTRE) + 0.0  # no negative zeros
    centres, row = np.unique(rounded, axis=0, return_inverse=True)
    return Solid(centres, row[np.concatenate(segments)], np.concatenate(radii), np.concatenate(owners))
