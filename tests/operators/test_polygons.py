"""Polygon meshes: their checks, and their Laplacian against fans written out, planes and spheres."""

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from operator_shapes import is_finite, positions

from lbskel import Mesh, MeshError
from lbskel.operators import PolygonMesh, laplacian


def test_polygon_meshes_are_checked():
    with pytest.raises(MeshError, match="polygons 1 need at least three"):
        PolygonMesh(np.eye(3), [[0, 1, 2], [0, 1]])
    with pytest.raises(MeshError, match="polygons 0 use a vertex index outside 0\\.\\.2"):
        PolygonMesh(np.eye(3), [[0, 1, 3]])
    with pytest.raises(MeshError, match="NaN or infinite"):
        PolygonMesh([[0, 0, 0], [1, 0, np.nan], [1, 1, 0]], [[0, 1, 2]])
    for polygon in ([0, 0.9, 2], ["a", "b", "c"], [0, [1, 2]], None, [0, np.nan, 1]):
        with pytest.raises(MeshError, match="polygon 1 must be a list of whole numbers"):
            PolygonMesh(np.eye(3), [[0, 1, 2], polygon])
    with pytest.raises(MeshError, match="sequence of sequences"):
        PolygonMesh(np.eye(3), None)
    with pytest.raises(MeshError, match="no polygon"):
        PolygonMesh(np.eye(3), [])


def test_polygon_meshes_are_read_only():
    mesh = PolygonMesh(np.eye(3), [[0, 1, 2]])
    for array in (mesh.vertices, mesh.polygons[0], mesh.corners, mesh.starts):
        assert not array.flags.writeable


def test_a_polygon_that_uses_a_vertex_twice_is_left_out():
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    whole, alone = (laplacian(PolygonMesh(square, faces)) for faces in ([[0, 1, 2], [0, 1, 3, 1]], [[0, 1, 2]]))
    assert abs(whole.stiffness - alone.stiffness).max() == 0
    assert whole.treated_vertices.tolist() == [0, 1, 3]


def test_polygons_of_three_corners_are_triangles(mesh):
    ours = laplacian(PolygonMesh(mesh.vertices, mesh.faces)).stiffness
    expected = laplacian(mesh).stiffness
    assert abs(ours - expected).max() < 1e-12 * abs(expected).max()


def test_polygons_are_the_fan_around_the_virtual_point():
    V = np.random.default_rng(7).normal(size=(9, 3))
    polygons = [[0, 1, 2, 3], [3, 2, 4, 5, 6], [0, 3, 6, 7, 8, 1]]
    expected = np.zeros((9, 9))
    for polygon in polygons:
        X = V[polygon]
        k = len(X)
        # smallest sum of |x_i - p| x (x_i+1 - p)|^2 over p = X^T w with sum w = 1
        to_next = np.roll(X, -1, axis=0) - X
        C = np.cross(X[:, None], to_next[None])
        A, b = np.einsum("ikx,jkx->ij", C, C), np.einsum("ikx,kx->i", C, np.cross(X, to_next))
        bordered = np.block([[A, np.ones((k, 1))], [np.ones((1, k)), np.zeros((1, 1))]])
        w = np.linalg.lstsq(bordered, np.append(b, 1), rcond=None)[0][:k]
        fan = np.array([[i, (i + 1) % k, k] for i in range(k)])
        P = np.vstack([np.eye(k), w])
        refined = Mesh(P @ X, fan)
        expected[np.ix_(polygon, polygon)] += P.T @ laplacian(refined).stiffness.toarray() @ P
    ours = laplacian(PolygonMesh(V, polygons)).stiffness.toarray()
    # another least-squares solver inside libigl
    assert np.abs(ours - expected).max() < 1e-10 * np.abs(expected).max()


def test_quads_of_a_plane_and_of_a_sphere():
    n = 12
    random = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    V = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    V[:, :2] += random.uniform(-0.02, 0.02, (n * n, 2))
    corner = np.arange(n * n).reshape(n, n)
    quads = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1).reshape(-1, 4)
    L = laplacian(PolygonMesh(V, quads))
    inner = corner[1:-1, 1:-1].ravel()
    assert np.abs((L.stiffness @ V)[inner]).max() < 1e-13
    assert np.linalg.eigvalsh(L.stiffness.toarray())[1] > 1e-3
    # a cube of quads projected to a sphere: 6 x 24 x 24 faces, h = 0.07
    side = np.tan(np.linspace(-np.pi / 4, np.pi / 4, 25))
    u, v = (axis.ravel() for axis in np.meshgrid(side, side, indexing="ij"))
    patches = [np.roll(np.column_stack([s * np.ones_like(u), u, v]), k, axis=1) for k in range(3) for s in (-1, 1)]
    points = np.concatenate([patch / np.linalg.norm(patch, axis=1, keepdims=True) for patch in patches])
    grid = np.arange(625).reshape(25, 25)
    cell = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([cell + 625 * k for k in range(6)])
    merged, inverse = np.unique(points.round(12), axis=0, return_inverse=True)
    L = laplacian(PolygonMesh(merged, inverse.reshape(-1)[faces]))
    assert abs(L.mass.sum() / (4 * np.pi) - 1) < 0.005
    for values, eigenvalue in ((merged[:, 0], 2), (merged[:, 0] * merged[:, 1], 6)):
        quotient = values @ (L.stiffness @ values) / (values @ (L.mass @ values))
        assert abs(quotient / eigenvalue - 1) < 0.01


