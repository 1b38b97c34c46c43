"""What every operator promises: one convention, exact cases, finite entries; and checks of callers' operators."""

from types import SimpleNamespace

import igl
import numpy as np
import pytest
from hypothesis import example, given, settings
from operator_shapes import (
    CAP,
    HAIR,
    NEEDLE,
    NOTHING,
    POINT,
    TWICE,
    closed_meshes,
    degenerate_meshes,
    hexagons,
    is_finite,
    scattered_plane,
)
from scipy.sparse import csc_array

from lbskel import Mesh, MeshError, OperatorError, PointCloud, UnknownChoice, write_mesh
from lbskel.geometry.intrinsic_triangulation import (
    half_edge_twins,
)
from lbskel.operators import (
    MASSES,
    OPERATORS,
    POINT_OPERATORS,
    Laplacian,
    PolygonMesh,
    apply_operator,
    laplacian,
    operator_named,
    to_igl,
)
from lbskel.shapes import sphere

NOT_SYMMETRIC = {"mean_value", "cotangent_identity"}

# Rows sum to zero up to the rounding of a few dozen entries of the size of the largest.
ROUNDING = 1e-14

NOT_LINEAR_ON_A_PLANE = ["graph", "random_walk", "inverse_distance", "mean_value_symmetric", "heat_kernel"]

LINEAR_ON_A_PLANE = ["cotangent", "cotangent_identity", "mean_value", "intrinsic_delaunay", "robust", "anisotropic"]


@pytest.mark.parametrize("name", OPERATORS)
def test_rows_sum_to_zero_and_symmetric_ones_are_positive_semidefinite(name, rough):
    L = laplacian(rough, operator=name)
    assert isinstance(L.stiffness, csc_array)
    assert isinstance(L.mass, csc_array)
    assert L.stiffness.shape == L.mass.shape == (288, 288)
    S = L.stiffness.toarray()
    keeps_constants = np.setdiff1d(np.arange(288), L.treated_vertices if name == "cotangent_identity" else [])
    assert np.abs(S.sum(axis=1)[keeps_constants]).max() < ROUNDING * np.abs(S).max()
    assert (S.diagonal() > 0).all()
    if name in NOT_SYMMETRIC:
        assert np.abs(S - S.T).max() > 1e-3 * np.abs(S).max()
    else:
        assert np.abs(S - S.T).max() < ROUNDING * np.abs(S).max()
        eigenvalues = np.linalg.eigvalsh(S)
        # the smallest of a semidefinite matrix is zero up to its rounding; the next belongs to no constant
        assert abs(eigenvalues[0]) < 1e-13 * eigenvalues[-1]
        assert eigenvalues[1] > 1e-6 * eigenvalues[-1]


@pytest.mark.parametrize("name", OPERATORS)
def test_operators_are_rigid_invariant_and_scale_as_their_unit_does(name, rough):
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    L, moved = (
        laplacian(rough, operator=name),
        laplacian(rough.with_vertices(rough.vertices @ turned + 3), operator=name),
    )
    x = np.random.default_rng(2).normal(size=288)
    # the moved coordinates are rounded at 4, ten times coarser, and thin triangles magnify it
    assert np.allclose(L.delta(x), moved.delta(x), rtol=1e-8, atol=1e-8 * np.abs(L.delta(x)).max())
    doubled = laplacian(rough.with_vertices(8 * rough.vertices), operator=name)
    unit = {"random_walk": 1, "cotangent_identity": None}.get(name, 64)  # of M^-1 S: no length, and 1 / length^2
    if unit:
        assert np.allclose(L.delta(x), unit * doubled.delta(x), rtol=1e-12)


@pytest.mark.parametrize("name", OPERATORS)
def test_vertices_without_a_face_have_empty_rows(name, ring):
    with_unused = Mesh(np.concatenate([ring.vertices, [[9.0, 9.0, 9.0]]]), ring.faces)
    L = laplacian(with_unused, operator=name)
    assert L.stiffness.shape == L.mass.shape == (129, 129)
    assert abs(L.stiffness[[128]]).sum() == 0
    assert np.isfinite(L.delta(with_unused.vertices)).all()


