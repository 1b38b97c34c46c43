"""Plane cross-sections of a mesh: the intersection curve around a point, its centroid and size.

The plane is intersected with each triangle exactly, so the result does not depend on the sampling density. Of several
intersection curves, the smallest that surrounds the point is taken, or the nearest if none does. Area and centroid
follow from Green's theorem over its segments.

Triangles are searched in growing neighborhoods of the point. Curves in one plane do not intersect each other, so a
curve around the point that lies in the searched neighborhood is inside any that does not, and the search can stop. It
also stops where the nearest curve is short relative to the neighborhood: the point lies outside of a thin part.
"""

from __future__ import annotations

__all__ = ["Sections", "cross_sections"]

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.cross_sections import SectionCurves
from lbskel.geometry.deadline import NEVER, Deadline, in_slices
from lbskel.geometry.mesh import Mesh

NO_LABELS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Sections:
    """One cross-section for each of k planes.

    Parameters
    ----------
    is_cut : (k,) array of bool
        Whether the plane intersects the mesh.
    surrounds : (k,) array of bool
        Whether the curve surrounds the point.
    centroids : (k, 3) array of float
        Of the area inside the curve; of the curve itself if it is open; the given point if there is no intersection.
    areas : (k,) array of float
        Inside the curve, in squared units of the mesh.
    lengths : (k,) array of float
        Of the curve, in units of the mesh.
    radii : (k,) array of float
        Mean distance of the curve from its centroid.
    label_fractions : (k,) array of float
        Fraction of the curve's length on faces with the label of the plane or with a negative label.
    """

    is_cut: NDArray[np.bool_]
    surrounds: NDArray[np.bool_]
    centroids: NDArray[np.float64]
    areas: NDArray[np.float64]
    lengths: NDArray[np.float64]
    radii: NDArray[np.float64]
    label_fractions: NDArray[np.float64]


def cross_sections(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    *,
    face_labels: NDArray[np.int64] | None = None,
    labels: NDArray[np.int64] | None = None,
    max_reaches: NDArray[np.float64] | None = None,
    deadline: Deadline = NEVER,
) -> Sections:
    """Compute the cross-section of a mesh around each point, in the plane through it.

    Parameters
    ----------
    mesh : Mesh
    points, normals : (k, 3) array of float
        A point on each plane and its unit normal.
    face_labels : (m,) array of int, optional
        Negative labels belong to every plane.
    labels : (k,) array of int, optional
        Of the planes. With both, ``label_fractions`` compares them.
    max_reaches : (k,) array of float, optional
        Distance from each point beyond which no curve is followed: what is undecided there counts as no intersection.
    deadline : Deadline
    """
    tree = mesh.aabb_tree
    face_labels = NO_LABELS if face_labels is None or labels is None else face_labels
    arrays = mesh.edge_of_half_edge, mesh.faces_per_edge, tree.order, tree.corners, tree.bounds, face_labels
    of_thread = threading.local()  # curves hold the state of a search, so each thread has its own

    def measured(*planes: NDArray[Any]) -> tuple[NDArray[np.float64]]:
        if not hasattr(of_thread, "curves"):
            of_thread.curves = SectionCurves(*arrays)
        return (of_thread.curves.measure(*planes),)

    points, frames = np.ascontiguousarray(points, dtype=np.float64), _frames(normals)
    labels = np.zeros(len(points), dtype=np.int64) if labels is None else labels
    reaches = np.full(len(points), np.inf) if max_reaches is None else max_reaches
    (found,) = in_slices(measured, points, frames, labels, reaches, deadline=deadline)
    is_cut, surrounds, x, y, areas, lengths, radii, label_fractions = found.T
    moved = points + x[:, None] * frames[:, 0] + y[:, None] * frames[:, 1]
    centroids = np.where(is_cut[:, None] > 0, moved, points)
    return Sections(is_cut > 0, surrounds > 0, centroids, areas, lengths, radii, label_fractions)


def _frames(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3, 3) right-handed frame of each plane: two unit vectors in it and its normal.

    Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin 2017, "Building an orthonormal basis, revisited",
    JCGT 6(1), https://jcgt.org/published/0006/01/01/.
    """
    x, y, z = normals.T
    sign = np.where(z < 0, -1.0, 1.0)
    a = -1 / (sign + z)
    b = x * y * a
    frames = np.empty((len(normals), 3, 3))
    frames[:, 0, 0], frames[:, 0, 1], frames[:, 0, 2] = 1 + sign * x * x * a, sign * b, -sign * x
    frames[:, 1, 0], frames[:, 1, 1], frames[:, 1, 2] = b, sign + y * y * a, -y
    frames[:, 2] = normals
    return frames
