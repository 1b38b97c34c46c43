"""The cotangent Laplacian with an identity row at every vertex of a degenerate triangle.

A common fix in re-implementations of Au et al. 2008 (https://doi.org/10.1145/1399504.1360643): where a row is
unreliable, its equation becomes x_i = right-hand side. The result is not symmetric, and such a row does not vanish on
constants.
"""

from __future__ import annotations

__all__ = ["cotangent_identity"]

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.clamped_cotangent import ANGLE_TOLERANCE
from lbskel.operators.corner_angles import corner_cotangents, degenerate_faces, incident_vertices
from lbskel.operators.masses import voronoi_mass


def cotangent_identity(mesh: Mesh, *, angle_tolerance: float = ANGLE_TOLERANCE) -> Laplacian:
    """Build the cotangent Laplacian with identity rows, listed in ``treated_vertices``, and the Voronoi mass.

    Parameters
    ----------
    mesh : Mesh
    angle_tolerance : float
        In radians: a triangle is degenerate if one of its angles is this close to 0 or pi.
    """
    cotangents = corner_cotangents(mesh)
    rows = incident_vertices(mesh, ~(np.abs(cotangents) <= 1 / np.tan(angle_tolerance)))
    kept = np.ones(len(mesh.vertices))
    kept[rows] = 0
    weights = np.where(degenerate_faces(mesh)[:, None], 0.0, cotangents / 2)
    stiffness = stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, weights)
    replaced = (diagonal_matrix(kept) @ stiffness + diagonal_matrix(1 - kept)).tocsc()
    return Laplacian(replaced, voronoi_mass(mesh), treated_vertices=rows)
