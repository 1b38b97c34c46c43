"""The cotangent Laplacian, against libigl and weights worked out by hand."""

import igl
import numpy as np
import pytest
from operator_shapes import PYTHAGORAS, with_a_flat_face

from lbskel import Mesh
from lbskel.operators import (
    laplacian,
)


def test_cotangent_stiffness(mesh):
    ours, theirs = laplacian(mesh).stiffness, -igl.cotmatrix(mesh.vertices, mesh.faces)
    assert abs(ours - theirs).max() < 1e-12 * abs(theirs).max()


def test_weights_of_a_triangle_with_sides_3_4_5():
    L = laplacian(PYTHAGORAS)
    expected = [[3 / 8 + 2 / 3, -3 / 8, -2 / 3], [-3 / 8, 3 / 8, 0], [-2 / 3, 0, 2 / 3]]
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(np.array(expected), abs=1e-14)
    assert (L.stiffness.toarray()[:3, 3:] == 0).all()
    assert L.treated_vertices.tolist() == [3, 4, 5]


def test_the_edge_of_two_triangles_has_the_half_sum_of_both_cotangents():
    """Equilateral triangles on both sides of an edge: cot 60 twice, halved, is 1 / sqrt(3)."""
    h = np.sqrt(3) / 2
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0.5, h, 0], [0.5, -h, 0]], [[0, 1, 2], [1, 0, 3]])
    S = laplacian(mesh).stiffness.toarray()
    assert S[0, 1] == pytest.approx(-1 / np.sqrt(3))
    assert S[0, 2] == pytest.approx(-1 / np.sqrt(3) / 2)


@pytest.mark.parametrize("operator", ["cotangent", "mean_value", "mean_value_symmetric", "anisotropic"])
@pytest.mark.parametrize("moved", [0.0, 30.0])
def test_a_face_without_area_has_no_weight_wherever_it_is(operator, moved):
    turned = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    mesh, grid = with_a_flat_face(turned, moved)
    with_face, without = (laplacian(each, operator=operator) for each in (mesh, grid))
    assert with_face.treated_vertices.tolist() == sorted(mesh.faces[-1].tolist())
    # rounding of the coordinates, 30 roundings; the normal of the flat face has no direction in anisotropic
    assert abs(with_face.stiffness - without.stiffness).max() < 1e-12 * abs(without.stiffness).max()


@pytest.mark.parametrize("height", [1e-6, 1e-8, 1e-9, 1e-12])
def test_linear_functions_are_kept_at_thin_caps(height):
    """Edge lengths would lose half of the digits: the height enters them as its square."""
    V = np.array([[0, 0, 0], [1, 0, 0], [0.5, height, 0], [0.5, 1, 0], [0.5, -1, 0]])
    L = laplacian(Mesh(V, [[0, 1, 2], [1, 3, 2], [3, 0, 2], [0, 4, 1]]))
    assert L.treated_vertices.tolist() == []
    S = L.stiffness.toarray()
    assert S[0, 2] == pytest.approx(-1 / (4 * height), rel=1e-5)  # half the cotangent at 1, and 1/4 of that at 3
    assert (np.abs(S @ V)[2] <= 1e-15 * (np.abs(S) @ np.abs(V))[2]).all()  # the rounding of the terms
