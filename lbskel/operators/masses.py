"""Lumped mass matrices: the area that belongs to each vertex.

Voronoi areas with the rule for obtuse triangles of Meyer, Desbrun, Schroeder, Barr 2003, "Discrete
differential-geometry operators for triangulated 2-manifolds", https://doi.org/10.1007/978-3-662-05105-4_2; by libigl.
"""

from __future__ import annotations

__all__ = ["voronoi_mass"]

import igl
from scipy.sparse import csc_array

from lbskel.mesh import Mesh


def voronoi_mass(mesh: Mesh) -> csc_array:
    """The diagonal matrix of mixed Voronoi areas; it sums to the area of the mesh."""
    return csc_array(igl.massmatrix(mesh.vertices, mesh.faces, igl.MASSMATRIX_TYPE_VORONOI))
