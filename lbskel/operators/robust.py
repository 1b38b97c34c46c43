"""The tufted, mollified Laplacian: defined on any triangle soup and for any thin triangle, with weights >= 0.

It is the intrinsic Delaunay Laplacian of the tufted cover (:mod:`lbskel.operators.tufted_cover`), halved since the
cover has twice the area. Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes",
https://doi.org/10.1111/cgf.14069; the same matrix as that of the package robust_laplacian.
"""

from __future__ import annotations

__all__ = ["MOLLIFY_FACTOR", "robust"]

import igl
import numpy as np
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import zero_degenerate
from lbskel.operators.intrinsic_delaunay import mollification_offset
from lbskel.operators.intrinsic_triangulation import IntrinsicTriangulation, cotangents_of_lengths, delaunay
from lbskel.operators.tufted_cover import tufted_cover

MOLLIFY_FACTOR = 1e-5  # slack of the triangle inequalities, relative to the mean edge length: Sharp, Crane 2020


def robust(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the tufted Laplacian with the lumped mass of its cover.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length.
    """
    V, k = unit_scale(mesh.vertices)
    F, n = mesh.faces, len(mesh.vertices)
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    lengths = igl.edge_lengths(V, F)
    if not lengths.any():
        return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=np.unique(mesh.faces))
    offsets = mollification_offset(lengths, mollify_factor)
    lengths = lengths + offsets.max()
    faces, twins = tufted_cover(V, F)
    cover = delaunay(IntrinsicTriangulation(faces, np.concatenate([lengths, lengths[:, [0, 2, 1]]]), twins))
    # the rounding of flips may make mollified triangles degenerate again
    cotangents, degenerate = zero_degenerate(cotangents_of_lengths(cover.lengths))
    stiffness = stiffness_of_corner_weights(n, cover.faces, cotangents / 4)
    double_areas = igl.doublearea(cover.lengths, 0.0)
    thirds = np.repeat(double_areas / 12, 3)  # a third of a face's area for each corner, halved as the stiffness is
    mass = diagonal_matrix(np.ldexp(np.bincount(cover.faces.ravel(), thirds, n), 2 * k))
    treated = np.union1d(F[offsets > 0], cover.faces[degenerate.any(axis=1)])
    return Laplacian(stiffness, mass, treated_vertices=treated)
