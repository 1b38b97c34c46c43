"""No NaN or infinity leaves an operator: triangles without area, without angles, without edges, named twice."""

import igl
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lbskel import Mesh, MeshError, PointCloud
from lbskel.operators import MASSES, OPERATORS, POINT_OPERATORS, PolygonMesh, laplacian
from lbskel.operators.intrinsic_triangulation import half_edge_twins
from lbskel.shapes import sphere

PLACES = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [0.3, 0.1, 0.7]])


def finite(L):
    return np.isfinite(L.stiffness.data).all() and np.isfinite(L.mass.data).all() and (L.mass.data >= -1e-300).all()


@st.composite
def positions(draw):
    """Up to nine points: on top of each other, in a line, in a plane, a hair apart, of any size."""
    places = draw(st.lists(st.sampled_from(range(len(PLACES))), min_size=3, max_size=9))
    hairs = draw(st.lists(st.sampled_from([0.0, 1e-3, 1e-8, 1e-12, 1e-16, 1e-30, 1e-300]), min_size=9, max_size=9))
    seed, size = draw(st.integers(0, 10)), draw(st.sampled_from([1.0, 1e-100, 1e-12, 1e12, 1e100]))
    directions = np.random.default_rng(seed).normal(size=(9, 3))
    V = PLACES[places] + np.array(hairs[: len(places)])[:, None] * directions[: len(places)]
    flat = draw(st.sampled_from([np.ones(3), np.array([1, 1, 0]), np.array([1, 0, 0]), np.array([1, 1e-9, 1e-14])]))
    return size * V * flat


@st.composite
def meshes(draw):
    """Faces between any of these points: some name a vertex twice, some come twice."""
    V = draw(positions())
    index = st.integers(0, len(V) - 1)
    return Mesh(V, draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=12)))


@st.composite
def closed_meshes(draw):
    """A closed surface of 42 vertices squeezed and pinched."""
    ball = sphere(1)
    powers = st.sampled_from([1.0, 1e-3, 1e-7, 1e-11, 1e-15, 0.0])
    V = ball.vertices * [draw(powers), draw(powers), draw(powers)]
    pinched = draw(st.lists(st.integers(0, 41), max_size=20))
    V[pinched] = V[draw(st.integers(0, 41))] + draw(powers) * V[pinched]
    return Mesh(V + draw(st.sampled_from([0.0, 1.0, 1e6])), ball.faces)


NEEDLE = Mesh([[0, 0, 0], [1, 0, 0], [1, 1e-17, 0]], [[0, 1, 2]])
CAP = Mesh([[0.1, 0.1, 0.3], [0.2, 0.2, 0.6], [0.3, 0.3, 0.9]], [[0, 1, 2]])
HAIR = Mesh([[2e-300, 2e-300, -1e-300], [0, 0, 1e-300], [0, -2, 2]], [[0, 1, 2]])
POINT = Mesh(np.ones((3, 3)), [[0, 1, 2], [2, 1, 0]])
TWICE = Mesh(np.eye(3), [[0, 1, 2], [0, 1, 2], [0, 0, 1], [2, 2, 2]])
NOTHING = Mesh(np.zeros((3, 3)), [[0, 0, 0]])


@pytest.mark.parametrize("name", OPERATORS)
@settings(max_examples=60, deadline=None)
@given(mesh=meshes() | closed_meshes())
@example(mesh=NEEDLE)
@example(mesh=CAP)
@example(mesh=HAIR)
@example(mesh=POINT)
@example(mesh=TWICE)
@example(mesh=NOTHING)
def test_operators_of_meshes_stay_finite(name, mesh):
    if name == "intrinsic_delaunay" and half_edge_twins(igl.bfs_orient(mesh.faces)[0]) is None:
        with pytest.raises(MeshError, match="use the operator 'robust'"):
            laplacian(mesh, operator=name)
        return
    L = laplacian(mesh, operator=name)
    assert finite(L)
    assert np.isfinite(L.delta(mesh.vertices / np.abs(mesh.vertices).max(initial=1.0))).all()
    assert np.isin(L.treated_vertices, mesh.faces).all()


