"""Mass matrices: the area that belongs to each vertex.

``voronoi``: in an acute triangle the corner's part of the Voronoi cell, (|pq|^2 cot r + |pr|^2 cot q) / 8 at p; in an
obtuse one half of the area for the obtuse corner and a quarter for each of the others. Meyer, Desbrun, Schroeder, Barr
2003, "Discrete differential-geometry operators for triangulated 2-manifolds",
https://doi.org/10.1007/978-3-662-05105-4_2. ``barycentric``: a third of each triangle's area for each corner. ``full``:
the mass of linear finite elements, a sixth of the area on the diagonal and a twelfth off it, Dziuk 1988,
https://doi.org/10.1007/BFb0082865.
"""

from __future__ import annotations

__all__ = ["MASSES", "barycentric_mass", "full_mass", "moment_mass", "voronoi_corner_areas", "voronoi_mass"]

from collections.abc import Callable

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel._kernels.triangles import corner_products, mixed_voronoi_areas
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.operators.assembly import diagonal_matrix, symmetric_matrix
from lbskel.operators.corner_angles import MAX_COTANGENT


def _lumped(mesh: Mesh, corner_areas: NDArray[np.float64]) -> csc_array:
    """Build the diagonal matrix of the sums of (m, 3) corner areas at each vertex."""
    areas = np.bincount(mesh.faces.ravel(), weights=corner_areas.ravel(), minlength=len(mesh.vertices))
    return diagonal_matrix(areas)


def voronoi_corner_areas(mesh: Mesh) -> NDArray[np.float64]:
    """Compute the (m, 3) mixed Voronoi area of each corner of each face; the rows sum to the faces' areas."""
    V, k = unit_vertices(mesh)
    areas: NDArray[np.float64] = np.ldexp(mixed_voronoi_areas(*corner_products(V, mesh.faces), MAX_COTANGENT), 2 * k)
    return areas


def voronoi_mass(mesh: Mesh) -> csc_array:
    """Build the diagonal matrix of mixed Voronoi areas; it sums to the area of the mesh."""
    return _lumped(mesh, voronoi_corner_areas(mesh))


def barycentric_mass(mesh: Mesh) -> csc_array:
    """Build the diagonal matrix of a third of the areas of the triangles at each vertex."""
    V, k = unit_vertices(mesh)
    return _lumped(mesh, np.ldexp(np.repeat(igl.doublearea(V, mesh.faces)[:, None] / 6, 3, axis=1), 2 * k))


def full_mass(mesh: Mesh) -> csc_array:
    """Build the mass matrix of linear finite elements, not diagonal; its rows sum to the barycentric areas."""
    diagonal = barycentric_mass(mesh).diagonal()
    V, k = unit_vertices(mesh)
    twelfths = np.ldexp(igl.doublearea(V, mesh.faces) / 24, 2 * k)
    return symmetric_matrix(mesh.faces, np.repeat(twelfths[:, None], 3, axis=1), diagonal / 2)


def moment_mass(mesh: Mesh, stiffness: csc_array) -> csc_array:
    """Build the diagonal mass of sums of w_ij |e_ij|^2 / 4, with which M^-1 S of |x - x_i|^2 is -4 at x_i.

    So M^-1 S is exact for |x|^2 on a plane where its row is linearly precise too. For cotangent weights this is the
    Voronoi area, without the rule for obtuse triangles. It gives weights of any unit the scale of a Laplacian.

    Parameters
    ----------
    mesh : Mesh
    stiffness : (n, n) csc_array
    """
    W = stiffness.tocoo()
    V = mesh.vertices
    squared_lengths = ((V[W.row] - V[W.col]) ** 2).sum(axis=1)
    return diagonal_matrix(np.bincount(W.row, weights=-W.data * squared_lengths / 4, minlength=len(V)))


MASSES: dict[str, Callable[[Mesh], csc_array]] = {
    "voronoi": voronoi_mass,
    "barycentric": barycentric_mass,
    "full": full_mass,
}
