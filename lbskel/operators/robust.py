"""The tufted, mollified Laplacian: defined on any triangle soup and for any thin triangle, with weights >= 0.

Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes", https://doi.org/10.1111/cgf.14069; by
robust_laplacian.
"""

from __future__ import annotations

__all__ = ["MOLLIFY_FACTOR", "robust"]

import igl
import numpy as np
import robust_laplacian
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.intrinsic_delaunay import mollification_offset

MOLLIFY_FACTOR = 1e-5  # slack of the triangle inequalities, relative to the mean edge length: Sharp, Crane 2020


def robust(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the tufted Laplacian with the lumped mass of its cover.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length; multiplied by ten while the matrices
        are not finite.
    """
    V, k = unit_scale(mesh.vertices)
    F, n = mesh.faces, len(mesh.vertices)
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    lengths = igl.edge_lengths(V, F)
    if not lengths.any():
        return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=np.unique(mesh.faces))
    treated = np.unique(F[mollification_offset(lengths, mollify_factor) > 0])
    stiffness, mass = robust_laplacian.mesh_laplacian(V, F, mollify_factor=mollify_factor)
    while not (np.isfinite(stiffness.data).all() and np.isfinite(mass.data).all()) and mollify_factor < 1:
        mollify_factor *= 10
        stiffness, mass = robust_laplacian.mesh_laplacian(V, F, mollify_factor=mollify_factor)
    is_unused = np.ones(n)
    is_unused[F] = 0  # robust_laplacian puts a one on the diagonal of vertices without a face
    return Laplacian(
        csc_array(stiffness) - diagonal_matrix(is_unused),
        np.ldexp(1.0, 2 * k) * csc_array(mass),
        treated_vertices=treated,
    )
