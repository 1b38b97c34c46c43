"""The cotangent Laplacian of the intrinsic Delaunay triangulation: same surface, better triangles, weights >= 0.

Bobenko, Springborn 2007, "A discrete Laplace-Beltrami operator for simplicial surfaces",
https://doi.org/10.1007/s00454-007-9006-1; flips by libigl after Fisher et al. 2006.
"""

from __future__ import annotations

__all__ = ["intrinsic_delaunay"]

import igl
from scipy.sparse import csc_array

from lbskel.errors import MeshError
from lbskel.mesh import Mesh
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass


def intrinsic_delaunay(mesh: Mesh) -> Laplacian:
    """The intrinsic Delaunay Laplacian with the Voronoi mass of the given triangles.

    Raises
    ------
    MeshError
        On a mesh with a boundary or a non-manifold edge, which libigl's flips do not survive.
    """
    if not (mesh.is_closed and mesh.is_edge_manifold):
        raise MeshError(
            "intrinsic_delaunay needs a closed mesh with two faces at every edge; "
            "use the operator 'robust', which takes any mesh"
        )
    negative = igl.intrinsic_delaunay_cotmatrix(mesh.vertices, mesh.faces)[0]
    return Laplacian(-csc_array(negative), voronoi_mass(mesh))
