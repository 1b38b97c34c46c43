"""The cotangent Laplacian of mollified edge lengths: edges are lengthened by what the thinnest triangle needs.

Sharp, Crane 2020, "A Laplacian for nonmanifold triangle meshes", https://doi.org/10.1111/cgf.14069, section 4, without
the intrinsic flips that follow there. The matrix is finite and symmetric, but weights may be negative, as cotangents
may.
"""

from __future__ import annotations

__all__ = ["mollified"]

import igl
import numpy as np
from scipy.sparse import csc_array

from lbskel.geometry.intrinsic_triangulation import cotangents_of_lengths
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import incident_vertices
from lbskel.operators.intrinsic_delaunay import MOLLIFY_FACTOR, mollified_lengths
from lbskel.operators.masses import voronoi_mass


def mollified(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the cotangent Laplacian of mollified edge lengths with the Voronoi mass of the given triangles.

    Parameters
    ----------
    mesh : Mesh
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length of its component.
    """
    n, lengths = len(mesh.vertices), igl.edge_lengths(unit_vertices(mesh)[0], mesh.faces)
    if not lengths.any():
        return Laplacian(csc_array((n, n)), voronoi_mass(mesh), treated_vertices=np.unique(mesh.faces))
    lengths, is_thin = mollified_lengths(mesh.faces, lengths, mollify_factor)
    stiffness = stiffness_of_corner_weights(n, mesh.faces, cotangents_of_lengths(lengths) / 2)
    return Laplacian(stiffness, voronoi_mass(mesh), treated_vertices=incident_vertices(mesh, is_thin[:, None]))
