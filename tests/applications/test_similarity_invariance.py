"""Transformed deltas: against fits by least squares, ring by ring, and the surfaces that leave no residual."""

import numpy as np
import pytest

from lbskel import laplacian
from lbskel.applications.similarity_invariance import invariant_matrix


def test_each_row_is_the_delta_minus_the_one_transformed_by_the_fit_of_the_paper(ring):
    S = laplacian(ring, operator="graph").stiffness
    V, X = ring.vertices, np.random.default_rng(0).standard_normal((128, 3))
    residual = (invariant_matrix(S, V) @ X.ravel()).reshape(-1, 3)
    deltas = S @ V
    for i in range(0, 128, 7):
        members = np.unique(S[:, [i]].nonzero()[0])
        A = []
        for x, y, z in V[members]:  # unknowns s, h1, h2, h3, t1, t2, t3
            A += [[x, 0, z, -y, 1, 0, 0], [y, -z, 0, x, 0, 1, 0], [z, y, -x, 0, 0, 0, 1]]
        s, h = np.split(np.linalg.lstsq(np.array(A), X[members].ravel())[0][:4], [1])
        expected = (S @ X)[i] - (s * deltas[i] + np.cross(h, deltas[i]))
        assert residual[i] == pytest.approx(expected, abs=1e-10)


def test_scaling_translation_and_small_rotations_leave_nothing(ring):
    S = laplacian(ring).stiffness
    K, V = invariant_matrix(S, ring.vertices), ring.vertices
    for scale, h in ((1.0, 0.0), (2.5, 0.0), (1.0, 0.4)):
        X = scale * V + h * np.cross([1.0, 2, 3], V) + [5, 6, 7]
        assert np.abs(K @ X.ravel()).max() < 1e-12 * np.abs(X).max() * abs(S).max() * 100
