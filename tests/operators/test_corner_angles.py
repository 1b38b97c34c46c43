"""Cotangents of corner angles, against libigl and known angles; the test for degenerate ones."""

import igl
import numpy as np
import pytest
from operator_shapes import with_a_flat_face

from lbskel import Mesh
from lbskel.operators.corner_angles import (
    MAX_COTANGENT,
    corner_cotangents,
    degenerate_faces,
    edge_vectors,
    incident_vertices,
    zero_degenerate,
)


def test_corner_cotangents(mesh):
    ours, theirs = corner_cotangents(mesh), 2 * igl.cotmatrix_entries(mesh.vertices, mesh.faces)
    # libigl takes the area from the lengths, whose rounding grows with the square of the cotangent
    assert (np.abs(ours - theirs) <= 1e-14 * (1 + ours.max(axis=1, keepdims=True) ** 2)).all()


def test_corner_cotangents_where_the_angle_is_known():
    for degrees in (1e-3, 0.1, 30, 60, 90, 120, 179, 179.999):
        angle = np.radians(degrees)
        # a long and a short edge at the corner, off the axes so that coordinates are rounded
        turned = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        V = np.array([[0, 0, 0], [1, 0, 0], [0.3 * np.cos(angle), 0.3 * np.sin(angle), 0]]) @ turned
        found = corner_cotangents(Mesh(V, [[0, 1, 2]]))[0, 0]
        # the angle between points rounded at 1e-16 is known to 1e-15 or so
        assert abs(np.arctan2(1, found) - angle) < 1e-15 * (1 + abs(angle)) * 4


def test_faces_with_values_beyond_the_largest_cotangent_become_zero():
    values = np.array([[1.0, -MAX_COTANGENT, 0], [1, 2, 2 * MAX_COTANGENT], [0, np.nan, 1], [-np.inf, 1, 1]])
    kept, degenerate = zero_degenerate(values)
    assert kept.tolist() == [[1, -MAX_COTANGENT, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    assert degenerate.tolist() == [[False] * 3, [True] * 3, [True] * 3, [True] * 3]


@pytest.mark.parametrize("moved", [0.0, 3.0, 30.0, 1000.0])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 3e7])
def test_a_face_without_area_is_found_wherever_it_is(moved, scale):
    for seed in range(20):
        turned = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        mesh, _ = with_a_flat_face(scale * turned, scale * moved)
        assert np.flatnonzero(degenerate_faces(mesh)).tolist() == [len(mesh.faces) - 1]


def test_a_thin_face_whose_height_is_more_than_rounding_is_not_degenerate():
    for height, expected in ((1e-14, False), (1e-16, True)):
        mesh = Mesh([[0, 0, 0], [1, 0, 0], [0.5, height, 0]], [[0, 1, 2]])
        assert degenerate_faces(mesh).tolist() == [expected]
        assert degenerate_faces(mesh.with_vertices(1e-3 * mesh.vertices)).tolist() == [expected]
    small = Mesh([[1, 0, 0], [1, 1e-12, 0], [1, 0, 1e-12]], [[0, 1, 2]])
    assert degenerate_faces(small).tolist() == [False]


def test_edge_vectors_are_opposite_their_corners_and_sum_to_zero():
    mesh = Mesh([[0, 0, 0], [4, 0, 0], [0, 3, 0]], [[0, 1, 2]])
    a, b, c = edge_vectors(mesh)
    assert 8 * np.concatenate([a, b, c]) == pytest.approx(np.array([[-4, 3, 0], [0, -3, 0], [4, 0, 0]]))


def test_the_vertices_of_marked_faces(ring):
    is_marked = np.zeros(ring.faces.shape, dtype=bool)
    is_marked[7, 2] = is_marked[11, 0] = True
    assert incident_vertices(ring, is_marked).tolist() == sorted(set(ring.faces[[7, 11]].ravel().tolist()))