@pytest.mark.parametrize("name", LINEAR_ON_A_PLANE + NOT_LINEAR_ON_A_PLANE)
def test_linear_functions_of_a_plane(name):
    mesh, P, inner = scattered_plane()
    S = laplacian(mesh, operator=name).stiffness
    error = np.abs(S @ P)[inner].max(axis=1) / (np.abs(S) @ np.ones(len(P)))[inner]
    if name in LINEAR_ON_A_PLANE:
        assert error.max() < 1e-14  # coordinates rounded at 1e-16, magnified by the thinnest triangles
    else:
        assert error.max() > 1e-3


@pytest.mark.parametrize(
    "name", ["inverse_distance", "cotangent", "mean_value", "mean_value_symmetric", "intrinsic_delaunay", "robust"]
)
def test_the_laplacian_of_a_quadratic_on_regular_rings(name):
    """Of 3 x^2 + x y - y^2 it is 4, so -4 with our sign: rings of six are exact for quadratics."""
    mesh, inner = hexagons()
    x, y, _ = mesh.vertices.T
    found = laplacian(mesh, operator=name).delta(3 * x**2 + x * y - y**2)[inner]
    assert np.abs(found + 4).max() < 1e-12 / 0.1**2  # rounding of the values over the square of the edge


@pytest.mark.parametrize("name", ["cotangent", "intrinsic_delaunay", "robust", "heat_kernel"])
def test_the_first_harmonics_of_a_sphere(name):
    ball = sphere(4)
    L = laplacian(ball, operator=name)
    V = ball.vertices
    x, y, z = V.T
    for values, eigenvalue in ((x, 2), (x * y, 6), (2 * z**3 - 3 * z * (x**2 + y**2), 12)):
        # Rayleigh quotients, of second order in h = 0.07; the kernel's own width adds l (l + 1) t / 2
        quotient = values @ (L.stiffness @ values) / (values @ (L.mass @ values))
        assert abs(quotient / eigenvalue - 1) < (0.01 if name != "heat_kernel" else 0.05)


@pytest.mark.parametrize("name", OPERATORS)
@settings(max_examples=60)
@given(mesh=degenerate_meshes() | closed_meshes())
@example(mesh=NEEDLE)
@example(mesh=CAP)
@example(mesh=HAIR)
@example(mesh=POINT)
@example(mesh=TWICE)
@example(mesh=NOTHING)
def test_operators_of_meshes_stay_finite(name, mesh):
    if name in ("intrinsic_delaunay", "anisotropic") and half_edge_twins(igl.bfs_orient(mesh.faces)[0]) is None:
        with pytest.raises(MeshError, match="use the operator 'robust'"):
            laplacian(mesh, operator=name)
        return
    L = laplacian(mesh, operator=name)
    assert is_finite(L)
    assert np.isfinite(L.delta(mesh.vertices / np.abs(mesh.vertices).max(initial=1.0))).all()
    assert np.isin(L.treated_vertices, mesh.faces).all()


def test_vertices_of_triangles_without_area_are_listed_as_treated():
    for name in ("cotangent", "clamped_cotangent", "cotangent_identity", "mean_value", "intrinsic_delaunay", "robust"):
        for mesh in (POINT, CAP):
            assert laplacian(mesh, operator=name).treated_vertices.tolist() == [0, 1, 2], name
    assert laplacian(PolygonMesh(CAP.vertices, CAP.faces)).treated_vertices.tolist() == [0, 1, 2]
    assert laplacian(PointCloud(CAP.vertices), operator="local_delaunay").treated_vertices.tolist() == [0, 1, 2]


