"""Mass matrices, against libigl and areas worked out by hand."""

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from operator_shapes import (
    degenerate_meshes,
)

from lbskel import Mesh, laplacian
from lbskel.operators.masses import MASSES, barycentric_mass, full_mass, moment_mass, voronoi_mass
from lbskel.shapes import flat_grid


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("voronoi", igl.MASSMATRIX_TYPE_VORONOI),
        ("barycentric", igl.MASSMATRIX_TYPE_BARYCENTRIC),
        ("full", igl.MASSMATRIX_TYPE_FULL),
    ],
)
def test_masses(mesh, name, kind):
    ours, theirs = MASSES[name](mesh), igl.massmatrix(mesh.vertices, mesh.faces, kind)
    assert abs(ours - theirs).max() < 1e-12 * abs(theirs).max()


@pytest.mark.parametrize("mass", MASSES)
@settings(max_examples=30)
@given(mesh=degenerate_meshes())
def test_masses_stay_finite_and_are_the_area(mass, mesh):
    M = MASSES[mass](mesh)
    assert np.isfinite(M.data).all()
    unit = np.abs(mesh.vertices).max(initial=1e-300)
    area = mesh.with_vertices(mesh.vertices / unit).area * unit**2
    # libigl's Voronoi pieces come from lengths, whose rounding is the square root of that of an area near zero
    assert abs(M.sum() - area) <= 1e-7 * len(mesh.faces) * unit**2


def triangle(*points):
    """One triangle of points in the plane, forty times as large, so that internal scaling by powers of two shows."""
    return Mesh(40 * np.column_stack([points, np.zeros(3)]), [[0, 1, 2]])


def test_voronoi_areas_of_a_right_and_of_an_obtuse_triangle():
    right = voronoi_mass(triangle((0, 0), (4, 0), (0, 3))).diagonal() / 40**2
    # at p: (|pq|^2 cot r + |pr|^2 cot q) / 8 with cotangents 0, 3/4 and 4/3
    assert right == pytest.approx([(16 * 3 / 4 + 9 * 4 / 3) / 8, 16 * 3 / 4 / 8, 9 * 4 / 3 / 8])
    obtuse = voronoi_mass(triangle((0, 0), (4, 0), (1, 1))).diagonal() / 40**2
    assert obtuse == pytest.approx([2 / 4, 2 / 4, 2 / 2])  # area 2, the obtuse corner last
    equilateral = voronoi_mass(triangle((0, 0), (2, 0), (1, np.sqrt(3)))).diagonal() / 40**2
    assert equilateral == pytest.approx(np.full(3, np.sqrt(3) / 3))


def test_thin_triangles_keep_their_area():
    thin = triangle((0, 0), (1, 0), (0.5, 1e-3))
    assert voronoi_mass(thin).sum() == pytest.approx(40**2 * 1e-3 / 2)
    tall = triangle((0, 0), (1e-3, 0), (0.5e-3, 1))
    assert voronoi_mass(tall).sum() == pytest.approx(40**2 * 1e-3 / 2)
    assert voronoi_mass(tall).diagonal()[2] == pytest.approx(40**2 * 1e-3 / 8, rel=1e-5)  # a quarter at the apex


def test_barycentric_and_full_masses_of_one_triangle():
    mesh = triangle((0, 0), (4, 0), (0, 3))
    assert barycentric_mass(mesh).toarray() == pytest.approx(40**2 * 2 * np.eye(3))
    assert full_mass(mesh).toarray() == pytest.approx(40**2 * (np.eye(3) + np.ones((3, 3))) / 2)


def test_the_moment_mass_of_cotangent_weights_is_the_voronoi_area():
    mesh = triangle((0, 0), (4, 0), (1, 3))
    assert moment_mass(mesh, laplacian(mesh).stiffness).diagonal() == pytest.approx(voronoi_mass(mesh).diagonal())


@pytest.mark.parametrize("operator", ["inverse_distance", "mean_value", "mean_value_symmetric"])
def test_the_moment_mass_is_exact_for_the_squared_distance_from_a_vertex(operator):
    """Of |x|^2 itself only where rows are linearly precise, as those of ``mean_value`` inside a plane."""
    V = flat_grid(7, 6).vertices + [0.03, 0.03, 0] * np.random.default_rng(0).standard_normal((42, 3))
    mesh = Mesh(V, flat_grid(7, 6).faces)
    L = laplacian(mesh, operator=operator)
    squares = ((V[:, None] - V) ** 2).sum(axis=2)
    assert np.diagonal(L.delta(squares)) == pytest.approx(-4.0, rel=1e-9)
    inside = np.setdiff1d(np.arange(42), mesh.edges[mesh.faces_per_edge == 1])
    is_exact = np.abs(L.delta((V**2).sum(axis=1))[inside] + 4).max() < 1e-9
    assert is_exact == (operator == "mean_value")
