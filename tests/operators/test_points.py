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
from lbskel.applications.spectrum import eigenpairs
from lbskel.operators import POINT_OPERATORS, apply_operator, laplacian
from lbskel.operators.star_rings import stars_in_order


def sphere_of_random_points(n):
    P = np.random.default_rng(0).normal(size=(n, 3))
    return P / np.linalg.norm(P, axis=1, keepdims=True)


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


@pytest.mark.parametrize("name", POINT_OPERATORS)
def test_operators_of_points_do_not_change_with_a_translation(name):
    """Random points: robust_laplacian's own stars gave other eigenvalues, up to a fifth, 100 radii away."""
    P = sphere_of_random_points(3000)
    L, moved = (laplacian(PointCloud(points), operator=name) for points in (P, P + [100.0, -70.0, 30.0]))
    assert abs(L.stiffness - moved.stiffness).max() < 1e-9 * abs(L.stiffness).max()
    assert abs(L.mass - moved.mass).max() < 1e-9 * abs(L.mass).max()


@pytest.mark.parametrize("name", POINT_OPERATORS)
@pytest.mark.parametrize("signs", [[1, 1, -1], [1, -1, 1]])
def test_operators_of_points_do_not_change_in_a_mirror(name, signs):
    """Most of these stars are open: heat_kernel left out the last neighbor of each, which one depends on the side."""
    P = np.random.default_rng(0).standard_normal((60, 3))
    here, there = (laplacian(PointCloud(points), operator=name) for points in (P, P * signs))
    assert np.abs((here.stiffness - there.stiffness).toarray()).max() < 1e-9 * np.abs(here.stiffness).max()
    assert there.mass.diagonal() == pytest.approx(here.mass.diagonal(), rel=1e-9)


def test_robust_keeps_the_area_of_dense_random_points():
    """robust_laplacian's own stars lose 7 % of the sphere's area with 20,000 random points, 0.01 % with 5,000."""
    mass = laplacian(PointCloud(sphere_of_random_points(20_000)), operator="robust").mass
    assert abs(mass.sum() / (4 * np.pi) - 1) < 0.01


def test_robust_has_as_many_neighbors_as_it_is_asked_for():
    """Two triangles far from each other: the star of each corner needs both of the others."""
    P = np.concatenate([np.eye(3), np.eye(3) + 50])
    robust = POINT_OPERATORS["robust"]
    assert robust(PointCloud(P), n_neighbors=2).mass.sum() == pytest.approx(np.sqrt(3), rel=1e-4)
    assert robust(PointCloud(P), n_neighbors=1).mass.sum() == 0


@pytest.mark.parametrize(("n", "error"), [(500, 0.05), (2000, 0.01)])
def test_robust_has_the_eigenvalues_of_the_surface(n, error):
    """Copies of a triangle, glued to each other, made all eigenvalues 5 % too small."""
    values = eigenpairs(laplacian(PointCloud(sphere_of_random_points(n)), operator="robust"), 4)[0]
    assert abs(values[1:].mean() / 2 - 1) < 0.01
    assert np.abs(values[1:] / 2 - 1).max() < error  # of random points: 0.044 and 0.004 were found


def test_a_point_without_a_triangle_of_two_stars_keeps_its_own_star():
    noise = np.random.default_rng(1).normal(size=(200, 1))
    P = sphere_of_random_points(200) * (1 + 0.05 * noise)  # one point has none
    L = laplacian(PointCloud(P), operator="robust")
    assert L.mass.diagonal().min() > 1e-3
    assert len(L.treated_vertices) == 0


def test_an_outlier_does_not_lengthen_the_edges_of_all_points():
    """By the mean edge, one point a million radii away spoiled 114 rows of 301."""
    L = laplacian(PointCloud(np.concatenate([sphere_of_random_points(300), [[1e6, 0, 0]]])), operator="robust")
    assert len(L.treated_vertices) == 0


