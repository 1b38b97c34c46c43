"""The cotangent Laplacian with every angle clamped away from 0 and 180 degrees.

A common fix in re-implementations of Au et al. 2008 (https://doi.org/10.1145/1399504.1360643). It keeps the rows finite
but loses linear precision: a clamped row no longer vanishes on a plane, so thin triangles push their vertices sideways.
"""

from __future__ import annotations

__all__ = ["ANGLE_TOLERANCE", "clamped_cotangent"]

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import corner_cotangents, incident_vertices
from lbskel.operators.masses import voronoi_mass

ANGLE_TOLERANCE = np.radians(1.0)  # smallest angle kept, and smallest supplement, in radians; a guess


def clamped_cotangent(mesh: Mesh, *, angle_tolerance: float = ANGLE_TOLERANCE) -> Laplacian:
    """Build the cotangent Laplacian of angles clamped to [tolerance, pi - tolerance], with the Voronoi mass.

    An angle at an edge of length zero is not defined; it counts as 90 degrees, which has weight zero.

    Parameters
    ----------
    mesh : Mesh
    angle_tolerance : float
        In radians.
    """
    cotangents = corner_cotangents(mesh)
    limit = 1 / np.tan(angle_tolerance)
    is_clamped = ~(np.abs(cotangents) <= limit)
    clamped = np.clip(np.nan_to_num(cotangents, nan=0.0, posinf=limit, neginf=-limit), -limit, limit)
    return Laplacian(
        stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, clamped / 2),
        voronoi_mass(mesh),
        treated_vertices=incident_vertices(mesh, is_clamped),
        n_clamped_angles=int(is_clamped.sum()),
    )
