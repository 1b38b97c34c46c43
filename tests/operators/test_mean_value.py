"""Mean value weights and their mass."""

import igl
import numpy as np
import pytest
from operator_shapes import (
    hexagons,
)

from lbskel.operators import (
    laplacian,
)


@pytest.mark.parametrize("name", ["mean_value", "mean_value_symmetric"])
def test_mean_value_weights_are_those_of_the_angles(mesh, name):
    n, V = len(mesh.vertices), mesh.vertices
    W = np.zeros((n, n))
    for face, angles in zip(mesh.faces, igl.internal_angles(V, mesh.faces), strict=True):
        for k in range(3):
            i = face[k]
            for j in (face[(k + 1) % 3], face[(k + 2) % 3]):
                W[i, j] += np.tan(angles[k] / 2) / np.linalg.norm(V[i] - V[j])
    if name == "mean_value_symmetric":
        W = (W + W.T) / 2
    assert np.abs(laplacian(mesh, operator=name).stiffness - (np.diag(W.sum(axis=1)) - W)).max() < 1e-12 * W.max()


def test_mean_value_weights_and_their_mass_on_regular_rings():
    mesh, inner = hexagons(edge=0.1)
    L = laplacian(mesh, operator="mean_value")
    weight = 2 * np.tan(np.pi / 6) / 0.1
    row = L.stiffness.tocsr()[[int(np.flatnonzero(inner)[0])]].toarray().ravel()
    assert np.allclose(np.sort(row)[:6], -weight, rtol=1e-12)
    assert np.allclose(L.mass.diagonal()[inner], 6 * weight * 0.1**2 / 4, rtol=1e-12)
