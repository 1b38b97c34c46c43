"""Rigid motions: about a center, and which matrices are none."""

import numpy as np
import pytest

from lbskel import MeshError, rigid_motion
from lbskel.applications.rigid_motions import checked_motion

QUARTER = rigid_motion(angle_deg=90, translation=[0, 0, 1.0])


def test_a_motion_turns_about_its_center():
    motion = rigid_motion(axis=[0, 0, 9], angle_deg=90, center=[1, 1, 0], translation=[0, 0, 2])
    assert motion @ [2, 1, 0, 1] == pytest.approx([1, 2, 2, 1], abs=1e-15)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axis": [0, 0, 0]}, "needs an axis that is not zero"),
        ({"angle_deg": "a"}, "a finite angle"),
        ({"translation": [np.inf, 0, 0]}, "translation must be finite"),
        ({"axis": [1, 0]}, "the axis must have three coordinates"),
        ({"center": [1, 2]}, "the center must have three coordinates"),
        ({"axis": "z"}, "axis must be an array of numbers"),
    ],
)
def test_wrong_vectors_are_named(options, message):
    with pytest.raises(MeshError, match=message):
        rigid_motion(**options)


def test_rigid_matrices_are_accepted_in_single_precision_too():
    assert (checked_motion(QUARTER, 0) == QUARTER).all()
    turned = rigid_motion(axis=[1, 2, 3], angle_deg=77, translation=[4, 5, 6]).astype(np.float32)
    assert (checked_motion(turned.tolist(), 0) == turned).all()


def test_rigid_matrices_are_accepted_with_the_digits_that_files_have():
    for angle in np.linspace(1, 359, 200):
        turned = rigid_motion(axis=[1, 2, 3], angle_deg=angle, translation=[4, 5, 6])
        for digits in (5, 6):
            assert (checked_motion(turned.round(digits), 0) == turned.round(digits)).all()


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (QUARTER.T, "motion of handle 3 must have the last row 0, 0, 0, 1, .* this one is transposed"),
        (np.diag([1, 1, 1, 2]), "the last row 0, 0, 0, 1, and its translation in the last column"),
        (np.zeros((4, 4)), "not the last row 0.0, 0.0, 0.0, 0.0"),
        (np.diag([2, 2, 2, 1]), "motion of handle 3 must be rigid"),
        (np.diag([1, 1, -1, 1]), "scales, shears or mirrors"),
        (np.eye(4) + 0.1 * np.eye(4, k=1), "must be rigid"),
        (np.diag([1.001, 1, 1, 1]), "must be rigid"),
        (np.full((4, 4), np.nan), "motion of handle 3 must be finite"),
        (np.eye(3), "of shape"),
        ("a", "must be an array of numbers"),
    ],
)
def test_other_matrices_are_refused(motion, message):
    with pytest.raises(MeshError, match=message):
        checked_motion(motion, 3)