def test_polygons_have_the_same_laplacian_wherever_they_lie():
    """A bent pentagon and a quad: at 1e6 sizes the masses were off by several percent."""
    V = np.array([[0, 0, 0], [1, 0, 0.2], [1.5, 1, 0], [0.5, 1.8, 0.3], [-0.5, 1, 0], [2, 0, 0], [2.5, 1, 0.1]])
    polygons = [[0, 1, 2, 3, 4], [1, 5, 6, 2]]
    here, there = (laplacian(PolygonMesh(points, polygons)) for points in (V, V + [1e6, -1e6, 3e5]))
    # a coordinate of 1e6 has an error of 1e-10
    assert abs(there.stiffness - here.stiffness).max() < 1e-8
    assert abs(there.mass - here.mass).max() < 1e-8


@settings(max_examples=60)
@given(points=positions(), data=st.data())
def test_operators_of_polygons_stay_finite(points, data):
    index = st.integers(0, len(points) - 1)
    polygons = data.draw(st.lists(st.lists(index, min_size=3, max_size=6), min_size=1, max_size=5))
    assert is_finite(laplacian(PolygonMesh(points, polygons)))


def test_the_area_of_a_polygon_with_a_negative_corner_area_is_divided_evenly():
    """Three corners of this pentagon lie nearly in a line, the rest is folded over them."""
    dented = [[0.589, 0.631, 1.172], [-0.419, -0.378, -0.547], [-2.062, -0.217, 1.048], [-1.698, -0.251, 0.68]]
    V = np.array([*dented, [-0.954, -0.494, -0.399], [3.0, 0, 0], [3, 2, 0]])
    pentagon, triangle = [0, 1, 2, 3, 4], [0, 5, 6]
    theirs = igl.cotmatrix(V, np.arange(5), np.array([0, 5]))[1].diagonal()
    assert theirs.min() < 0
    areas = laplacian(PolygonMesh(V, [pentagon, triangle])).mass.diagonal()
    assert areas[1:5] == pytest.approx(theirs.sum() / 5, rel=1e-9)
    assert areas[0] > areas[1]  # and its part of the triangle
    assert laplacian(PolygonMesh(V, [triangle])).mass.diagonal()[5] == pytest.approx(areas[5], rel=1e-12)


def test_the_mass_of_a_concave_polygon_is_that_of_its_fan_whose_triangles_may_overlap():
    ell = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]]
    u = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [2, 3, 0], [2, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0]]
    masses = [laplacian(PolygonMesh(corners, [range(len(corners))])).mass.sum() for corners in (ell, u)]
    assert masses == pytest.approx([3, 9])  # of areas 3 and 7


def test_areas_are_in_the_units_of_the_caller_and_degenerate_polygons_have_none():
    V = [[0, 0, 0], [40, 0, 0], [40, 40, 0], [0, 40, 0], [80, 0, 0], [60, 0, 0]]
    L = laplacian(PolygonMesh(V, [[0, 1, 2, 3], [1, 5, 4]]))
    assert L.mass.diagonal() == pytest.approx([400, 400, 400, 400, 0, 0])
    assert L.stiffness.toarray()[:4, :4] == pytest.approx(np.eye(4) - 1 / 4)
    assert L.treated_vertices.tolist() == [1, 4, 5]


@pytest.mark.parametrize("moved", [0.0, 30.0, 1000.0])
@pytest.mark.parametrize("sides", [3, 4])
def test_a_polygon_on_a_line_is_left_out_wherever_it_is(sides, moved):
    n = 12
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    squares = np.stack([first, first + 1, first + n + 1, first + n], axis=1).tolist()
    line = [3 * n, 3 * n + 1, 4 * n - 1, 3 * n + 4][:sides]
    for seed in range(10):
        turned = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        V = np.array([[x, y, 0.0] for y in range(n) for x in range(n)]) @ turned + moved
        L, without = (laplacian(PolygonMesh(V, polygons)) for polygons in ([*squares, line], squares))
        assert L.treated_vertices.tolist() == sorted(line)
        assert abs(L.stiffness - without.stiffness).max() == 0
