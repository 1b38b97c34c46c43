"""A basis of eigenfunctions: orthonormal in its own mass, exact on spheres, rectangles and tori, for every operator."""

import numpy as np
import pytest
from helpers import joined, moved

import lbskel
from lbskel import Mesh, MeshError, PointCloud, UnknownChoice, spectral_basis
from lbskel.operators import PolygonMesh
from lbskel.shapes import flat_grid, sphere, torus


@pytest.mark.parametrize("operator", ["cotangent", "robust", "intrinsic_delaunay", "mollified"])
def test_eigenvalues_of_the_sphere_are_l_times_l_plus_1(operator):
    values = spectral_basis(sphere(4), 25, operator=operator).values
    degree = np.repeat(np.arange(5), 2 * np.arange(5) + 1)
    assert np.abs(values - degree * (degree + 1)).max() < 0.15  # h = 0.07: h^2 l^4 / 12 for l = 4


def test_eigenvalues_of_a_rectangle_are_those_of_its_cosines():
    grid = flat_grid(41, 21)
    V = grid.vertices - grid.vertices.min(axis=0)
    mesh = grid.with_vertices(V / V.max(axis=0).clip(1e-9) * [2.0, 1.0, 1.0])
    found = spectral_basis(mesh, 8, operator="cotangent").values
    m, n = np.mgrid[:9, :9]
    exact = np.sort(np.pi**2 * (m**2 / 4 + n**2).ravel())[:8]
    assert np.abs(found - exact).max() < 0.01 * exact[-1]  # (pi k h)^2 / 12 for h = 1 / 20 and k = 2


def test_eigenvalues_of_a_flat_torus_by_a_function_as_operator():
    """A torus of n x n vertices whose opposite sides are identified; the operator takes lengths from the parameters."""
    n, (a, b) = 24, (1.0, 0.5)
    ring = torus(1.0, 0.3, n, n)

    def flat(mesh):
        u, v = np.divmod(np.arange(n * n), n)
        corners = mesh.faces
        U, W = (
            (u[corners] - u[corners[:, :1]] + n // 2) % n * a / n,
            (v[corners] - v[corners[:, :1]] + n // 2) % n * b / n,
        )
        unfolded = Mesh(np.stack([U.ravel(), W.ravel(), np.zeros(U.size)], axis=1), np.arange(U.size).reshape(-1, 3))
        pieces = lbskel.laplacian(unfolded, operator="cotangent", mass="barycentric")
        from scipy.sparse import csc_array

        P = csc_array((np.ones(U.size), (corners.ravel(), np.arange(U.size))), shape=(n * n, U.size))
        return lbskel.Laplacian((P @ pieces.stiffness @ P.T).tocsc(), (P @ pieces.mass @ P.T).tocsc())

    found = spectral_basis(ring, 9, operator=flat).values
    i, j = np.mgrid[-4:5, -4:5]
    exact = np.sort(4 * np.pi**2 * (i**2 / a**2 + j**2 / b**2).ravel())[:9]
    assert np.abs(found - exact).max() < 0.03 * exact[-1]  # (2 pi k / n)^2 / 12 = 2.3 % for k = 2


@pytest.mark.parametrize("mass", [None, "voronoi", "full"])
def test_projection_and_reconstruction_carry_the_mass(ring, mass):
    basis = spectral_basis(ring, 40, mass=mass)
    assert np.abs(basis.gram() - np.eye(40)).max() < 1e-10  # rounding of some hundred terms
    coefficients = np.random.default_rng(0).standard_normal((40, 3))
    assert np.abs(basis.project(basis.reconstruct(coefficients)) - coefficients).max() < 1e-10
    assert np.abs(basis.reconstruct(coefficients[:7]) - basis.functions[:, :7] @ coefficients[:7]).max() == 0.0
    assert basis.residual() < 1e-11
    assert basis.area == pytest.approx(ring.area, rel=1e-3)  # the robust operator's triangles are mollified


def test_all_functions_of_a_mesh_reconstruct_it_exactly(tetrahedron):
    basis = spectral_basis(tetrahedron, 4)
    assert np.abs(basis.reconstruct(basis.project(tetrahedron.vertices)) - tetrahedron.vertices).max() < 1e-12


def test_a_scaling_by_s_divides_eigenvalues_by_its_square_and_functions_by_it(ring):
    one, ten = spectral_basis(ring, 12), spectral_basis(ring.with_vertices(10.0 * ring.vertices), 12)
    assert np.abs(ten.values * 100 - one.values).max() < 1e-9
    i = basis_alone = 0
    assert abs(ten.functions[i, basis_alone]) * 10 == pytest.approx(abs(one.functions[i, basis_alone]))


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("operator", ["robust", "random_walk", "inverse_distance", "mean_value_symmetric"])
def test_the_zeros_are_those_of_the_components_in_every_unit(ring, operator, scale):
    two = joined(ring, moved(ring, 5.0))
    basis = spectral_basis(two.with_vertices(scale * two.vertices), 6, operator=operator)
    assert basis.positive.tolist() == [2, 3, 4, 5]


@pytest.mark.parametrize("operator", ["inverse_distance", "mean_value_symmetric"])
def test_the_area_is_that_of_the_surface_where_masses_are_lengths(operator):
    ball = sphere(3)
    assert spectral_basis(ball, 2, operator=operator).area == pytest.approx(ball.area, rel=0.01)  # triangles are uneven


def test_components_have_one_zero_each_and_points_a_spectrum(ring):
    two = spectral_basis(joined(ring, moved(ring, 5.0)), 6)
    assert len(two.values) - len(two.positive) == 2
    ball = sphere(3)
    values = spectral_basis(PointCloud(ball.vertices), 4).values
    assert np.abs(values - [0, 2, 2, 2]).max() < 0.2  # h^2 = 0.02, and ten times for the estimated areas


def test_a_polygon_mesh_has_a_basis_by_default():
    ball = sphere(3)
    polygons = spectral_basis(PolygonMesh(ball.vertices, ball.faces), 5)
    assert polygons.values == pytest.approx(
        spectral_basis(ball, 5, operator="cotangent").values, abs=1e-3
    )  # another mass


def test_the_operator_that_is_named_instead_is_one_of_clouds_too():
    with pytest.raises(MeshError, match="not symmetric; choose one that is, such as 'robust'"):
        spectral_basis(PointCloud(np.random.default_rng(0).normal(size=(300, 3))), 5, operator="local_delaunay")


def test_what_cannot_be_is_refused(ring):
    basis = spectral_basis(ring, 5)
    for k in (0, -1, 2.5, None, True):
        with pytest.raises(UnknownChoice, match="whole number from 1 on"):
            spectral_basis(ring, k)
    with pytest.raises(MeshError, match="one row for each of"):
        basis.project(np.ones(3))
    with pytest.raises(MeshError, match="one row for each of"):
        basis.project(np.ones((len(ring.vertices), 2, 2)))
    with pytest.raises(MeshError, match="values of a function must be finite"):
        basis.project(np.full(len(ring.vertices), np.nan))
    with pytest.raises(MeshError, match="5 functions"):
        basis.reconstruct(np.ones(6))
    with pytest.raises(MeshError, match="coefficients must be finite"):
        basis.reconstruct([np.nan])
    with pytest.raises(MeshError, match="not symmetric"):
        spectral_basis(ring, 5, operator="mean_value")
