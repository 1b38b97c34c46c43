"""The tufted, mollified Laplacian: defined on any triangle soup, weights >= 0, no triangle too thin.

Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes", https://doi.org/10.1111/cgf.14069; by
robust_laplacian.
"""

from __future__ import annotations

__all__ = ["robust"]

import numpy as np
import robust_laplacian
from scipy.sparse import csc_array

from lbskel.mesh import Mesh
from lbskel.operators.laplacian import Laplacian

MOLLIFY_FACTOR = 1e-5


def robust(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """The tufted Laplacian with the lumped mass of its cover.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Every triangle inequality is made to hold by at least this fraction of the mean edge length.
    """
    F = mesh.faces
    distinct = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    stiffness, mass = robust_laplacian.mesh_laplacian(
        np.array(mesh.vertices), np.ascontiguousarray(F[distinct]), mollify_factor=mollify_factor
    )
    return Laplacian(csc_array(stiffness), csc_array(mass))
