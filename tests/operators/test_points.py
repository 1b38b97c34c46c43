"""Laplacians of point clouds: spheres, grids, stars used again, degenerate clouds."""

import numpy as np
import pytest
from hypothesis import given, settings
from operator_shapes import (
    closed_meshes,
    fibonacci_sphere,
    hexagons,
    is_finite,
    positions,
)

from lbskel import PointCloud
from lbskel.operators import POINT_OPERATORS, laplacian
from lbskel.operators.points import cloud_stars


@pytest.mark.parametrize("name", POINT_OPERATORS)
def test_points_of_a_sphere(name):
    P = fibonacci_sphere(3000)
    L = laplacian(PointCloud(P), operator=name)
    assert abs(L.mass.sum() / (4 * np.pi) - 1) < 0.01  # the tangent stars are flat: h^2 = 0.004
    assert np.abs(L.stiffness @ np.ones(3000)).max() < 1e-12
    x, y, _ = P.T
    for values, eigenvalue in ((x, 2), (x * y, 6)):
        quotient = values @ (L.stiffness @ values) / (values @ (L.mass @ values))
        assert abs(quotient / eigenvalue - 1) < (0.01 if name != "heat_kernel" else 0.05)


def test_stars_of_a_grid_have_its_four_neighbors_and_weights_one():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij"))
    L = laplacian(PointCloud(np.column_stack([x, y, np.zeros(49)])), operator="local_delaunay")
    row = L.stiffness.tocsr()[[24]].toarray().reshape(7, 7)
    expected = np.zeros((7, 7))
    expected[3, 2:5], expected[2:5, 3], expected[3, 3] = -1, -1, 4
    assert np.abs(row - expected).max() < 1e-12
    assert abs(L.mass.diagonal()[24] - 1) < 1e-12


def test_stars_can_be_reused_for_moved_points():
    P = fibonacci_sphere(200)
    local = POINT_OPERATORS["local_delaunay"]
    first = local(PointCloud(P))
    again = local(PointCloud(P * [1, 1, 0.5]), stars=cloud_stars(PointCloud(P)))
    assert ((abs(first.stiffness).sign() - abs(again.stiffness).sign()).nnz) == 0
    assert abs(first.stiffness - again.stiffness).max() > 0.1


@pytest.mark.parametrize("name", POINT_OPERATORS)
@settings(max_examples=60)
@given(points=positions() | closed_meshes().map(lambda mesh: mesh.vertices))
def test_operators_of_points_stay_finite(name, points):
    assert is_finite(laplacian(PointCloud(points), operator=name))


def test_few_points_have_each_triangle_of_their_stars_once():
    """25 points of a triangular lattice, fewer than the neighbors asked for: 32 triangles in their hull."""
    mesh, _ = hexagons(5, edge=40.0)
    L = laplacian(PointCloud(mesh.vertices), operator="robust")
    assert L.mass.sum() == pytest.approx(32 * np.sqrt(3) / 4 * 40**2, rel=1e-4)
    middle = 12
    assert L.stiffness.toarray()[middle, middle] == pytest.approx(6 / np.sqrt(3), rel=1e-3)


def test_the_mass_of_many_points_is_in_the_units_of_the_caller():
    P = 40 * fibonacci_sphere(3000)
    assert laplacian(PointCloud(P), operator="robust").mass.sum() == pytest.approx(4 * np.pi * 40**2, rel=0.01)
    assert laplacian(PointCloud(P), operator="heat_kernel").mass.sum() == pytest.approx(4 * np.pi * 40**2, rel=0.01)


def test_points_on_a_line_have_the_zero_operator():
    line = PointCloud(np.arange(4)[:, None] * [1.0, 2.0, 3.0])
    for name in POINT_OPERATORS:
        L = laplacian(line, operator=name)
        assert L.stiffness.nnz == 0 or abs(L.stiffness).max() == 0
        assert L.treated_vertices.tolist() == [0, 1, 2, 3]
