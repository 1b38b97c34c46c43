"""The tufted, mollified Laplacian: defined on any triangle soup and for any thin triangle, with weights >= 0.

It is the intrinsic Delaunay Laplacian of the tufted cover (:mod:`lbskel.operators.tufted_cover`), halved since the
cover has twice the area. Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes",
https://doi.org/10.1111/cgf.14069; the same matrix as that of the package robust_laplacian, but for faces
on the same three vertices: these count once, where the package glues them to each other.
"""

from __future__ import annotations

__all__ = ["MOLLIFY_FACTOR", "distinct_faces", "robust", "tufted_delaunay"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.geometry.intrinsic_triangulation import IntrinsicTriangulation, cotangents_of_lengths, delaunay
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.geometry.sorting import distinct, first_of_each
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import zero_degenerate
from lbskel.operators.intrinsic_delaunay import mollified_lengths
from lbskel.operators.tufted_cover import tufted_cover

MOLLIFY_FACTOR = 1e-5  # slack of the triangle inequalities, relative to the mean edge of a component: Sharp, Crane 2020


def robust(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the tufted Laplacian with the lumped mass of its cover; several faces on the same vertices count once.

    Where four vertices of the flipped triangles are on a circle, as on symmetric meshes, either diagonal gives the same
    stiffness. The order of the faces decides between them, and may change the mass there.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length of its component.
    """
    V, k = unit_vertices(mesh)
    n = len(mesh.vertices)
    cover, mollified = tufted_delaunay(V, mesh.faces, mollify_factor=mollify_factor)
    if not len(cover.faces):
        return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=np.unique(mesh.faces))
    # the rounding of flips may make mollified triangles degenerate again
    cotangents, degenerate = zero_degenerate(cotangents_of_lengths(cover.lengths))
    stiffness = stiffness_of_corner_weights(n, cover.faces, cotangents / 4)
    double_areas = igl.doublearea(cover.lengths, 0.0)
    thirds = np.repeat(double_areas / 12, 3)  # a third of a face's area for each corner, halved as the stiffness is
    with np.errstate(over="ignore"):  # Laplacian refuses infinite areas
        mass = diagonal_matrix(np.ldexp(np.bincount(cover.faces.ravel(), thirds, n), 2 * k))
    treated = distinct(np.append(mollified, cover.faces[np.flatnonzero(degenerate) // 3]))
    return Laplacian(stiffness, mass, treated_vertices=treated)


def distinct_faces(F: NDArray[np.int64]) -> NDArray[np.int64]:
    """Leave out the faces that use a vertex twice, and of those on the same three vertices all but the first.

    Parameters
    ----------
    F : (m, 3) array of int
    """
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    a, b, c = F.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    return F[first_of_each(np.stack([low, a + b + c - low - high, high], axis=1))]


def tufted_delaunay(
    V: NDArray[np.float64], F: NDArray[np.int64], *, mollify_factor: float = MOLLIFY_FACTOR
) -> tuple[IntrinsicTriangulation, NDArray[np.int64]]:
    """Build the mollified intrinsic Delaunay triangulation of the tufted cover, which has twice the area.

    Parameters
    ----------
    V : (n, 3) array of float
    F : (m, 3) array of int
        Only the :func:`distinct_faces` are used.
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length of its component.

    Returns
    -------
    cover : IntrinsicTriangulation
        Without faces if all vertices are at one point.
    mollified : (t,) array of int
        Vertices of the faces whose inequalities did not hold.
    """
    F = distinct_faces(F)  # the cover would glue copies to each other, and not to their neighbors
    lengths = igl.edge_lengths(V, F)
    if not lengths.any():
        empty = np.empty((0, 3))
        return IntrinsicTriangulation(empty.astype(np.int64), empty, np.empty(0, dtype=np.int64)), np.unique(F)
    lengths, is_thin = mollified_lengths(F, lengths, mollify_factor)
    faces, twins = tufted_cover(V, F)
    cover = delaunay(IntrinsicTriangulation(faces, np.concatenate([lengths, lengths[:, [0, 2, 1]]]), twins))
    return cover, distinct(F[is_thin].ravel())
