"""The cotangent Laplacian, w_ij = (cot a_ij + cot b_ij) / 2 with the angles opposite the edge; entries by libigl.

Pinkall, Polthier 1993, "Computing discrete minimal surfaces and their conjugates",
https://doi.org/10.1080/10586458.1993.10504266. The stiffness is libigl's ``cotmatrix`` with the sign changed.
"""

from __future__ import annotations

__all__ = ["cotangent"]

import igl

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import incident_vertices, zero_degenerate
from lbskel.operators.masses import voronoi_mass


def cotangent(mesh: Mesh) -> Laplacian:
    """Build the cotangent Laplacian with the Voronoi mass; a corner beyond ``MAX_COTANGENT`` has weight zero."""
    half_cotangents = igl.cotmatrix_entries(unit_scale(mesh.vertices)[0], mesh.faces)
    cotangents, degenerate = zero_degenerate(2 * half_cotangents)
    return Laplacian(
        stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, cotangents / 2),
        voronoi_mass(mesh),
        treated_vertices=incident_vertices(mesh, degenerate),
    )
