"""Flips of intrinsic triangulations: Delaunay at the end, on the same surface."""

import igl
import numpy as np
import pytest

from lbskel.geometry.intrinsic_triangulation import (
    IntrinsicTriangulation,
    cotangents_of_lengths,
    delaunay,
    half_edge_twins,
    interior_twins,
)
from lbskel.shapes import sphere


def test_flips_leave_no_edge_that_is_not_delaunay_and_keep_the_area():
    V = np.random.default_rng(7).normal(size=(200, 3))
    F = np.ascontiguousarray(sphere(2).faces[:, ::-1])
    V = np.concatenate([V, V])[: F.max() + 1] * [1, 1e-3, 1]  # thin and folded, far from Delaunay
    lengths = igl.edge_lengths(V, F)
    found = delaunay(IntrinsicTriangulation(F, lengths, half_edge_twins(F)))
    cotangents = cotangents_of_lengths(found.lengths).ravel()
    sums = cotangents + cotangents[found.twins]
    # the flips stop where the sum is negative by no more than 1e-9 of the cotangents
    assert (sums >= -1e-9 * (1 + 2 * np.abs(cotangents) + np.abs(sums))).all()
    assert (
        cotangents_of_lengths(lengths).ravel() + cotangents_of_lengths(lengths).ravel()[half_edge_twins(F)]
    ).min() < -1
    assert (found.lengths.ravel() == found.lengths.ravel()[found.twins]).all()
    assert (found.twins[found.twins] == np.arange(len(found.twins))).all()
    area = np.linalg.norm(np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), axis=1).sum() / 2
    # areas by Heron's formula of triangles as thin as 1e-3 keep about ten digits
    assert abs(igl.doublearea(found.lengths, 0.0).sum() / 2 / area - 1) < 1e-9


def test_the_flipped_edge_is_the_other_diagonal():
    # two triangles with sides 2, sqrt(5) and sqrt(5) along the long diagonal 4 of a rhombus; the other one is 2
    side = np.sqrt(5)
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    lengths = np.array([[side, side, 4.0], [side, side, 4.0]])
    flipped = delaunay(IntrinsicTriangulation(faces, lengths, half_edge_twins(faces)))
    assert np.sort(flipped.lengths, axis=1) == pytest.approx(np.array([[2, side, side]] * 2))
    assert {frozenset(face) for face in flipped.faces.tolist()} == {frozenset({0, 2, 3}), frozenset({1, 2, 3})}
    assert (flipped.twins >= 0).sum() == 2


def test_twins_need_two_faces_of_one_orientation():
    assert half_edge_twins(np.array([[0, 1, 2], [1, 0, 3]])).tolist() == [-1, -1, 5, -1, -1, 2]
    assert half_edge_twins(np.array([[0, 1, 2], [0, 1, 3]])) is None  # the same direction on both sides
    assert half_edge_twins(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])) is None  # three faces at an edge
    assert half_edge_twins(np.array([[0, 0, 1]])) is None


def test_interior_twins_are_at_edges_of_two_faces_of_one_orientation():
    faces = sphere(2).faces
    assert np.array_equal(interior_twins(faces), half_edge_twins(faces))
    assert interior_twins(np.array([[0, 1, 2], [0, 1, 3]])).tolist() == [-1] * 6
    crowded = interior_twins(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [4, 1, 5]]))
    assert crowded[6] == 11
    assert crowded[11] == 6
    assert (crowded >= 0).sum() == 2
    assert len(interior_twins(np.empty((0, 3), dtype=np.int64))) == 0


def test_cotangents_of_lengths():
    assert cotangents_of_lengths(np.array([[5.0, 3.0, 4.0]])) == pytest.approx(np.array([[0, 4 / 3, 3 / 4]]))
