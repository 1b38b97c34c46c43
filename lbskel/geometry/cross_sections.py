"""Plane sections of a mesh: the closed curve round a point, its centroid and size.

A section is cut exactly, triangle by triangle, so it does not depend on how densely the surface is sampled. Of the
curves that a plane cuts, the smallest that goes round the point counts, or the nearest where none does. Area and
centroid come from Green's theorem over its segments.

Triangles are looked for near the point first, then farther and farther. Curves of one plane do not cross, so one round
the point that lies within what was looked at is inside of any that does not, and no more need be known.
"""

from __future__ import annotations

__all__ = ["Sections", "cross_sections"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.cross_sections import SectionCurves
from lbskel.geometry.mesh import Mesh

NO_LABELS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Sections:
    """One section for each of k planes.

    Parameters
    ----------
    is_cut : (k,) array of bool
        Whether the plane meets the mesh at all.
    surrounds : (k,) array of bool
        Whether the curve goes round the point.
    centroids : (k, 3) array of float
        Of the area inside the curve; of the curve itself where it is not closed. The point itself where nothing is cut.
    areas : (k,) array of float
    lengths : (k,) array of float
        Of the curve.
    radii : (k,) array of float
        Mean distance of the curve from its centroid.
    own : (k,) array of float
        Share of the curve's length on faces with the label of the plane, or with a negative one, which is nobody's.
    """

    is_cut: NDArray[np.bool_]
    surrounds: NDArray[np.bool_]
    centroids: NDArray[np.float64]
    areas: NDArray[np.float64]
    lengths: NDArray[np.float64]
    radii: NDArray[np.float64]
    own: NDArray[np.float64]


def cross_sections(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    *,
    face_labels: NDArray[np.int64] | None = None,
    labels: NDArray[np.int64] | None = None,
) -> Sections:
    """The section of a mesh round each point, in the plane through it.

    Parameters
    ----------
    mesh : Mesh
    points, normals : (k, 3) array of float
        The planes; normals of length one.
    face_labels : (m,) array of int, optional
    labels : (k,) array of int, optional
        With these, ``own`` tells how much of each curve lies on faces of the plane's own label.
    """
    tree = mesh.boxes
    curves = SectionCurves(
        mesh.edge_of_half_edge,
        mesh.faces_per_edge,
        tree.order,
        tree.corners,
        tree.bounds,
        NO_LABELS if face_labels is None or labels is None else face_labels,
    )
    points, frames = np.ascontiguousarray(points, dtype=np.float64), _frames(normals)
    found = curves.measure(points, frames, np.zeros(len(points), dtype=np.int64) if labels is None else labels)
    is_cut, surrounds, x, y, areas, lengths, radii, own = found.T
    moved = points + x[:, None] * frames[:, 0] + y[:, None] * frames[:, 1]
    centroids = np.where(is_cut[:, None] > 0, moved, points)
    return Sections(is_cut > 0, surrounds > 0, centroids, areas, lengths, radii, own)


def _frames(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3, 3) two unit vectors in each plane, right-handed with its normal, and the normal."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=1)
