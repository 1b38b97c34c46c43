"""Mean value weights, w_ij = (tan(a/2) + tan(b/2)) / |e_ij| with the two angles at i next to the edge; all positive.

Floater 2003, "Mean value coordinates", https://doi.org/10.1016/S0167-8396(03)00002-5. Each row is linearly precise on a
plane, but w_ij differs from w_ji; the mean of the two is symmetric and no longer linearly precise.
"""

from __future__ import annotations

__all__ = ["mean_value", "mean_value_symmetric"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel._kernels.triangles import corner_products
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import degenerate_faces, incident_vertices
from lbskel.operators.masses import moment_mass


def _half_tangents(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Compute tan(angle / 2) at the corners, 1 / length of the edges opposite them, and the treated vertices.

    tan(angle / 2) = |a x b| / (|a| |b| + a . b) = (|a| |b| - a . b) / |a x b|, whichever does not cancel. Both (m, 3)
    arrays are zero in degenerate triangles.
    """
    V, k = unit_vertices(mesh)
    dots, squared_lengths, double_areas = corner_products(V, mesh.faces)
    lengths, crosses = np.sqrt(squared_lengths), double_areas[:, None]
    sums = lengths[:, [1, 2, 0]] * lengths[:, [2, 0, 1]] + np.abs(dots)
    is_degenerate = degenerate_faces(mesh)[:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        tangents = np.where(is_degenerate, 0.0, np.where(dots < 0, sums / crosses, crosses / sums))
        inverse_lengths = np.where(is_degenerate, 0.0, 1 / lengths)
    return tangents, np.ldexp(inverse_lengths, -k), incident_vertices(mesh, is_degenerate)


def mean_value(mesh: Mesh) -> Laplacian:
    """Build D - W, which is not symmetric, with the moment mass."""
    tangents, inverse_lengths, treated = _half_tangents(mesh)
    n, F = len(mesh.vertices), mesh.faces
    corner, next_corner, previous_corner = F.ravel(), F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()
    to_next = (tangents * inverse_lengths[:, [2, 0, 1]]).ravel()
    to_previous = (tangents * inverse_lengths[:, [1, 2, 0]]).ravel()
    entries = np.concatenate([to_next, to_previous])
    rows, columns = np.concatenate([corner, corner]), np.concatenate([next_corner, previous_corner])
    W = coo_array((entries, (rows, columns)), shape=(n, n)).tocsc()
    stiffness: csc_array = (diagonal_matrix(W.sum(axis=1)) - W).tocsc()
    return Laplacian(stiffness, moment_mass(mesh, stiffness), treated_vertices=treated, mass_unit="length")


def mean_value_symmetric(mesh: Mesh) -> Laplacian:
    """Build the Laplacian with weights (w_ij + w_ji) / 2 and the moment mass."""
    tangents, inverse_lengths, treated = _half_tangents(mesh)
    weights = (tangents[:, [1, 2, 0]] + tangents[:, [2, 0, 1]]) * inverse_lengths / 2
    stiffness = stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, weights)
    return Laplacian(stiffness, moment_mass(mesh, stiffness), treated_vertices=treated, mass_unit="length")
