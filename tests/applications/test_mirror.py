"""The plane of symmetry: found in any pose, absent where a shape has none."""

import numpy as np
import pytest
from helpers import box_mesh
from scipy.spatial.transform import Rotation

from lbskel import Mesh
from lbskel.applications.mirror import find_mirror_plane
from lbskel.shapes import capsule, torus


def lopsided():
    """A torus stretched differently on both sides of x = 0 and of z = 0: only y = 0 is a plane of symmetry."""
    V = np.array(torus(1.0, 0.25, 24, 12).vertices)
    V[:, 0] = np.where(V[:, 0] > 0, 2 * V[:, 0], V[:, 0])
    V[:, 2] += 0.4 * V[:, 0] ** 2
    return Mesh(V, torus(1.0, 0.25, 24, 12).faces)


def test_the_plane_and_the_twins_of_a_shape_with_one():
    plane = find_mirror_plane(lopsided())
    assert plane.normal == pytest.approx([0, 1, 0])
    V = lopsided().vertices
    assert V[plane.twins] == pytest.approx(V * [1, -1, 1], abs=1e-9)


def test_a_turned_shape_has_a_turned_plane():
    turn = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix()
    mesh = lopsided().with_vertices(lopsided().vertices @ turn.T + 5)
    plane = find_mirror_plane(mesh)
    assert abs(plane.normal @ turn[:, 1]) == pytest.approx(1)
    assert plane.normal.max() == np.abs(plane.normal).max()


def test_no_plane():
    skew = capsule(3.0, 0.5, 12)
    bent = skew.with_vertices(
        skew.vertices + np.stack([0 * skew.vertices[:, 2]] * 2 + [skew.vertices[:, 0] ** 3], axis=1)
    )
    twisted = bent.vertices.copy()
    angle = twisted[:, 2]
    twisted[:, 0] = np.cos(angle) + 2 * twisted[:, 0]
    twisted[:, 1] = np.sin(angle) + twisted[:, 1]
    assert find_mirror_plane(bent.with_vertices(twisted)) is None
    assert find_mirror_plane(Mesh(np.zeros((3, 3)), [[0, 1, 2]])) is None


def test_an_ellipsoidal_box_has_the_plane_of_an_axis():
    assert find_mirror_plane(box_mesh([1, 2, 3])).normal.max() == 1
