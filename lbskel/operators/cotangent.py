"""The cotangent Laplacian, w_ij = (cot a_ij + cot b_ij) / 2 with the angles opposite the edge.

Pinkall, Polthier 1993, "Computing discrete minimal surfaces and their conjugates",
https://doi.org/10.1080/10586458.1993.10504266. The stiffness is libigl's ``cotmatrix`` with the sign changed, but
exact for thin triangles too: libigl's cotangents are of edge lengths, which lose half of the digits there.
"""

from __future__ import annotations

__all__ = ["cotangent"]

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import corner_cotangents, degenerate_faces, incident_vertices
from lbskel.operators.masses import voronoi_mass


def cotangent(mesh: Mesh) -> Laplacian:
    """Build the cotangent Laplacian with the Voronoi mass; the corners of degenerate faces have weight zero."""
    is_degenerate = degenerate_faces(mesh)[:, None]
    weights = np.where(is_degenerate, 0.0, corner_cotangents(mesh) / 2)
    return Laplacian(
        stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, weights),
        voronoi_mass(mesh),
        treated_vertices=incident_vertices(mesh, is_degenerate),
    )
