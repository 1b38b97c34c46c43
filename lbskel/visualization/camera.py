"""Where a shape is looked at from: along the axis in which it is thinnest, with the top up.

The axes are the eigenvectors of the second moment of the surface, ``C = integral (x - c)(x - c)^T dA``, which does not
depend on how the surface is cut into triangles: the three edge midpoints of a triangle, a third of its area each,
integrate a quadratic exactly. A distant viewer, so no perspective.
"""

from __future__ import annotations

__all__ = ["Shape", "View", "principal_view"]

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton

Shape: TypeAlias = Mesh | PointCloud | Skeleton

# Share of the total variance added to x, y and z, so that a shape as wide in two directions is seen along z, x to the
# right, and not along whatever rounding makes of it.
PREFERENCE = np.diag([2e-3, 1e-3, 0.0])
UPRIGHT = np.cos(np.radians(30))  # an axis of the caller is taken as up if it lies this near to the picture's plane

FOOT = 0.05  # the part of a shape's height that touches the ground


@dataclass(frozen=True, eq=False)
class View:
    """A direction to look from.

    Parameters
    ----------
    center : (3,) array of float
        The point in the middle, in the caller's units.
    axes : (3, 3) array of float
        Rows of unit length: to the right, up, towards the viewer.
    """

    center: NDArray[np.float64]
    axes: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points as (right, up, towards the viewer), measured from the center, in the caller's units."""
        return (points - self.center) @ self.axes.T


def principal_view(shape: Shape) -> View:
    """Look along the axis of least variance.

    Up is the caller's y or z axis where one lies close to the picture's plane; where both do, that on which the shape
    would stand rather than fall over, else that along which it is shorter. Where neither does, up is the second
    principal axis, so that the longest is horizontal. Signs: the viewer is on the positive side, and up is where y or z
    grows.
    """
    points, weights = _samples(shape)
    if not len(points):
        return View(np.zeros(3), np.eye(3))
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.linalg.norm(high - low) or 1.0
    X = (points - low) / size  # before any square: coordinates may be far from the origin, or tiny
    X -= np.average(X, axis=0, weights=weights)
    moment = (X * (weights / weights.sum())[:, None]).T @ X
    principal = np.linalg.eigh(moment + (np.trace(moment) or 1.0) * PREFERENCE)[1].T
    towards = _positive(principal[0], np.eye(3))
    up = _up(towards, X, moment, principal[1])
    right = np.cross(up, towards)
    return View((low + high) / 2, np.stack([right, up, towards]))


def _samples(shape: Shape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights with the moments of the shape: of its surface, its edges, or else its points."""
    if isinstance(shape, Mesh):
        A, B, C = shape.vertices[shape.faces].transpose(1, 0, 2)
        points, weights = np.concatenate([A + B, B + C, C + A]) / 2, np.tile(shape.face_areas, 3)
    elif isinstance(shape, Skeleton) and len(shape.edges):
        start, end = shape.nodes[shape.edges].transpose(1, 0, 2)
        points = np.concatenate([start, end, (start + end) / 2])
        weights = np.concatenate([shape.edge_lengths, shape.edge_lengths, 4 * shape.edge_lengths])  # Simpson's rule
    else:
        points = shape.points if isinstance(shape, PointCloud) else shape.nodes
        weights = np.ones(len(points))
    return points, weights / weights.max() if weights.any() else np.ones(len(points))


def _up(
    towards: NDArray[np.float64], X: NDArray[np.float64], moment: NDArray[np.float64], second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The unit vector across the direction of view that is shown upwards."""
    y_and_z = np.eye(3)[1:]
    in_plane = y_and_z - np.outer(y_and_z @ towards, towards)
    lengths = np.linalg.norm(in_plane, axis=1)
    upright = in_plane[lengths >= UPRIGHT] / lengths[lengths >= UPRIGHT, None]
    if not len(upright):
        return _positive(second, y_and_z)
    variances = np.einsum("ij,jk,ik->i", upright, moment, upright)
    falls = [not _stands(X @ up, X @ np.cross(up, towards)) for up in upright]
    return upright[np.lexsort((variances.round(9), falls))[0]]  # y where rounding decides


def _stands(height: NDArray[np.float64], across: NDArray[np.float64]) -> bool:
    """Whether the center, at 0, lies above the ground on which the lowest points stand."""
    foot = across[height <= height.min() + FOOT * np.ptp(height)]
    return bool(foot.min() <= 0 <= foot.max())


def _positive(vector: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The vector or its opposite, whichever points along the axis that it agrees with most."""
    agreement = axes @ vector
    return vector if agreement[np.argmax(np.abs(agreement).round(9))] >= 0 else -vector
