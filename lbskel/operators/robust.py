"""The tufted, mollified Laplacian: defined on any triangle soup, weights >= 0, no triangle too thin.

Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes", https://doi.org/10.1111/cgf.14069; by
robust_laplacian.
"""

from __future__ import annotations

__all__ = ["robust"]

import igl
import numpy as np
import robust_laplacian
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.intrinsic_delaunay import mollification_offset

MOLLIFY_FACTOR = 1e-5


def robust(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """The tufted Laplacian with the lumped mass of its cover.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Every triangle inequality is made to hold by at least this fraction of the mean edge length.
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
    absent = np.ones(n)
    absent[F] = 0  # robust_laplacian gives vertices without a face a one on the diagonal
    return Laplacian(
        csc_array(stiffness) - diagonal_matrix(absent),
        np.ldexp(1.0, 2 * k) * csc_array(mass),
        treated_vertices=treated,
    )
