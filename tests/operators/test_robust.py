"""The tufted Laplacian: positive weights, any triangle soup, mollification."""

import numpy as np
import pytest
from operator_shapes import PYTHAGORAS, stiffness_of_lengths

from lbskel import Mesh
from lbskel.operators import (
    laplacian,
)
from lbskel.operators.robust import robust
from lbskel.shapes import schwarz_lantern, sphere


def test_positive_weights_where_cotangents_are_negative():
    lantern = schwarz_lantern(12, 40)
    plain, robust = (laplacian(lantern, operator=name).stiffness.toarray() for name in ("cotangent", "robust"))
    assert (plain - np.diag(plain.diagonal())).max() > 1
    assert (robust - np.diag(robust.diagonal())).max() < 1e-14 * np.abs(robust).max()


def test_the_edges_of_a_component_are_lengthened_by_what_its_thinnest_triangle_needs():
    L = robust(PYTHAGORAS, mollify_factor=0.6)
    # 3, 4, 5 has a slack of 2 and needs 0.6 * 4; acute triangles are Delaunay: the cover of one has its cotangents
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(stiffness_of_lengths(5.4, 3.4, 4.4), rel=1e-12, abs=1e-12)
    assert L.treated_vertices.tolist() == [0, 1, 2, 3, 4, 5]


def test_vertices_without_a_face_and_faces_that_repeat_a_vertex_have_no_weight():
    V = [[0, 0, 0], [4, 0, 0], [0, 3, 0], [9, 9, 9]]
    L = robust(Mesh(V, [[0, 1, 2], [1, 1, 2]]))
    # the largest angle is a right one: mollification by 1e-5 of the mean length changes digits from the sixth on
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(stiffness_of_lengths(5, 3, 4), abs=1e-4)
    assert (L.stiffness.toarray()[3] == 0).all()


def test_the_mass_is_in_the_units_of_the_caller():
    V = 40 * np.array([[0, 0, 0], [4, 0, 0], [0, 3, 0]])
    assert robust(Mesh(V, [[0, 1, 2]])).mass.sum() == pytest.approx(6 * 40**2, rel=1e-4)


@pytest.mark.parametrize("times", [2, 3])
def test_faces_on_the_same_vertices_count_once(times):
    ball = sphere(2)
    ball = ball.with_vertices(ball.vertices * [1, 1, 3])
    copies = np.concatenate([ball.faces, *[ball.faces[:, [1, 0, 2]]] * (times - 1)])
    once, several = robust(ball), robust(Mesh(ball.vertices, copies))
    assert abs(once.stiffness - several.stiffness).max() < 1e-12 * abs(once.stiffness).max()
    assert abs(once.mass - several.mass).max() < 1e-12 * abs(once.mass).max()


def test_of_cocircular_vertices_the_order_of_faces_changes_the_mass_alone():
    flat = sphere(2).with_vertices(sphere(2).vertices * [1.0, 0.02, 0.3])
    order = np.random.default_rng(0).permutation(len(flat.faces))
    one, other = (laplacian(Mesh(flat.vertices, F), operator="robust") for F in (flat.faces, flat.faces[order]))
    assert abs(one.stiffness - other.stiffness).max() < 1e-12 * abs(one.stiffness).max()
    assert one.mass.sum() == pytest.approx(other.mass.sum(), rel=1e-12)
    assert abs(one.mass - other.mass).max() > 0.01 * one.mass.max()