def test_vertices_of_degenerate_triangles_are_listed_as_treated():
    V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [5, 0, 0], [6, 0, 0], [7, 0, 0]]
    mesh = Mesh(V, [[0, 1, 2], [1, 3, 2], [4, 5, 6]])
    for name in OPERATORS:
        L = laplacian(mesh, operator=name)
        expected = [] if name in ("graph", "random_walk", "inverse_distance") else [4, 5, 6]
        assert L.treated_vertices.tolist() == expected, name
    assert laplacian(mesh, operator="clamped_cotangent").n_clamped_angles == 3
    identity = laplacian(mesh, operator="cotangent_identity").stiffness.toarray()
    assert (identity[4:] == np.eye(7)[4:]).all()


def test_an_unknown_name_is_refused_with_those_that_exist(ring):
    with pytest.raises(UnknownChoice, match=r"cotangnet.*choose one of: graph, random_walk"):
        laplacian(ring, operator="cotangnet")
    with pytest.raises(UnknownChoice, match="choose one of: voronoi, barycentric, full"):
        laplacian(ring, mass="lumped")
    with pytest.raises(UnknownChoice, match="choose one of: robust, local_delaunay, heat_kernel"):
        laplacian(PointCloud(ring.vertices), operator="cotangent")
    with pytest.raises(MeshError, match="leave mass out"):
        laplacian(PointCloud(ring.vertices), mass="voronoi")


def test_a_callable_is_an_operator(ring):
    def twice(mesh):
        L = OPERATORS["cotangent"](mesh)
        return Laplacian(2 * L.stiffness, L.mass)

    assert operator_named(twice) is twice
    assert abs(laplacian(ring, operator=twice).stiffness - 2 * laplacian(ring).stiffness).max() == 0


RETURNED = {
    "a bare matrix": (lambda mesh: igl.cotmatrix(mesh.vertices, mesh.faces), r"type csc_matrix.*from_igl\(L, M\)"),
    "a pair": (lambda mesh: to_igl(OPERATORS["cotangent"](mesh)), r"a tuple \(csc_array, csc_array\).*from_igl"),
    "nothing": (lambda mesh: None, r"type NoneType.*Laplacian\(stiffness, mass\)"),
    "libigl's sign": (lambda mesh: Laplacian(*to_igl(OPERATORS["cotangent"](mesh))), r"libigl's sign.*from_igl"),
    "another size": (lambda mesh: OPERATORS["cotangent"](sphere(0)), r"stiffness of shape \(12, 12\) for 128 vertices"),
    "a mass of another size": (
        lambda mesh: Laplacian(OPERATORS["cotangent"](mesh).stiffness, csc_array(np.eye(2))),
        r"mass of shape \(2, 2\)",
    ),
}


@pytest.mark.parametrize("what", RETURNED)
def test_a_function_that_returns_no_usable_laplacian_is_refused_with_the_remedy(what, ring):
    function, message = RETURNED[what]
    for call in (apply_operator, lambda operator, mesh: laplacian(mesh, operator=operator)):
        with pytest.raises(OperatorError, match=message):
            call(function, ring)
    with pytest.raises(OperatorError):
        laplacian(PointCloud(ring.vertices), operator=lambda cloud: None)


def test_any_sparse_format_of_a_callers_operator_becomes_csc(ring):
    def rows(mesh):
        L = OPERATORS["cotangent"](mesh)
        return Laplacian(L.stiffness.tocsr(), L.mass.tocoo())

    found = apply_operator(rows, ring)
    assert isinstance(found.stiffness, csc_array)
    assert isinstance(found.mass, csc_array)
    assert abs(found.stiffness - apply_operator("cotangent", ring).stiffness).max() == 0


def test_a_few_negative_entries_on_the_diagonal_are_not_taken_for_the_other_sign(ring):
    def with_one(mesh):
        S = OPERATORS["cotangent"](mesh).stiffness.copy()
        S.setdiag(np.where(np.arange(128) == 5, -1e-3, S.diagonal()))
        return Laplacian(S, OPERATORS["cotangent"](mesh).mass)

    assert apply_operator(with_one, ring).stiffness.diagonal()[5] == -1e-3


