"""The value of a Laplacian: its strong form, curvature normals, signs, entries that are not finite, and printing."""

import igl
import numpy as np
import pytest
from operator_shapes import PYTHAGORAS
from scipy.sparse import csc_array

from lbskel import MeshError, UnknownChoice
from lbskel.operators import Laplacian, from_igl, laplacian, to_igl
from lbskel.shapes import cylinder, sphere, torus


def test_mean_curvature_normals_of_a_sphere_point_outward_and_have_length_one_over_the_radius():
    ball = sphere(4)
    H = laplacian(ball.with_vertices(2 * ball.vertices)).mean_curvature_normals(2 * ball.vertices)
    # 2,562 vertices: h = 0.07, so h^2 = 0.005; at the twelve vertices of valence five the error stays near 1 %
    assert np.abs(H - ball.vertices / 2).max() < 0.01


def test_mean_curvature_normals_of_anisotropic_are_half_as_long_on_a_sphere():
    ball = sphere(4)
    H = laplacian(ball, operator="anisotropic").mean_curvature_normals(ball.vertices)
    assert (H * ball.vertices).sum(axis=1).mean() == pytest.approx(0.5, abs=0.001)


@pytest.mark.parametrize("name", ["cotangent", "intrinsic_delaunay", "robust"])
def test_mean_curvature_of_a_cylinder_and_a_torus(name):
    side = cylinder(0.5, 2.0, 64, 41)
    H = laplacian(side, operator=name).mean_curvature_normals(side.vertices)
    inner = np.abs(side.vertices[:, 2]) < 0.9
    outwards = side.vertices * [1, 1, 0] / 0.5
    assert np.abs(H - outwards)[inner].max() < 2e-3  # 1 / (2 r) = 1, up to (pi / 64)^2 / 2
    R, r = 1.0, 0.4
    ring = torus(R, r, 120, 60)
    H = laplacian(ring, operator=name).mean_curvature_normals(ring.vertices)
    t = 2 * np.pi * np.tile(np.arange(60), 120) / 60
    expected = (R + 2 * r * np.cos(t)) / (2 * r * (R + r * np.cos(t)))
    # second order: (2 pi / 60)^2 = 0.011 of the largest curvature, 1.6
    assert np.abs(np.linalg.norm(H, axis=1) - np.abs(expected)).max() < 0.02


def test_degrees_as_mass_give_no_curvature(ring):
    with pytest.raises(UnknownChoice, match=r"masses are degrees.*mass='voronoi'"):
        laplacian(ring, operator="random_walk").mean_curvature_normals(ring.vertices)
    H = laplacian(ring, operator="random_walk", mass="voronoi").mean_curvature_normals(ring.vertices)
    assert np.array_equal(H, laplacian(ring, operator="graph").mean_curvature_normals(ring.vertices))


def test_the_strong_form_refuses_a_mass_that_is_not_diagonal(ring):
    with pytest.raises(UnknownChoice, match="'voronoi' or 'barycentric'"):
        laplacian(ring, mass="full").strong()


def test_igl_has_the_other_sign(rough):
    V, F = rough.vertices, rough.faces
    L, M = igl.cotmatrix(V, F), igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_VORONOI)
    ours = from_igl(L, M)
    assert abs(ours.stiffness + L).max() == 0
    back, mass = to_igl(ours)
    assert abs(back - L).max() == 0
    assert abs(mass - M).max() == 0


def test_entries_that_are_not_finite_are_refused():
    bad = csc_array([[np.nan, 0.0], [0.0, 1.0]])
    with pytest.raises(MeshError, match="about unit size"):
        Laplacian(bad, csc_array(np.eye(2)))


def test_coordinates_whose_areas_overflow_are_refused():
    with np.errstate(over="ignore"), pytest.raises(MeshError, match="scale its coordinates"):
        laplacian(sphere(0).with_vertices(1e200 * sphere(0).vertices))


def test_a_laplacian_prints_its_size_its_mass_and_what_was_treated(tetrahedron):
    assert repr(laplacian(tetrahedron)) == "Laplacian(4 vertices, 16 entries, mass 2.36603)"
    assert repr(laplacian(PYTHAGORAS)) == "Laplacian(6 vertices, 7 entries, mass 6, 3 treated)"


def test_the_strong_form_divides_rows_by_the_mass_and_leaves_rows_without_mass_zero():
    S = csc_array([[2.0, -2.0, 0.0], [-2.0, 3.0, -1.0], [0.0, -1.0, 1.0]])
    strong = Laplacian(S, csc_array(np.diag([4.0, 0.5, 0.0]))).strong().toarray()
    assert (strong == [[0.5, -0.5, 0], [-4, 6, -2], [0, 0, 0]]).all()


def test_values_of_another_number_of_vertices_are_refused(tetrahedron):
    L = laplacian(tetrahedron)
    for wrong in (np.zeros(3), np.zeros((3, 4)), 1.0):
        with pytest.raises(MeshError, match="each of 4 vertices"):
            L.delta(wrong)
    with pytest.raises(MeshError, match="each of 4 vertices"):
        L.mean_curvature_normals(np.zeros((3, 3)))
