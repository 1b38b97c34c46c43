"""Planes about which a shape may be symmetric."""

from __future__ import annotations

__all__ = ["Mirror", "mirror_between", "mirrors_at_centroid", "principal_axes"]

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Mirror:
    """A plane, and reflection in it.

    Parameters
    ----------
    point, normal : (3,) array of float
        The normal has length 1.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]

    def heights(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) signed distance of points from the plane, positive on the side that the normal points to."""
        heights: NDArray[np.float64] = (points - self.point) @ self.normal
        return heights

    def mirrored(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, 3) mirror images of points."""
        return points - 2 * self.heights(points)[:, None] * self.normal


def mirrors_at_centroid(mesh: Mesh, normals: ArrayLike) -> Iterator[Mirror]:
    """Yield the planes through the centroid of a mesh with given normals, whose largest component becomes positive.

    Parameters
    ----------
    mesh : Mesh
    normals : (k, 3) array_like
        Of length 1.
    """
    for normal in np.asarray(normals):
        yield Mirror(mesh.centroid, _to_positive_side(normal))


def mirror_between(points: NDArray[np.float64], images: NDArray[np.float64], weights: NDArray[np.float64]) -> Mirror:
    """Find the plane with the least weighted sum of squared distances of mirrored points from their images.

    It goes through the middle between the two centroids, and its normal n is that with the least n' (C + C') n, where C
    is the covariance of the points and the images: a reflection takes p to p - 2 (n' p) n.

    Parameters
    ----------
    points, images : (k, 3) array of float
    weights : (k,) array of float
        Not all zero.
    """
    centers = [np.average(each, axis=0, weights=weights) for each in (points, images)]
    covariance = ((points - centers[0]) * weights[:, None]).T @ (images - centers[1])
    normal = np.linalg.eigh(covariance + covariance.T)[1][:, 0]
    return Mirror((centers[0] + centers[1]) / 2, _to_positive_side(normal))


def _to_positive_side(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) the normal or its opposite, so that its largest component is positive."""
    positive: NDArray[np.float64] = normal * np.sign(normal[np.argmax(np.abs(normal))])
    return positive


def principal_axes(mesh: Mesh) -> NDArray[np.float64]:
    """(3, 3) principal axes of the surface in rows, from the thinnest direction to the longest.

    A plane of symmetry is normal to one of them, unless two second moments are equal. The moments are exact: those of a
    triangle are a twelfth of its area times the sum of the moments of its corners and of the sum of its corners.

    Parameters
    ----------
    mesh : Mesh
        With a positive area.
    """
    offsets = (mesh.vertices - mesh.centroid) / mesh.diameter_bound  # squares of tiny lengths would vanish
    sums = offsets[mesh.faces[:, 0]] + offsets[mesh.faces[:, 1]] + offsets[mesh.faces[:, 2]]
    of_corners = (offsets * (3 * mesh.vertex_areas / mesh.area)[:, None]).T @ offsets
    of_sums = (sums * (mesh.face_areas / mesh.area)[:, None]).T @ sums
    axes: NDArray[np.float64] = np.linalg.eigh(of_corners + of_sums)[1].T
    return axes
