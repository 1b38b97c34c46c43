"""The cotangent Laplacian with every angle kept away from 0 and 180 degrees.

The remedy that re-implementations of Au et al. 2008 (https://doi.org/10.1145/1399504.1360643) reach for first. It keeps
the rows finite but gives up linear precision: a clamped row no longer vanishes on a plane, so that thin triangles push
their vertices sideways.
"""

from __future__ import annotations

__all__ = ["clamped_cotangent", "corner_cotangents"]

import numpy as np
from numpy.typing import NDArray

from lbskel.mesh import Mesh
from lbskel.operators.graph import stiffness_of_edge_weights
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass

ANGLE_TOLERANCE = np.radians(1.0)


def corner_cotangents(mesh: Mesh) -> NDArray[np.float64]:
    """(m, 3) cotangent of the angle at each corner of each face; infinite at 0 and 180 degrees, NaN at no angle."""
    P = mesh.vertices[mesh.faces]
    to_next = P[:, [1, 2, 0]] - P
    to_previous = P[:, [2, 0, 1]] - P
    with np.errstate(divide="ignore", invalid="ignore"):
        return (to_next * to_previous).sum(axis=2) / np.linalg.norm(np.cross(to_next, to_previous), axis=2)


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
    weights = np.bincount(mesh.edge_of_half_edge, weights=0.5 * clamped.T.ravel(), minlength=len(mesh.edges))
    return Laplacian(
        stiffness_of_edge_weights(mesh, weights),
        voronoi_mass(mesh),
        treated_vertices=np.unique(mesh.faces[moved.any(axis=1)]),
        n_clamped_angles=int(moved.sum()),
    )