@pytest.mark.parametrize("mass", MASSES)
@settings(max_examples=30, deadline=None)
@given(mesh=meshes())
def test_masses_stay_finite_and_are_the_area(mass, mesh):
    M = MASSES[mass](mesh)
    assert np.isfinite(M.data).all()
    unit = np.abs(mesh.vertices).max(initial=1e-300)
    area = mesh.with_vertices(mesh.vertices / unit).area * unit**2
    # libigl's Voronoi pieces come from lengths, whose rounding is the square root of that of an area near zero
    assert abs(M.sum() - area) <= 1e-7 * len(mesh.faces) * unit**2


@pytest.mark.parametrize("name", POINT_OPERATORS)
@settings(max_examples=60, deadline=None)
@given(points=positions() | closed_meshes().map(lambda mesh: mesh.vertices))
def test_operators_of_points_stay_finite(name, points):
    assert finite(laplacian(PointCloud(points), operator=name))


@settings(max_examples=60, deadline=None)
@given(points=positions(), data=st.data())
def test_operators_of_polygons_stay_finite(points, data):
    index = st.integers(0, len(points) - 1)
    polygons = data.draw(st.lists(st.lists(index, min_size=3, max_size=6), min_size=1, max_size=5))
    assert finite(laplacian(PolygonMesh(points, polygons)))


def test_a_polygon_that_would_take_area_from_a_corner_shares_it_out_evenly():
    """Three corners of this pentagon lie nearly in a line, the rest is folded over them."""
    dented = [[0.589, 0.631, 1.172], [-0.419, -0.378, -0.547], [-2.062, -0.217, 1.048], [-1.698, -0.251, 0.68]]
    V = np.array([*dented, [-0.954, -0.494, -0.399], [3.0, 0, 0], [3, 2, 0]])
    pentagon, triangle = [0, 1, 2, 3, 4], [0, 5, 6]
    theirs = igl.cotmatrix(V, np.arange(5), np.array([0, 5]))[1].diagonal()
    assert theirs.min() < 0
    areas = laplacian(PolygonMesh(V, [pentagon, triangle])).mass.diagonal()
    assert areas[1:5] == pytest.approx(theirs.sum() / 5, rel=1e-9)
    assert areas[0] > areas[1]  # the triangle's besides
    assert laplacian(PolygonMesh(V, [triangle])).mass.diagonal()[5] == areas[5]


def test_the_degenerate_are_listed():
    for name in ("cotangent", "clamped_cotangent", "cotangent_identity", "mean_value", "intrinsic_delaunay", "robust"):
        for mesh in (POINT, CAP):
            assert laplacian(mesh, operator=name).treated_vertices.tolist() == [0, 1, 2], name
    assert laplacian(PolygonMesh(CAP.vertices, CAP.faces)).treated_vertices.tolist() == [0, 1, 2]
    assert laplacian(PointCloud(CAP.vertices), operator="local_delaunay").treated_vertices.tolist() == [0, 1, 2]


def test_the_mollified_operators_reach_across_triangles_without_area():
    """A closed surface flattened to a line keeps one null vector: the guard makes it longer, not fewer."""
    ball = sphere(1)
    line = ball.with_vertices(ball.vertices * [1, 0, 0])
    for name in ("intrinsic_delaunay", "robust"):
        S = laplacian(line, operator=name).stiffness.toarray()
        eigenvalues = np.linalg.eigvalsh(S)
        # thin triangles are a millionth as wide as long, and eigenvalues are rounded at 1e-15
        assert eigenvalues[1] > 1e-11 * eigenvalues[-1]
        assert len(laplacian(line, operator=name).treated_vertices) == 42
    assert np.linalg.eigvalsh(laplacian(ball).stiffness.toarray())[1] > 1e-3


def test_coordinates_whose_areas_overflow_are_refused():
    with np.errstate(over="ignore"), pytest.raises(MeshError, match="scale its coordinates"):
        laplacian(sphere(0).with_vertices(1e200 * sphere(0).vertices))
