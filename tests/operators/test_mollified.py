"""The cotangent Laplacian of mollified edge lengths."""

import numpy as np
import pytest
from operator_shapes import PYTHAGORAS, stiffness_of_lengths

from lbskel import Mesh, laplacian
from lbskel.operators.mollified import mollified


def test_the_edges_of_a_component_are_lengthened_by_what_its_thinnest_triangle_needs():
    L = mollified(PYTHAGORAS, mollify_factor=0.3)
    # 0.3 of the mean length 4 / 3 is 0.4, which the collinear triangle needs; the other one has a slack of 2
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(stiffness_of_lengths(5, 3, 4), rel=1e-12, abs=1e-12)
    assert L.stiffness.toarray()[3:, 3:] == pytest.approx(stiffness_of_lengths(1.4, 2.4, 1.4), rel=1e-12, abs=1e-12)
    assert (L.stiffness.toarray()[:3, 3:] == 0).all()
    assert L.treated_vertices.tolist() == [3, 4, 5]
    assert L.mass.diagonal() == pytest.approx([3, 1.5, 1.5, 0, 0, 0])  # of the triangles as given


def test_triangles_that_need_no_mollification_keep_their_cotangents(mesh):
    if mollified(mesh).treated_vertices.size:
        pytest.skip("has thin triangles")
    expected = laplacian(mesh).stiffness
    # cotangents of lengths lose twice the digits that those of positions do
    assert abs(mollified(mesh).stiffness - expected).max() < 1e-10 * abs(expected).max()


def test_a_mesh_collapsed_to_a_point_has_the_zero_operator():
    L = mollified(Mesh(np.ones((3, 3)), [[0, 1, 2]]))
    assert L.stiffness.nnz == 0
    assert L.treated_vertices.tolist() == [0, 1, 2]
