"""Quadrics of lines: squared distances written out."""

import numpy as np
import pytest

from lbskel.contraction.quadrics import line_quadrics


def test_quadrics_are_squared_distances_to_the_lines_of_the_edges():
    P = np.array([[0.0, 0, 0], [2.0, 0, 0], [0.0, 3, 0], [0.0, 3, 0]])
    edges = np.array([[0, 1], [0, 2], [2, 3]])  # along x, along y, and one of no length
    Q = line_quadrics(P, edges)
    point = np.array([1.0, 4.0, 2.0, 1.0])
    to_x, to_y = 4.0**2 + 2.0**2, 1.0**2 + 2.0**2
    assert [float(point @ q @ point) for q in Q] == pytest.approx([to_x + to_y, to_x, to_y, 0.0])