def test_robust_keeps_the_area_and_the_energy_of_a_grid():
    """Four points on a circle: their stars must agree on a diagonal, or each triangle is in one star alone."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(20.0), np.arange(20.0), indexing="ij"))
    for jitter in (0.0, 1e-10, 1e-7):
        P = np.column_stack([x, y, np.zeros(400)]) + jitter * np.random.default_rng(0).normal(size=(400, 3)) * [1, 1, 0]
        L = laplacian(PointCloud(P), operator="robust")
        assert L.mass.sum() == pytest.approx(361, rel=2e-3)  # thin triangles at the jittered boundary
        assert x @ (L.stiffness @ x) == pytest.approx(361, rel=2e-3)


def test_stars_of_a_grid_have_its_four_neighbors_and_weights_one():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij"))
    L = laplacian(PointCloud(np.column_stack([x, y, np.zeros(49)])), operator="local_delaunay")
    row = L.stiffness.tocsr()[[24]].toarray().reshape(7, 7)
    expected = np.zeros((7, 7))
    expected[3, 2:5], expected[2:5, 3], expected[3, 3] = -1, -1, 4
    assert np.abs(row - expected).max() < 1e-12
    assert abs(L.mass.diagonal()[24] - 1) < 1e-12


def test_stars_of_a_contracted_cloud_are_those_given():
    stars = stars_in_order(PointCloud(fibonacci_sphere(200)))
    flat = stars.with_vertices(stars.vertices * [1, 1, 0.5])
    first, again = (apply_operator("local_delaunay", given) for given in (stars, flat))
    assert ((abs(first.stiffness).sign() - abs(again.stiffness).sign()).nnz) == 0
    assert abs(first.stiffness - again.stiffness).max() > 0.1


@pytest.mark.parametrize("name", ["local_delaunay", "heat_kernel"])
@pytest.mark.parametrize("n", [200, 500, 1000])
def test_few_points_have_the_area_of_their_surface(name, n):
    """With 1.2 % of the points as neighbors, at least seven, a third of the area was missing."""
    L = laplacian(PointCloud(sphere_of_random_points(n)), operator=name)
    assert L.mass.sum() == pytest.approx(4 * np.pi, rel=0.03)


@pytest.mark.parametrize("name", POINT_OPERATORS)
@pytest.mark.parametrize("times", [2, 40])
def test_copies_of_points_change_neither_area_nor_eigenvalues(name, times):
    P = sphere_of_random_points(400)
    copied = np.concatenate([np.tile(P[:20], (times - 1, 1)), P])
    once, several = (laplacian(PointCloud(points), operator=name) for points in (P, copied))
    place = np.concatenate([np.tile(np.arange(20), times - 1), np.arange(400)])
    first = np.unique(place, return_index=True)[1]
    copies = np.setdiff1d(np.arange(len(place)), first)
    assert several.mass.diagonal()[first] == pytest.approx(once.mass.diagonal(), rel=1e-9)
    assert several.mass.sum() == pytest.approx(once.mass.sum(), rel=1e-12)
    assert np.isin(copies, several.treated_vertices).all()
    values = P[:, 2] * P[:, 0]
    assert several.delta(values[place])[first] == pytest.approx(once.delta(values), abs=1e-8)
    assert np.abs(several.stiffness.sum(axis=1)).max() < 1e-10
    if name != "local_delaunay":
        found, functions = eigenpairs(several, 4)
        assert found == pytest.approx(eigenpairs(once, 4)[0], abs=1e-9)
        assert functions == pytest.approx(functions[first][place], abs=1e-6)


@pytest.mark.parametrize("name", POINT_OPERATORS)
def test_a_copy_of_a_point_adds_as_little_as_an_edge(name):
    """Copies coupled with the copies of their neighbors would make 10,000 entries of one."""
    P = sphere_of_random_points(300)
    once, several = (laplacian(PointCloud(np.repeat(P, k, axis=0)), operator=name) for k in (1, 100))
    assert several.stiffness.nnz <= once.stiffness.nnz + 3 * 99 * 300


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
