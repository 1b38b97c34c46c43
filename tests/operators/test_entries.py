"""Our own entries against libigl's, robust_laplacian's and sums written out, one by one."""

import igl
import numpy as np
import pytest
import robust_laplacian

from lbskel import Mesh
from lbskel.operators import OPERATORS, PolygonMesh, laplacian
from lbskel.operators.corner_angles import corner_cotangents
from lbskel.operators.intrinsic_triangulation import (
    IntrinsicTriangulation,
    cotangents_of_lengths,
    delaunay,
    half_edge_twins,
)
from lbskel.operators.masses import MASSES
from lbskel.shapes import make, sphere, torus

RANDOM = np.random.default_rng(7)


def soup(n_faces=400):
    """Triangles with random corners: some obtuse, some thin, edges with many faces."""
    F = np.array([RANDOM.choice(60, 3, replace=False) for _ in range(n_faces)])
    return Mesh(RANDOM.normal(size=(60, 3)), F)


def real():
    return make("dinosaur", n_vertices=1500).mesh


def distorted():
    mesh = torus(1.0, 0.4, 30, 15)
    return mesh.with_vertices(mesh.vertices + 0.02 * RANDOM.normal(size=mesh.vertices.shape))


MESHES = {"soup": soup(), "real": real(), "distorted": distorted(), "sphere": sphere(2)}


@pytest.fixture(params=MESHES)
def mesh(request):
    return MESHES[request.param]


def test_corner_cotangents(mesh):
    ours, theirs = corner_cotangents(mesh), 2 * igl.cotmatrix_entries(mesh.vertices, mesh.faces)
    # libigl takes the area from the lengths, whose rounding grows with the square of the cotangent
    assert (np.abs(ours - theirs) <= 1e-14 * (1 + ours.max(axis=1, keepdims=True) ** 2)).all()


def test_corner_cotangents_where_the_angle_is_known():
    for degrees in (1e-3, 0.1, 30, 60, 90, 120, 179, 179.999):
        angle = np.radians(degrees)
        # a long and a short edge at the corner, off the axes so that coordinates are rounded
        turned = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        V = np.array([[0, 0, 0], [1, 0, 0], [0.3 * np.cos(angle), 0.3 * np.sin(angle), 0]]) @ turned
        found = corner_cotangents(Mesh(V, [[0, 1, 2]]))[0, 0]
        # the angle between points rounded at 1e-16 is known to 1e-15 or so
        assert abs(np.arctan2(1, found) - angle) < 1e-15 * (1 + abs(angle)) * 4


def test_cotangent_stiffness(mesh):
    ours, theirs = laplacian(mesh).stiffness, -igl.cotmatrix(mesh.vertices, mesh.faces)
    assert abs(ours - theirs).max() < 1e-12 * abs(theirs).max()


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


def test_clamped_cotangents_are_those_of_the_angles_clamped():
    mesh, tolerance = MESHES["soup"], np.radians(25)
    angles = np.clip(igl.internal_angles(mesh.vertices, mesh.faces), tolerance, np.pi - tolerance)
    expected = np.zeros((60, 60))
    for face, corners in zip(mesh.faces, 1 / np.tan(angles), strict=True):
        for k in range(3):
            i, j = face[(k + 1) % 3], face[(k + 2) % 3]
            expected[[i, j], [j, i]] -= corners[k] / 2
            expected[[i, j], [i, j]] += corners[k] / 2
    ours = OPERATORS["clamped_cotangent"](mesh, angle_tolerance=tolerance)
    assert np.abs(ours.stiffness.toarray() - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["mean_value", "mean_value_symmetric"])
def test_mean_value_weights_are_those_of_the_angles(mesh, name):
    n, V = len(mesh.vertices), mesh.vertices
    W = np.zeros((n, n))
    for face, angles in zip(mesh.faces, igl.internal_angles(V, mesh.faces), strict=True):
        for k in range(3):
            i = face[k]
            for j in (face[(k + 1) % 3], face[(k + 2) % 3]):
                W[i, j] += np.tan(angles[k] / 2) / np.linalg.norm(V[i] - V[j])
    if name == "mean_value_symmetric":
        W = (W + W.T) / 2
    assert np.abs(laplacian(mesh, operator=name).stiffness - (np.diag(W.sum(axis=1)) - W)).max() < 1e-12 * W.max()


@pytest.mark.parametrize("name", ["real", "distorted", "sphere"])
def test_intrinsic_delaunay_is_libigls_where_that_ends(name):
    mesh = MESHES[name]
    ours = laplacian(mesh, operator="intrinsic_delaunay").stiffness
    theirs = -igl.intrinsic_delaunay_cotmatrix(mesh.vertices, mesh.faces)[0]
    # lengths of flipped edges come from different formulas
    assert abs(ours - theirs).max() < 1e-10 * abs(theirs).max()
    tufted = robust_laplacian.mesh_laplacian(np.array(mesh.vertices), np.array(mesh.faces), mollify_factor=0)[0]
    assert abs(ours - tufted).max() < 1e-10 * abs(tufted).max()
    if name != "sphere":
        assert abs(ours - laplacian(mesh).stiffness).max() > 0.01


def test_flips_leave_no_edge_that_is_not_delaunay_and_keep_the_area():
    V = RANDOM.normal(size=(200, 3))
    F = np.ascontiguousarray(sphere(2).faces[:, ::-1])
    V = np.concatenate([V, V])[: F.max() + 1] * [1, 1e-3, 1]  # thin and folded, far from Delaunay
    lengths = igl.edge_lengths(V, F)
    found = delaunay(IntrinsicTriangulation(F, lengths, half_edge_twins(F)))
    cotangents = cotangents_of_lengths(found.lengths).ravel()
    sums = cotangents + cotangents[found.twins]
    # the flips stop where the sum is negative by no more than 1e-9 of the cotangents
    assert (sums >= -1e-9 * (1 + 2 * np.abs(cotangents) + np.abs(sums))).all()
    assert (
        cotangents_of_lengths(lengths).ravel() + cotangents_of_lengths(lengths).ravel()[half_edge_twins(F)]
    ).min() < -1
    assert (found.lengths.ravel() == found.lengths.ravel()[found.twins]).all()
    assert (found.twins[found.twins] == np.arange(len(found.twins))).all()
    area = np.linalg.norm(np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), axis=1).sum() / 2
    # areas by Heron's formula of triangles as thin as 1e-3 keep about ten digits
    assert abs(igl.doublearea(found.lengths, 0.0).sum() / 2 / area - 1) < 1e-9


def test_polygons_of_three_corners_are_triangles(mesh):
    ours = laplacian(PolygonMesh(mesh.vertices, mesh.faces)).stiffness
    expected = laplacian(mesh).stiffness
    assert abs(ours - expected).max() < 1e-12 * abs(expected).max()


def test_polygons_are_the_fan_around_the_virtual_point():
    V = RANDOM.normal(size=(9, 3))
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
