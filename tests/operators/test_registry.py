"""What every operator promises: one call, one convention; and the value that it comes in."""

from types import SimpleNamespace

import igl
import numpy as np
import pytest
from scipy.sparse import csc_array

from lbskel import Mesh, MeshError, OperatorError, PointCloud, UnknownChoice, write_mesh
from lbskel.operators import (
    MASSES,
    OPERATORS,
    POINT_OPERATORS,
    Laplacian,
    PolygonMesh,
    apply_operator,
    from_igl,
    laplacian,
    operator_named,
    to_igl,
)
from lbskel.shapes import flat_grid, schwarz_lantern, sphere, torus

NOT_SYMMETRIC = {"mean_value", "cotangent_identity"}
# Rows sum to zero up to the rounding of a few dozen entries of the size of the largest.
ROUNDING = 1e-14


def noisy(mesh, by, seed=0):
    return mesh.with_vertices(mesh.vertices + by * np.random.default_rng(seed).normal(size=mesh.vertices.shape))


@pytest.fixture(scope="module")
def rough():
    """A torus with obtuse triangles, and some with an angle below a degree: 288 vertices."""
    mesh = noisy(torus(1.0, 0.4, 24, 12), 0.05)
    V = mesh.vertices.copy()
    V[30] = 0.005 * V[30] + 0.995 * V[31]
    return mesh.with_vertices(V)


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
def test_the_operator_moves_with_the_mesh_and_scales_as_its_unit_does(name, rough):
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
    with_stray = Mesh(np.concatenate([ring.vertices, [[9.0, 9.0, 9.0]]]), ring.faces)
    L = laplacian(with_stray, operator=name)
    assert L.stiffness.shape == L.mass.shape == (129, 129)
    assert abs(L.stiffness[[128]]).sum() == 0
    assert np.isfinite(L.delta(with_stray.vertices)).all()


def test_unknown_names_are_told_with_those_that_exist(ring):
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


@pytest.mark.parametrize("mass", MASSES)
def test_masses_sum_to_the_area_and_replace_the_operators_own(mass, rough):
    L = laplacian(rough, operator="random_walk", mass=mass)
    assert abs(L.mass.sum() / rough.area - 1) < 1e-13  # a thousand areas summed
    assert (L.mass.data > 0).all()
    assert abs(L.mass - L.mass.T).max() == 0


def test_the_random_walk_is_a_vertex_less_the_mean_of_its_neighbors(tetrahedron):
    L = laplacian(tetrahedron, operator="random_walk")
    expected = np.eye(4) - (np.ones((4, 4)) - np.eye(4)) / 3
    assert np.allclose(L.strong().toarray(), expected, rtol=0, atol=1e-15)
    assert np.allclose(L.delta(tetrahedron.vertices), expected @ tetrahedron.vertices, rtol=0, atol=1e-15)


def test_mean_curvature_normals_of_a_sphere_point_outwards_and_are_as_long_as_one_over_its_radius():
    ball = sphere(4)
    H = laplacian(ball.with_vertices(2 * ball.vertices)).mean_curvature_normals(2 * ball.vertices)
    # 2,562 vertices: h = 0.07, so h^2 = 0.005; at the twelve vertices of valence five the error stays near 1 %
    assert np.abs(H - ball.vertices / 2).max() < 0.01


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


def test_guards_name_the_vertices_they_treated():
    V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [5, 0, 0], [6, 0, 0], [7, 0, 0]]
    mesh = Mesh(V, [[0, 1, 2], [1, 3, 2], [4, 5, 6]])
    for name in OPERATORS:
        L = laplacian(mesh, operator=name)
        expected = [] if name in ("graph", "random_walk", "inverse_distance", "heat_kernel") else [4, 5, 6]
        assert L.treated_vertices.tolist() == expected, name
    assert laplacian(mesh, operator="clamped_cotangent").n_clamped_angles == 3
    identity = laplacian(mesh, operator="cotangent_identity").stiffness.toarray()
    assert (identity[4:] == np.eye(7)[4:]).all()


def test_intrinsic_delaunay_takes_a_boundary_and_any_orientation_but_no_third_face():
    grid = flat_grid(5, 5)
    assert (
        abs(laplacian(grid, operator="intrinsic_delaunay").stiffness - laplacian(grid).stiffness).max() < ROUNDING * 4
    )
    ball = sphere(1)
    F = ball.faces.copy()
    F[::3] = F[::3, ::-1]
    turned = laplacian(Mesh(ball.vertices, F), operator="intrinsic_delaunay").stiffness
    assert abs(turned - laplacian(ball, operator="intrinsic_delaunay").stiffness).max() < ROUNDING * 10
    fin = Mesh(np.eye(5, 3) + 1, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(MeshError, match="use the operator 'robust'"):
        laplacian(fin, operator="intrinsic_delaunay")
    assert laplacian(fin, operator="robust").mass.sum() > 0


def test_positive_weights_where_cotangents_are_negative():
    lantern = schwarz_lantern(12, 40)
    plain, robust = (laplacian(lantern, operator=name).stiffness.toarray() for name in ("cotangent", "robust"))
    assert (plain - np.diag(plain.diagonal())).max() > 1
    assert (robust - np.diag(robust.diagonal())).max() < ROUNDING * np.abs(robust).max()


def test_polygon_meshes_are_checked():
    with pytest.raises(MeshError, match="polygons 1 need at least three"):
        PolygonMesh(np.eye(3), [[0, 1, 2], [0, 1]])
    with pytest.raises(MeshError, match="polygons 0 use a vertex index outside 0\\.\\.2"):
        PolygonMesh(np.eye(3), [[0, 1, 3]])
    with pytest.raises(MeshError, match="NaN or infinite"):
        PolygonMesh([[0, 0, 0], [1, 0, np.nan], [1, 1, 0]], [[0, 1, 2]])