def test_what_as_mesh_takes_is_a_shape(ring, tmp_path):
    expected = laplacian(ring).stiffness
    for shape in ((ring.vertices, ring.faces), SimpleNamespace(vertices=ring.vertices, faces=ring.faces)):
        assert abs(laplacian(shape).stiffness - expected).max() == 0
        assert laplacian(shape, mass="barycentric").mass.sum() == pytest.approx(ring.area)
    path = tmp_path / "ring.off"
    write_mesh(path, ring)
    assert abs(laplacian(path).stiffness - expected).max() == 0
    assert (
        abs(laplacian(str(path), operator="robust").stiffness - laplacian(ring, operator="robust").stiffness).max() == 0
    )
    with pytest.raises(MeshError, match="cannot take a mesh from int"):
        laplacian(3)


def test_the_default_is_cotangent_and_for_points_robust(ring):
    assert abs(laplacian(ring).stiffness - OPERATORS["cotangent"](ring).stiffness).max() == 0
    cloud = PointCloud(ring.vertices)
    assert abs(laplacian(cloud).stiffness - POINT_OPERATORS["robust"](cloud).stiffness).max() == 0


@pytest.mark.parametrize("name", ["inverse_distance", "mean_value", "mean_value_symmetric"])
def test_weights_of_one_over_a_length_take_no_area_as_mass(name, ring):
    with pytest.raises(UnknownChoice, match=f"weights of the operator {name!r} are one over a length.*leave mass out"):
        laplacian(ring, operator=name, mass="voronoi")
    with pytest.raises(UnknownChoice, match=f"weights of the operator {OPERATORS[name].__name__!r} are one over"):
        laplacian(ring, operator=OPERATORS[name], mass="voronoi")


@pytest.mark.parametrize("name", OPERATORS)
def test_the_unit_of_the_mass_is_what_the_mass_does_when_the_mesh_is_scaled(name, rough):
    own, doubled = (laplacian(rough.with_vertices(by * rough.vertices), operator=name) for by in (1, 2))
    factor = {"area": 4, "length": 2, "number": 1}[own.mass_unit]
    assert doubled.mass.sum() == pytest.approx(factor * own.mass.sum(), rel=1e-9)


@pytest.mark.parametrize("mass", MASSES)
def test_masses_sum_to_the_area_and_replace_the_operators_own(mass, rough):
    L = laplacian(rough, operator="random_walk", mass=mass)
    assert abs(L.mass.sum() / rough.area - 1) < 1e-13  # a thousand areas summed
    assert (L.mass.data > 0).all()
    assert abs(L.mass - L.mass.T).max() == 0


@pytest.mark.parametrize("name", OPERATORS)
def test_over_the_unit_of_weights_masses_are_areas_and_weights_have_no_unit(name, rough):
    one, ten = (laplacian(rough.with_vertices(s * rough.vertices), operator=name) for s in (1.0, 10.0))
    unit, unit_of_ten = one.weight_unit, ten.weight_unit
    assert abs(ten.stiffness / unit_of_ten - one.stiffness / unit).max() < 1e-9 * abs(one.stiffness / unit).max()
    if name != "random_walk":
        assert (ten.mass / unit_of_ten).sum() == pytest.approx(100 * (one.mass / unit).sum())
        assert (one.mass / unit).sum() == pytest.approx(rough.area, rel=0.5)


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("size", [1e16, 3.4e38])  # the largest number of single precision marks missing points
def test_an_unused_vertex_far_away_has_no_influence(operator, size):
    mesh = sphere(2)
    for first in (0, 1):
        far = [[size, 0, 0]]
        V = np.concatenate([far, mesh.vertices] if first else [mesh.vertices, far])
        found = laplacian(Mesh(V, mesh.faces + first), operator=operator)
        expected = laplacian(mesh, operator=operator)
        used = slice(first, first + len(mesh.vertices))
        # heat_kernel sums in another order
        assert abs(found.stiffness[used, used] - expected.stiffness).max() < 1e-12 * abs(expected.stiffness).max()
        assert np.array_equal(found.mass[used, used].toarray(), expected.mass.toarray())
        assert len(found.treated_vertices) == 0
