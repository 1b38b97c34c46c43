"""Clamped cotangents: those of the clamped angles, and what clamping costs."""

import igl
import numpy as np
import pytest

from lbskel import Mesh
from lbskel.operators import OPERATORS, laplacian
from lbskel.operators.clamped_cotangent import clamped_cotangent


def test_clamped_cotangents_are_those_of_the_angles_clamped(meshes_by_kind):
    mesh, tolerance = meshes_by_kind["soup"], np.radians(25)
    angles = np.clip(igl.internal_angles(mesh.vertices, mesh.faces), tolerance, np.pi - tolerance)
    expected = np.zeros((60, 60))
    for face, corners in zip(mesh.faces, 1 / np.tan(angles), strict=True):
        for k in range(3):
            i, j = face[(k + 1) % 3], face[(k + 2) % 3]
            expected[[i, j], [j, i]] -= corners[k] / 2
            expected[[i, j], [i, j]] += corners[k] / 2
    ours = OPERATORS["clamped_cotangent"](mesh, angle_tolerance=tolerance)
    assert np.abs(ours.stiffness.toarray() - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_clamped_angle_costs_linear_precision():
    V = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-3, 0], [0.5, -1, 0], [0.5, 1, 0]])
    mesh = Mesh(V, [[0, 3, 2], [3, 1, 2], [1, 4, 2], [4, 0, 2]])
    inner = laplacian(mesh, operator="cotangent").stiffness[[2]] @ V
    assert np.abs(inner).max() < 1e-12
    clamped = OPERATORS["clamped_cotangent"](mesh, angle_tolerance=np.radians(50)).stiffness[[2]] @ V
    assert np.abs(clamped).max() > 1e-3


def test_a_clamped_angle_of_one_triangle():
    """Angles of 10, 10 and 160 degrees clamped to 20 and 160: cot 20 is opposite both short edges."""
    t = np.tan(np.radians(10))
    L = clamped_cotangent(Mesh([[0, 0, 0], [2, 0, 0], [1, t, 0]], [[0, 1, 2]]), angle_tolerance=np.radians(19))
    cot = 1 / np.tan(np.radians(19))
    assert L.n_clamped_angles == 2
    assert L.stiffness.toarray()[[0, 1], [2, 2]] == pytest.approx(-cot / 2)
    assert L.stiffness.toarray()[0, 1] == pytest.approx(1 / np.tan(np.radians(20)) / 2)
