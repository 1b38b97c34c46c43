"""The cotangent Laplacian, against libigl and weights worked out by hand."""

import igl
import numpy as np
import pytest
from operator_shapes import PYTHAGORAS

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
