"""Cotangent rows, and identity rows at degenerate triangles."""

import numpy as np
import pytest
from operator_shapes import PYTHAGORAS, stiffness_of_lengths

from lbskel import Mesh, laplacian
from lbskel.operators.cotangent_identity import cotangent_identity
from lbskel.shapes import sphere


def test_rows_are_those_of_the_cotangents_where_no_triangle_is_degenerate():
    L = cotangent_identity(PYTHAGORAS)
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(stiffness_of_lengths(5, 3, 4), abs=1e-14)
    # the weight of a leg is half the cotangent of the angle opposite: (3/4) / 2 of leg 4, (4/3) / 2 of leg 3
    expected = [[3 / 8 + 2 / 3, -3 / 8, -2 / 3], [-3 / 8, 3 / 8, 0], [-2 / 3, 0, 2 / 3]]
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(np.array(expected), abs=1e-14)
    assert (L.stiffness.toarray()[3:] == np.eye(6)[3:]).all()
    assert L.treated_vertices.tolist() == [3, 4, 5]


def test_without_degenerate_triangles_it_is_the_cotangent_laplacian():
    ball = sphere(2)
    L, expected = cotangent_identity(ball), laplacian(ball)
    assert abs(L.stiffness - expected.stiffness).max() < 1e-13
    assert abs(L.mass - expected.mass).max() == 0


def test_the_tolerance_is_an_angle_at_both_ends():
    degree = np.radians(1)
    for angle, n_rows in ((0.9, 3), (1.1, 0), (178.9, 0), (179.1, 3)):
        V = [[0, 0, 0], [1, 0, 0], [np.cos(angle * degree), np.sin(angle * degree), 0]]
        # the other two angles of these isosceles triangles are 89.5 or 0.45 degrees
        tolerance = degree if angle < 90 else 0.4 * degree if n_rows == 0 else degree
        found = cotangent_identity(Mesh(V, [[0, 1, 2]]), angle_tolerance=tolerance)
        assert len(found.treated_vertices) == n_rows


def test_a_vertex_of_a_good_and_of_a_degenerate_triangle_has_an_identity_row():
    mesh = Mesh([[0, 0, 0], [4, 0, 0], [0, 3, 0], [2, 0, 0]], [[0, 1, 2], [0, 3, 1]])
    S = cotangent_identity(mesh).stiffness.toarray()
    assert (S[[0, 1, 3]] == np.eye(4)[[0, 1, 3]]).all()
    assert S[2] == pytest.approx([-2 / 3, 0, 2 / 3, 0], abs=1e-14)
