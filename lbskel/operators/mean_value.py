"""Mean value weights, w_ij = (tan(a/2) + tan(b/2)) / |e_ij| with the two angles at i beside the edge: all positive.

Floater 2003, "Mean value coordinates", https://doi.org/10.1016/S0167-8396(03)00002-5. Row i is linearly precise on a
plane, but w_ij is not w_ji; their mean is symmetric and no longer linearly precise.
"""

from __future__ import annotations

__all__ = ["mean_value", "mean_value_symmetric"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel._kernels.triangles import corners_of
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import touched_vertices, without_degenerate
from lbskel.operators.masses import moment_mass


def _half_tangents(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """(m, 3) tan(angle / 2) at the corners, (m, 3) 1 / length of the edges opposite them, and the vertices treated.

    tan(angle / 2) = |a x b| / (|a| |b| + a . b) = (|a| |b| - a . b) / |a x b|, whichever adds and does not cancel. Both
    are zero in triangles where one of them has no finite value.
    """
    V, k = unit_scale(mesh.vertices)
    scalar, squares, double_areas = corners_of(V, mesh.faces)
    lengths, crosses = np.sqrt(squares), double_areas[:, None]
    sums = lengths[:, [1, 2, 0]] * lengths[:, [2, 0, 1]] + np.abs(scalar)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        tangents, flat = without_degenerate(np.where(scalar < 0, sums / crosses, crosses / sums))
        inverse, short = without_degenerate(1 / lengths)
    degenerate = (short | flat).any(axis=1, keepdims=True)
    tangents, inverse = np.where(degenerate, 0.0, tangents), np.where(degenerate, 0.0, inverse)
    return tangents, np.ldexp(inverse, -k), touched_vertices(mesh, degenerate)


def mean_value(mesh: Mesh) -> Laplacian:
    """D - W with the mass that gives it the scale of a Laplacian; not symmetric."""
    tangents, inverse, treated = _half_tangents(mesh)
    n, F = len(mesh.vertices), mesh.faces
    here, following, before = F.ravel(), F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()
    to_following = (tangents * inverse[:, [2, 0, 1]]).ravel()
    to_before = (tangents * inverse[:, [1, 2, 0]]).ravel()
    entries = np.concatenate([to_following, to_before])
    rows, columns = np.concatenate([here, here]), np.concatenate([following, before])
    W = coo_array((entries, (rows, columns)), shape=(n, n)).tocsc()
    stiffness: csc_array = (diagonal_matrix(W.sum(axis=1)) - W).tocsc()
    return Laplacian(stiffness, moment_mass(mesh, stiffness), treated_vertices=treated)


def mean_value_symmetric(mesh: Mesh) -> Laplacian:
    """The weights (w_ij + w_ji) / 2, with the mass that gives them the scale of a Laplacian."""
    tangents, inverse, treated = _half_tangents(mesh)
    weights = (tangents[:, [1, 2, 0]] + tangents[:, [2, 0, 1]]) * inverse / 2
    stiffness = stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, weights)
    return Laplacian(stiffness, moment_mass(mesh, stiffness), treated_vertices=treated)
