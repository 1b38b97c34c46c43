"""Mass matrices: the area that belongs to each vertex.

``voronoi``: at an acute triangle the corner's part of the Voronoi cell, (|pq|^2 cot r + |pr|^2 cot q) / 8 at p; at an
obtuse one a half of the area to the obtuse corner and a quarter to the others. Meyer, Desbrun, Schroeder, Barr 2003,
"Discrete differential-geometry operators for triangulated 2-manifolds", https://doi.org/10.1007/978-3-662-05105-4_2.
``barycentric``: a third of each triangle's area to each corner. ``full``: that of linear finite elements, a sixth of
the area on the diagonal and a twelfth off it, Dziuk 1988, https://doi.org/10.1007/BFb0082865.
"""

from __future__ import annotations

__all__ = ["MASSES", "barycentric_mass", "full_mass", "moment_mass", "voronoi_corners", "voronoi_mass"]

from collections.abc import Callable

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel._kernels.triangles import corners_of, voronoi_of
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix, symmetric_matrix
from lbskel.operators.corner_angles import LIMIT


def _diagonal(mesh: Mesh, corner_areas: NDArray[np.float64]) -> csc_array:
    """The diagonal matrix of the sums of (m, 3) corner areas at each vertex."""
    areas = np.bincount(mesh.faces.ravel(), weights=corner_areas.ravel(), minlength=len(mesh.vertices))
    return diagonal_matrix(areas)


def voronoi_corners(mesh: Mesh) -> NDArray[np.float64]:
    """(m, 3) mixed Voronoi area of each corner of each face; the rows sum to the faces' areas."""
    V, k = unit_scale(mesh.vertices)
    return np.ldexp(voronoi_of(*corners_of(V, mesh.faces), LIMIT), 2 * k)


def voronoi_mass(mesh: Mesh) -> csc_array:
    """The diagonal matrix of mixed Voronoi areas; it sums to the area of the mesh."""
    return _diagonal(mesh, voronoi_corners(mesh))


def barycentric_mass(mesh: Mesh) -> csc_array:
    """The diagonal matrix of a third of the areas of the triangles at each vertex."""
    V, k = unit_scale(mesh.vertices)
    return _diagonal(mesh, np.ldexp(np.repeat(igl.doublearea(V, mesh.faces)[:, None] / 6, 3, axis=1), 2 * k))


def full_mass(mesh: Mesh) -> csc_array:
    """The mass matrix of linear finite elements, not diagonal; its rows sum to the barycentric areas."""
    diagonal = barycentric_mass(mesh).diagonal()
    V, k = unit_scale(mesh.vertices)
    twelfths = np.ldexp(igl.doublearea(V, mesh.faces) / 24, 2 * k)
    return symmetric_matrix(mesh.faces, np.repeat(twelfths[:, None], 3, axis=1), diagonal / 2)


def moment_mass(mesh: Mesh, stiffness: csc_array) -> csc_array:
    """The diagonal matrix of sums of w_ij |e_ij|^2 / 4: the mass with which M^-1 S is exact for |x|^2 on a plane.

    For cotangent weights that is the Voronoi area; it gives weights of any unit the scale of a Laplacian.
    """
    W = stiffness.tocoo()
    V = mesh.vertices
    squares = ((V[W.row] - V[W.col]) ** 2).sum(axis=1)
    return diagonal_matrix(np.bincount(W.row, weights=-W.data * squares / 4, minlength=len(V)))


MASSES: dict[str, Callable[[Mesh], csc_array]] = {
    "voronoi": voronoi_mass,
    "barycentric": barycentric_mass,
    "full": full_mass,
}
