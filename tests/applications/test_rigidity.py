"""The rigidity energy: its definition as a sum over pairs, and that both steps decrease it."""

import numpy as np
import pytest

from lbskel import laplacian
from lbskel.applications.rigidity import RigidityEnergy


@pytest.fixture
def deformed(ring):
    """The stiffness of the ring, its energy, and positions of it that are no rigid motion."""
    S = laplacian(ring, operator="intrinsic_delaunay").stiffness
    x, y, z = ring.vertices.T
    return S, RigidityEnergy(S, ring.vertices), np.stack([x + 0.3 * y * y, y - 0.2 * z, 1.4 * z + 0.1 * x], axis=1)


def test_the_energy_is_the_sum_over_pairs_with_the_best_rotations(ring, deformed):
    S, energy, X = deformed
    V, total = ring.vertices, 0.0
    W = -S.toarray()
    for i in range(len(V)):
        neighbors = np.flatnonzero(W[i] * (np.arange(len(V)) != i))
        e, x, w = V[i] - V[neighbors], X[i] - X[neighbors], W[i, neighbors]
        U, _, Vt = np.linalg.svd((w[:, None] * x).T @ e)
        R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
        assert energy.rotations(X)[i] == pytest.approx(R, abs=1e-10)
        total += w @ ((x - e @ R.T) ** 2).sum(axis=1)
    assert energy.value(X) == pytest.approx(total, rel=1e-10)


def test_a_rigid_motion_has_no_energy(ring, deformed):
    _, energy, _ = deformed
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    assert energy.value(ring.vertices @ turn.T + 3) < 1e-9  # rounding errors of lengths of 1e2 in total


def test_the_right_hand_side_is_the_gradient(ring, deformed):
    """With the rotations fixed, dE/dX = 4 S X - 2 C^T R; those that are best do not contribute."""
    S, energy, X = deformed
    gradient = 4 * (S @ X - energy.right_hand_side(energy.rotations(X)))
    direction = np.random.default_rng(1).standard_normal(X.shape)
    h = 1e-5
    slope = (energy.value(X + h * direction) - energy.value(X - h * direction)) / (2 * h)
    assert slope == pytest.approx((gradient * direction).sum(), rel=1e-5)


def test_without_rotation_the_right_hand_side_is_the_deltas(ring, deformed):
    S, energy, _ = deformed
    identity = np.broadcast_to(np.eye(3), (len(ring.vertices), 3, 3))
    assert energy.right_hand_side(identity) == pytest.approx(S @ ring.vertices, abs=1e-13)
