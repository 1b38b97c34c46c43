"""The cotangent Laplacian of the intrinsic Delaunay triangulation: same surface, better triangles, weights >= 0.

Bobenko, Springborn 2007, "A discrete Laplace-Beltrami operator for simplicial surfaces",
https://doi.org/10.1007/s00454-007-9006-1; flips by libigl after Fisher et al. 2006. The flips do not end on triangles
without area (seen where the shorter sides exceed the longest by less than 1e-10 of a mean edge), so all edges are first
made longer by the amount that mends the worst: Sharp, Crane 2020, https://doi.org/10.1111/cgf.14069, section 4.
"""

from __future__ import annotations

__all__ = ["intrinsic_delaunay"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.errors import MeshError
from lbskel.mesh import Mesh
from lbskel.operators.corners import touched_vertices, unit_scale
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass

MOLLIFY_FACTOR = 1e-6


def has_two_faces_at_every_edge(mesh: Mesh) -> bool:
    """Whether the mesh is closed and edge-manifold; by one sort, without the table of the edges."""
    start, end = mesh.half_edges.T
    keys = np.sort(np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end))
    in_pairs = len(keys) % 2 == 0 and (keys[::2] == keys[1::2]).all() and (keys[1:-1:2] != keys[2::2]).all()
    return bool(in_pairs and (start != end).all())


def shortfall(lengths: NDArray[np.float64], factor: float) -> NDArray[np.float64]:
    """(m,) what each edge must gain for the triangle inequalities to hold by this fraction of the mean length."""
    return np.maximum(2 * lengths.max(axis=1) - lengths.sum(axis=1) + factor * lengths.mean(), 0.0)


def intrinsic_delaunay(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """The intrinsic Delaunay Laplacian with the Voronoi mass of the given triangles.

    Parameters
    ----------
    mesh : Mesh
        Closed, two faces at every edge.
    mollify_factor : float
        Every triangle inequality is made to hold by at least this fraction of the mean edge length.

    Raises
    ------
    MeshError
        On a mesh with a boundary or a non-manifold edge, which libigl's flips do not survive.
    """
    if not has_two_faces_at_every_edge(mesh):
        raise MeshError(
            "intrinsic_delaunay needs a closed mesh with two faces at every edge; "
            "use the operator 'robust', which takes any mesh"
        )
    V, n = unit_scale(mesh.vertices)[0], len(mesh.vertices)
    lengths = igl.edge_lengths(V, mesh.faces)
    missing = shortfall(lengths, mollify_factor)
    if not lengths.any():
        negative = csc_array((n, n))
    elif missing.any():
        flipped, faces = igl.intrinsic_delaunay_triangulation(lengths + missing.max(), mesh.faces)[:2]
        negative = csc_array(igl.cotmatrix_intrinsic(flipped, faces))
    else:
        negative = csc_array(igl.intrinsic_delaunay_cotmatrix(V, mesh.faces)[0])
    negative.resize(n, n)
    treated = touched_vertices(mesh, (missing > 0)[:, None])
    return Laplacian(-negative, voronoi_mass(mesh), treated_vertices=treated)
