"""Weights of one over the length."""

import numpy as np
import pytest
from operator_shapes import PYTHAGORAS

from lbskel import Mesh
from lbskel.operators.inverse_distance import inverse_distance


def test_weights_are_inverse_lengths_and_the_mass_a_quarter_of_their_sum():
    L = inverse_distance(PYTHAGORAS)
    assert L.stiffness.toarray()[:3, :3] == pytest.approx(
        np.array([[1 / 4 + 1 / 3, -1 / 4, -1 / 3], [-1 / 4, 1 / 4 + 1 / 5, -1 / 5], [-1 / 3, -1 / 5, 1 / 3 + 1 / 5]])
    )
    assert L.mass.diagonal() == pytest.approx(np.array([7, 9, 8, 3, 2, 3]) / 4)
    assert not L.treated_vertices.size


def test_an_edge_without_length_has_no_weight():
    L = inverse_distance(Mesh([[0, 0, 0], [0, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
    assert L.stiffness.toarray()[0, 1] == 0
    assert L.stiffness.toarray()[[0, 1], 2] == pytest.approx(-1 / 2)
    assert L.treated_vertices.tolist() == [0, 1]
