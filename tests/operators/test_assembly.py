"""Stiffness matrices from weights of corners and of pairs."""

import numpy as np
from scipy.sparse import csc_array

from lbskel.operators.assembly import (
    diagonal_matrix,
    stiffness_of_corner_weights,
    stiffness_of_pairs,
    symmetric_matrix,
)

FACES = np.array([[0, 1, 2], [2, 1, 3]])


def test_a_corner_weight_belongs_to_the_edge_opposite():
    S = stiffness_of_corner_weights(5, FACES, np.array([[1.0, 2.0, 4.0], [8.0, 16.0, 32.0]]))
    expected = np.zeros((5, 5))
    # edge 12 is opposite corner 0 of the first face, and 21 opposite corner 2 of the second
    for i, j, weight in ((1, 2, 1 + 32), (2, 0, 2), (0, 1, 4), (1, 3, 8), (3, 2, 16)):
        expected[[i, j], [j, i]] = -weight
        expected[[i, j], [i, j]] += weight
    assert isinstance(S, csc_array)
    assert (S.toarray() == expected).all()


def test_pairs_in_any_order_and_those_of_a_vertex_with_itself():
    i, j = np.array([0, 3, 2]), np.array([1, 1, 2])
    S = stiffness_of_pairs(4, i, j, np.array([2.0, 5.0, 7.0])).toarray()
    assert (S == [[2, -2, 0, 0], [-2, 7, 0, -5], [0, 0, 0, 0], [0, -5, 0, 5]]).all()


def test_entries_of_edges_are_added_on_both_sides():
    entries = np.array([[1.0, 2.0, 4.0], [8.0, 16.0, 32.0]])
    M = symmetric_matrix(FACES, entries, np.arange(4)).toarray()
    assert (M == [[0, 4, 2, 0], [4, 1, 33, 8], [2, 33, 2, 16], [0, 8, 16, 3]]).all()


def test_a_diagonal_matrix():
    assert (diagonal_matrix(np.array([3, 0, 2])).toarray() == np.diag([3.0, 0.0, 2.0])).all()
