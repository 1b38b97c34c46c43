"""Findings as sentences, and reasons against contraction."""

import numpy as np

from lbskel import Mesh, check


def test_contraction_of_unconnected_or_collinear_faces_is_not_advised():
    V = np.random.default_rng(0).normal(size=(300, 3))
    assert check(Mesh(V, np.arange(300).reshape(-1, 3))).is_advised is False
    assert check(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])).is_advised is False
