"""Nearest rotations: against singular value decompositions, and where they are not unique."""

import numpy as np
import pytest

from lbskel.applications.rotation_fitting import nearest_rotations, rigid_fit


def expected_rotations(M):
    U, _, Vt = np.linalg.svd(M)
    U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
    return U @ Vt


@pytest.mark.parametrize("third", [1.0, 0.1, 0.0])  # 0: the ring is flat
@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_rotations_are_those_of_the_decomposition(third, scale):
    M = np.random.default_rng(0).standard_normal((500, 3, 3)) * [1, 1, third]
    R = nearest_rotations(scale * M)
    # the denominator is above 1e-5: five of sixteen digits may be lost
    assert pytest.approx(expected_rotations(M), abs=1e-10) == R
    assert np.einsum("nab,ncb->nac", R, R) == pytest.approx(np.broadcast_to(np.eye(3), R.shape), abs=1e-10)


def test_a_rotation_is_its_own_nearest_one_and_zero_gives_the_identity():
    R = expected_rotations(np.random.default_rng(1).standard_normal((50, 3, 3)))
    assert nearest_rotations(R) == pytest.approx(R, abs=1e-14)
    assert nearest_rotations(np.zeros((1, 3, 3)))[0] == pytest.approx(np.eye(3), abs=1e-14)


def test_where_several_are_nearest_the_one_next_to_the_identity_is_taken():
    """One direction maps to another: the rotation about their common normal, and no turn about the direction."""
    u, v = np.array([0.0, 0, 2]), np.array([1.0, 0, 0])
    R = nearest_rotations(np.outer(v, u)[None])[0]
    assert pytest.approx(np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), abs=1e-6) == R  # TIE_BREAK


def test_a_rigid_fit_finds_the_motion_that_was_applied():
    rng = np.random.default_rng(2)
    points, t = rng.standard_normal((20, 3)), np.array([1.0, 2, 3])
    R = expected_rotations(rng.standard_normal((1, 3, 3)))[0]
    fitted, shift = rigid_fit(points, points @ R.T + t)
    assert fitted == pytest.approx(R, abs=1e-13)
    assert shift == pytest.approx(t, abs=1e-13)
    one, shift = rigid_fit(points[:1], points[:1] + t)
    assert one == pytest.approx(np.eye(3), abs=1e-14)
    assert shift == pytest.approx(t, abs=1e-14)
