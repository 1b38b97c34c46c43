"""The anisotropic Laplacian: shape operators, and damping along the bend."""

import numpy as np

from lbskel import Mesh
from lbskel.operators import (
    laplacian,
)
from lbskel.operators.anisotropic import anisotropic, shape_operators
from lbskel.shapes import cylinder, torus


def test_shape_operators_of_a_torus():
    R, r = 1.0, 0.4
    K = shape_operators(torus(R, r, 300, 120)) / 2  # the longest coordinate is 1.4: scaled by one half
    mean, spread = (K[0] + K[2]) / 2, np.hypot((K[0] - K[2]) / 2, K[1])
    # 1/r across everywhere, between -1/(R - r) and 1/(R + r) along
    assert np.abs(mean + spread - 1 / r).max() < 0.01
    assert abs((mean - spread).min() + 1 / (R - r)) < 0.01
    assert abs((mean - spread).max() - 1 / (R + r)) < 0.01


def test_anisotropic_diffusion_is_damped_along_the_bend_and_nowhere_else():
    side = cylinder(1.0, 2.0, 64, 41)
    strength = 3.0
    radius = np.sqrt(side.area / (4 * np.pi))  # curvature is in units of the sphere of this area
    plain = laplacian(side).stiffness
    damped = anisotropic(side, strength=strength).stiffness
    x, _, z = side.vertices.T
    along, around = z @ damped @ z / (z @ plain @ z), x @ damped @ x / (x @ plain @ x)
    assert abs(along - 1) < 0.01  # normals at the open rims lean by the half of an edge
    assert abs(around - 1 / (1 + strength * radius)) < 0.01
    assert abs(anisotropic(side, strength=0.0).stiffness - plain).max() < 1e-13


def test_concave_surfaces_are_damped_as_convex_ones():
    side = cylinder(1.0, 2.0, 24, 11)
    inside_out = Mesh(side.vertices, side.faces[:, ::-1])
    assert np.abs(shape_operators(side)).max() > 0.5
    convex, concave = (anisotropic(mesh, strength=3.0).stiffness for mesh in (side, inside_out))
    assert abs(convex - concave).max() < 1e-12 * abs(convex).max()


def test_faces_need_not_be_oriented_alike():
    ring = torus(1.0, 0.4, 24, 12)
    is_reversed = np.random.default_rng(0).random(len(ring.faces)) < 0.5
    mixed = Mesh(ring.vertices, np.where(is_reversed[:, None], ring.faces[:, ::-1], ring.faces))
    expected, found = anisotropic(ring).stiffness, anisotropic(mixed).stiffness
    assert abs(expected - found).max() < 1e-12 * abs(expected).max()
    assert abs(anisotropic(ring, strength=0.0).stiffness - expected).max() > 0.1


def test_the_matrix_of_a_collinear_face_is_not_indefinite():
    """Decimals that are not exact: the face has an area of one rounding, so that single cotangents are finite."""
    V = [[-2.6, -1.3, 0], [-2.7, -1.5, 0], [-3.1, -2.3, 0], [-2.4, -1.4, 0.5]]
    L = anisotropic(Mesh(V, [[0, 1, 2], [0, 2, 3]]))
    eigenvalues = np.linalg.eigvalsh(L.stiffness.toarray())
    assert eigenvalues[0] > -1e-15 * 10
    assert eigenvalues[-1] < 10
    assert L.treated_vertices.tolist() == [0, 1, 2]
