"""The cotangent Laplacian, w_ij = (cot a_ij + cot b_ij) / 2 with the angles opposite the edge; by libigl.

Pinkall, Polthier 1993, "Computing discrete minimal surfaces and their conjugates",
https://doi.org/10.1080/10586458.1993.10504266. libigl's ``cotmatrix`` is negative semidefinite and is negated here.
"""

from __future__ import annotations

__all__ = ["cotangent"]

import igl
from scipy.sparse import csc_array

from lbskel.mesh import Mesh
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass


def cotangent(mesh: Mesh) -> Laplacian:
    """The cotangent Laplacian with no guard at all: not finite where a triangle has no area."""
    return Laplacian(-csc_array(igl.cotmatrix(mesh.vertices, mesh.faces)), voronoi_mass(mesh))
