"""The cotangent Laplacian with every angle kept away from 0 and 180 degrees.

The remedy that re-implementations of Au et al. 2008 (https://doi.org/10.1145/1399504.1360643) reach for first. It keeps
the rows finite but gives up linear precision: a clamped row no longer vanishes on a plane, so that thin triangles push
their vertices sideways.
"""

from __future__ import annotations

__all__ = ["ANGLE_TOLERANCE", "clamped_cotangent", "corner_cotangents"]

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import corner_cotangents, touched_vertices
from lbskel.operators.masses import voronoi_mass

ANGLE_TOLERANCE = np.radians(1.0)


def clamped_cotangent(mesh: Mesh, *, angle_tolerance: float = ANGLE_TOLERANCE) -> Laplacian:
    """The cotangent Laplacian with angles clamped to [tolerance, pi - tolerance] and the Voronoi mass.

    An angle between edges of length zero is not defined and counts as 90 degrees, weight zero.

    Parameters
    ----------
    mesh : Mesh
    angle_tolerance : float
        In radians.
    """
    cotangents = corner_cotangents(mesh)
    limit = 1 / np.tan(angle_tolerance)
    moved = ~(np.abs(cotangents) <= limit)
    clamped = np.clip(np.nan_to_num(cotangents, nan=0.0, posinf=limit, neginf=-limit), -limit, limit)
    return Laplacian(
        stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, clamped / 2),
        voronoi_mass(mesh),
        treated_vertices=touched_vertices(mesh, moved),
        n_clamped_angles=int(moved.sum()),
    )
