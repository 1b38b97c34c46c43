"""Normals of triangles: direction, length, and degenerate triangles; lengths of vectors."""

import numpy as np
import pytest

from lbskel.geometry.normals import normalized, row_dots, triangle_normals, vector_lengths


def test_the_normal_is_right_handed_and_twice_the_area_long():
    A, B, C = np.array([[[0, 0, 1]], [[2, 0, 1]], [[0, 3, 1]]], dtype=float)
    assert triangle_normals(A, B, C).tolist() == [[0, 0, 6]]
    assert triangle_normals(A, C, B).tolist() == [[0, 0, -6]]


def test_corners_are_broadcast():
    A, B, C = np.zeros((2, 1, 3)), np.eye(3)[None, :1].repeat(2, axis=0), np.eye(3)[None].repeat(2, axis=0)
    normals = triangle_normals(A, B, C)
    assert normals.shape == (2, 3, 3)
    assert normals[1].tolist() == [[0, 0, 0], [0, 0, 1], [0, -1, 0]]


def test_vectors_are_scaled_to_length_1_and_zero_stays_zero():
    vectors = normalized(np.array([[3.0, 0, 4], [0, 0, 0], [0, -1e-150, 0]]))
    assert vectors == pytest.approx(np.array([[0.6, 0, 0.8], [0, 0, 0], [0, -1, 0]]))


@pytest.mark.parametrize("shape", [(0, 3), (1000, 3), (5, 7, 3)])
def test_lengths_are_bit_for_bit_those_of_numpy(shape):
    vectors = np.random.default_rng(0).normal(size=shape)
    assert (vector_lengths(vectors) == np.linalg.norm(vectors, axis=-1)).all()


def test_dot_products_are_bit_for_bit_the_sums_of_rows():
    a, b = np.random.default_rng(1).normal(size=(2, 1000, 3))
    assert (row_dots(a, b) == (a * b).sum(axis=1)).all()
