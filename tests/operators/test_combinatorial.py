"""The graph Laplacian and the random walk, which know only connectivity."""

import numpy as np
import pytest
from operator_shapes import hexagons

from lbskel.operators import (
    laplacian,
)


def test_the_random_walk_is_a_vertex_minus_the_mean_of_its_neighbors(tetrahedron):
    L = laplacian(tetrahedron, operator="random_walk")
    expected = np.eye(4) - (np.ones((4, 4)) - np.eye(4)) / 3
    assert np.allclose(L.strong().toarray(), expected, rtol=0, atol=1e-15)
    assert np.allclose(L.delta(tetrahedron.vertices), expected @ tetrahedron.vertices, rtol=0, atol=1e-15)


def test_graph_and_random_walk_on_regular_rings():
    mesh, inner = hexagons(41, 0.05)
    x, y, _ = mesh.vertices.T
    values, middle = 3 * x**2 + x * y - y**2, 20 * 41 + 20
    assert inner[middle]
    # six unit weights at distance h give 3/2 h^2, the area is sqrt(3)/2 h^2
    assert abs(laplacian(mesh, operator="graph").delta(values)[middle] + 4 * np.sqrt(3)) < 1e-9
    # the random walk has no length: 1/4 h^2
    assert abs(laplacian(mesh, operator="random_walk").delta(values)[middle] + 4 * 0.05**2 / 4) < 1e-12


def test_the_graph_laplacian_has_degrees_and_minus_ones(tetrahedron):
    L = laplacian(tetrahedron, operator="graph")
    assert (L.stiffness.toarray() == 4 * np.eye(4) - np.ones((4, 4))).all()
    assert L.mass.sum() == pytest.approx(tetrahedron.area)
    assert (laplacian(tetrahedron, operator="random_walk").mass.toarray() == 3 * np.eye(4)).all()
