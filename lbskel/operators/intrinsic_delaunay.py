"""The cotangent Laplacian of the intrinsic Delaunay triangulation: same surface, better triangles, weights >= 0.

Bobenko, Springborn 2007, "A discrete Laplace-Beltrami operator for simplicial surfaces",
https://doi.org/10.1007/s00454-007-9006-1. Where a triangle has no area all edges are first made longer by the amount
that mends the worst: Sharp, Crane 2020, https://doi.org/10.1111/cgf.14069, section 4.
"""

from __future__ import annotations

__all__ = ["intrinsic_delaunay", "mollification_offset"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import touched_vertices, without_degenerate
from lbskel.operators.intrinsic_triangulation import (
    IntrinsicTriangulation,
    cotangents_of_lengths,
    delaunay,
    half_edge_twins,
)
from lbskel.operators.masses import voronoi_mass

MOLLIFY_FACTOR = 1e-6


def mollification_offset(lengths: NDArray[np.float64], factor: float) -> NDArray[np.float64]:
    """(m,) what each edge must gain for the triangle inequalities to hold by this fraction of the mean length."""
    a, b, c = lengths.T
    return np.maximum(2 * np.maximum(np.maximum(a, b), c) - (a + b + c) + factor * lengths.mean(), 0.0)


def intrinsic_delaunay(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """The intrinsic Delaunay Laplacian with the Voronoi mass of the given triangles.

    Parameters
    ----------
    mesh : Mesh
        Orientable, at most two faces at every edge; edges of a boundary stay as they are.
    mollify_factor : float
        Every triangle inequality is made to hold by at least this fraction of the mean edge length.

    Raises
    ------
    MeshError
        On a mesh with a non-manifold edge, or that cannot be oriented.
    """
    faces = mesh.faces
    twins = half_edge_twins(faces)
    if twins is None:
        faces = igl.bfs_orient(faces)[0]
        twins = half_edge_twins(faces)
    if twins is None:
        raise MeshError(
            "intrinsic_delaunay needs an orientable mesh with no more than two faces at an edge; "
            "use the operator 'robust', which takes any mesh"
        )
    n, lengths = len(mesh.vertices), igl.edge_lengths(unit_scale(mesh.vertices)[0], faces)
    if not lengths.any():
        return Laplacian(csc_array((n, n)), voronoi_mass(mesh), treated_vertices=np.unique(faces))
    missing = mollification_offset(lengths, mollify_factor)
    flipped = delaunay(IntrinsicTriangulation(faces, lengths + missing.max(), twins))
    # mended triangles of no area may lose it again to the rounding of flips
    cotangents, degenerate = without_degenerate(cotangents_of_lengths(flipped.lengths))
    stiffness = stiffness_of_corner_weights(n, flipped.faces, cotangents / 2)
    treated = np.union1d(touched_vertices(mesh, missing[:, None] > 0), flipped.faces[degenerate.any(axis=1)])
    return Laplacian(stiffness, voronoi_mass(mesh), treated_vertices=treated)
