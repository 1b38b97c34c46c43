"""The direction of view: along the principal axis of least variance, by orthographic projection.

The principal axes are the eigenvectors of the second moment of the surface, ``C = integral (x - c)(x - c)^T dA``. The
quadrature at the three edge midpoints of each triangle, with a third of its area each, is exact for quadratics, so the
moment does not depend on the triangulation.
"""

from __future__ import annotations

__all__ = ["Drawable", "View", "principal_view"]

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton

Drawable: TypeAlias = Mesh | PointCloud | Skeleton

# Fraction of the total variance added to x, y and z, so that a shape with two equal variances is seen along z with x to
# the right, and not along an axis that rounding chooses. A guess, small enough to leave other shapes as they are.
AXIS_BIAS = np.diag([2e-3, 1e-3, 0.0])
# The y or z axis can be up if its angle to the image plane is at most 30 degrees; a guess.
MIN_UP_COSINE = np.cos(np.radians(30))
# Points count as touching the ground up to this height above the lowest, relative to the shape's height; a guess.
CONTACT_HEIGHT = 0.05


@dataclass(frozen=True, eq=False)
class View:
    """An orthographic camera.

    Parameters
    ----------
    center : (3,) array of float
        The point at the origin of the projection, in the caller's units: of a principal view the middle of the box of
        the midpoints of the faces' edges, of the nodes or of the points.
    axes : (3, 3) array of float
        Orthonormal rows: to the right, up, towards the viewer.
    """

    center: NDArray[np.float64]
    axes: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute (n, 3) coordinates (right, up, towards the viewer) relative to the center.

        Parameters
        ----------
        points : (n, 3) array of float
            In the caller's units.
        """
        coordinates: NDArray[np.float64] = (points - self.center) @ self.axes.T
        return coordinates


def principal_view(shape: Drawable) -> View:
    """Choose the view along the axis of least variance.

    Up is the caller's y or z axis if it is close to the image plane. If both are, up is the one on which the shape
    would stand and not fall over, or else the one of smaller variance. If neither is, up is the second principal axis,
    so that the longest is horizontal. Signs: the viewer is on the positive side of the coordinate axis closest to the
    direction of view, and y or z increases upwards.

    Parameters
    ----------
    shape : Mesh, PointCloud or Skeleton

    Raises
    ------
    MeshError
        If coordinates are so large that areas are infinite.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        points, weights = _quadrature(shape)
        if not len(points):
            return View(np.zeros(3), np.eye(3))
        low, high = points.min(axis=0), points.max(axis=0)
        size = np.linalg.norm(high - low) or 1.0
        X = (points - low) / size  # before squaring, since coordinates may be far from the origin, or tiny
        X -= np.average(X, axis=0, weights=weights)
        moment = (X * (weights / weights.sum())[:, None]).T @ X
    if not np.isfinite(moment).all():
        raise MeshError("a shape cannot be shown whose coordinates are so large that areas are infinite")
    principal = np.linalg.eigh(moment + (np.trace(moment) or 1.0) * AXIS_BIAS)[1].T
    to_viewer = _oriented_along(principal[0], np.eye(3))
    up = _up_direction(to_viewer, X, moment, principal[1])
    right = np.cross(up, to_viewer)
    return View((low + high) / 2, np.stack([right, up, to_viewer]))


def _quadrature(shape: Drawable) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find points and weights with the second moment of the shape: of its surface, its edges, or else its points."""
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


def _up_direction(
    to_viewer: NDArray[np.float64], X: NDArray[np.float64], moment: NDArray[np.float64], second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Choose the unit vector normal to the direction of view that is shown upwards."""
    y_and_z = np.eye(3)[1:]
    in_plane = y_and_z - np.outer(y_and_z @ to_viewer, to_viewer)
    lengths = np.linalg.norm(in_plane, axis=1)
    upright = in_plane[lengths >= MIN_UP_COSINE] / lengths[lengths >= MIN_UP_COSINE, None]
    if not len(upright):
        return _oriented_along(second, y_and_z)
    variances = np.einsum("ij,jk,ik->i", upright, moment, upright)
    is_unstable = [not _is_stable(X @ axis, X @ np.cross(axis, to_viewer)) for axis in upright]
    up: NDArray[np.float64] = upright[np.lexsort((variances.round(9), is_unstable))[0]]  # y if equal up to rounding
    return up


def _is_stable(height: NDArray[np.float64], across: NDArray[np.float64]) -> bool:
    """Whether the shape's center of mass, at 0, is above the interval in which it touches the ground."""
    contact = across[height <= height.min() + CONTACT_HEIGHT * np.ptp(height)]
    return bool(contact.min() <= 0 <= contact.max())


def _oriented_along(vector: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Flip the vector, if needed, so that its component along the axis closest to it is positive."""
    components = axes @ vector
    return vector if components[np.argmax(np.abs(components).round(9))] >= 0 else -vector
