"""Formulas against cases that can be worked out by hand: planes, regular rings, spheres, cylinders, tori."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from lbskel import Mesh, PointCloud
from lbskel.operators import OPERATORS, POINT_OPERATORS, PolygonMesh, laplacian
from lbskel.operators.anisotropic import anisotropic, shape_operators
from lbskel.operators.heat_kernel import heat_kernel
from lbskel.operators.local_delaunay import delaunay_stars
from lbskel.shapes import cylinder, flat_grid, sphere, torus

NOT_LINEAR_ON_A_PLANE = ["graph", "random_walk", "inverse_distance", "mean_value_symmetric", "heat_kernel"]
LINEAR_ON_A_PLANE = ["cotangent", "cotangent_identity", "mean_value", "intrinsic_delaunay", "robust", "anisotropic"]


def scattered_plane(n=17, seed=0):
    """An irregular triangulation of a square in a tilted plane, its points in that plane, and its inner vertices."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n) / (n - 1), np.arange(n) / (n - 1), indexing="ij")
    P = np.stack([x, y], axis=-1)
    P[1:-1, 1:-1] += random.uniform(-0.4, 0.4, (n - 2, n - 2, 2)) / n
    P = P.reshape(-1, 2)
    F = Delaunay(P).simplices
    turned = np.linalg.qr(random.normal(size=(3, 3)))[0]
    mesh = Mesh(np.column_stack([P, np.zeros(len(P))]) @ turned, F)
    rim = mesh.edges[mesh.faces_per_edge == 1]
    return mesh, P, np.setdiff1d(np.arange(len(P)), rim)


def hexagons(n=9, edge=0.1):
    """Equilateral triangles in the plane, and the vertices more than four rings inside."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    V = edge * np.column_stack([i - 0.5 * j, np.sqrt(0.75) * j, np.zeros(n * n)])
    inner = (np.minimum(i, j) >= 4) & (np.maximum(i, j) < n - 4)
    return Mesh(V, flat_grid(n, n).faces), inner


@pytest.mark.parametrize("name", LINEAR_ON_A_PLANE + NOT_LINEAR_ON_A_PLANE)
def test_linear_functions_of_a_plane(name):
    mesh, P, inner = scattered_plane()
    S = laplacian(mesh, operator=name).stiffness
    error = np.abs(S @ P)[inner].max(axis=1) / (np.abs(S) @ np.ones(len(P)))[inner]
    if name in LINEAR_ON_A_PLANE:
        assert error.max() < 1e-14  # coordinates rounded at 1e-16, magnified by the thinnest triangles
    else:
        assert error.max() > 1e-3


def test_a_clamped_angle_costs_linear_precision():
    V = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-3, 0], [0.5, -1, 0], [0.5, 1, 0]])
    mesh = Mesh(V, [[0, 3, 2], [3, 1, 2], [1, 4, 2], [4, 0, 2]])
    inner = laplacian(mesh, operator="cotangent").stiffness[[2]] @ V
    assert np.abs(inner).max() < 1e-12
    clamped = OPERATORS["clamped_cotangent"](mesh, angle_tolerance=np.radians(50)).stiffness[[2]] @ V
    assert np.abs(clamped).max() > 1e-3


@pytest.mark.parametrize(
    "name", ["inverse_distance", "cotangent", "mean_value", "mean_value_symmetric", "intrinsic_delaunay", "robust"]
)
def test_the_laplacian_of_a_quadratic_on_regular_rings(name):
    """Of 3 x^2 + x y - y^2 it is 4, so -4 with our sign: rings of six are exact for quadratics."""
    mesh, inner = hexagons()
    x, y, _ = mesh.vertices.T
    found = laplacian(mesh, operator=name).delta(3 * x**2 + x * y - y**2)[inner]
    assert np.abs(found + 4).max() < 1e-12 / 0.1**2  # rounding of the values over the square of the edge


def test_mean_value_weights_and_their_mass_on_regular_rings():
    mesh, inner = hexagons(edge=0.1)
    L = laplacian(mesh, operator="mean_value")
    weight = 2 * np.tan(np.pi / 6) / 0.1
    row = L.stiffness.tocsr()[[int(np.flatnonzero(inner)[0])]].toarray().ravel()
    assert np.allclose(np.sort(row)[:6], -weight, rtol=1e-12)
    assert np.allclose(L.mass.diagonal()[inner], 6 * weight * 0.1**2 / 4, rtol=1e-12)


def test_the_graph_and_the_heat_kernel_on_regular_rings():
    mesh, inner = hexagons(41, 0.05)
    x, y, _ = mesh.vertices.T
    values, middle = 3 * x**2 + x * y - y**2, 20 * 41 + 20
    assert inner[middle]
    # six unit weights at distance h give 3/2 h^2, the area is sqrt(3)/2 h^2
    assert abs(laplacian(mesh, operator="graph").delta(values)[middle] + 4 * np.sqrt(3)) < 1e-9
    # the random walk has no length: 1/4 h^2
    assert abs(laplacian(mesh, operator="random_walk").delta(values)[middle] + 4 * 0.05**2 / 4) < 1e-12
    # the sum over a lattice is the integral up to exp(-(2 pi / h)^2 t), and what lies beyond the cut-off is known
    for time, cut_off in ((2.0, 4.0), (4.0, 3.0)):
        found = heat_kernel(mesh, time=time, cut_off=cut_off).delta(values)[middle]
        assert abs(found / -4 - 1) < 0.02  # the rim of a disc of 10 edges is counted to about one in fifty


def test_the_kernels_cut_off_is_made_up_for():
    mesh, _ = hexagons(41, 0.02)
    x, y, _ = mesh.vertices.T
    middle = 20 * 41 + 20
    wide, narrow = (heat_kernel(mesh, time=4.0, cut_off=c).delta(x**2 + y**2)[middle] for c in (5.0, 2.0))
    assert abs(wide / -4 - 1) < 2e-3
    assert abs(narrow / -4 - 1) < 0.05  # a disc of radius 5.7 edges: its rim is counted to one in twenty
    kept = 1 - 3 * np.exp(-2)  # of |x|^2 within two standard deviations
    assert abs(narrow * kept / -4 - 1) > 0.3


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


def test_shape_operators_of_a_torus():
    R, r = 1.0, 0.4
    K = shape_operators(torus(R, r, 300, 120)) / 2  # the longest coordinate is 1.4: scaled by one half
    mean, spread = (K[0] + K[2]) / 2, np.hypot((K[0] - K[2]) / 2, K[1])
    # 1/r across everywhere, between -1/(R - r) and 1/(R + r) along
    assert np.abs(mean + spread - 1 / r).max() < 0.01
    assert abs((mean - spread).min() + 1 / (R - r)) < 0.01
    assert abs((mean - spread).max() - 1 / (R + r)) < 0.01


def test_anisotropic_diffusion_is_damped_along_the_bend_and_nowhere_else():
    side = cylinder(1.0, 2.0, 64, 41)
    strength = 3.0
    radius = np.sqrt(side.area / (4 * np.pi))  # curvature is in units of the sphere of this area
    plain = laplacian(side).stiffness
    damped = anisotropic(side, strength=strength).stiffness
    x, _, z = side.vertices.T
    along, around = z @ damped @ z / (z @ plain @ z), x @ damped @ x / (x @ plain @ x)
    assert abs(along - 1) < 0.01  # normals at the open rims lean by the half of an edge
    assert abs(around - 1 / (1 + strength * radius)) < 0.01
    assert abs(anisotropic(side, strength=0.0).stiffness - plain).max() < 1e-13


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
    # a cube of quads blown up to a sphere: 6 x 24 x 24 faces, h = 0.07
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


def fibonacci_sphere(n):
    """Points spread evenly over the unit sphere."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])


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


def test_stars_are_those_of_delaunay_triangulations():
    P = fibonacci_sphere(300) + 0.03 * np.random.default_rng(0).normal(size=(300, 3))
    stars = delaunay_stars(P, 20)
    for i in range(0, 300, 7):
        near = np.argsort(np.linalg.norm(P - P[i], axis=1), kind="stable")[:20]
        centered = P[near] - P[near].mean(axis=0)
        plane = np.linalg.svd(centered)[2][:2]
        simplices = near[Delaunay((P[near] - P[i]) @ plane.T).simplices]
        expected = {frozenset(s) for s in simplices.tolist() if i in s}
        assert {frozenset(s) for s in stars[stars[:, 0] == i].tolist()} == expected


def test_stars_of_a_grid_have_its_four_neighbors_and_weights_one():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij"))
    L = laplacian(PointCloud(np.column_stack([x, y, np.zeros(49)])), operator="local_delaunay")
    row = L.stiffness.tocsr()[[24]].toarray().reshape(7, 7)
    expected = np.zeros((7, 7))
    expected[3, 2:5], expected[2:5, 3], expected[3, 3] = -1, -1, 4
    assert np.abs(row - expected).max() < 1e-12
    assert abs(L.mass.diagonal()[24] - 1) < 1e-12


def test_stars_serve_again_for_points_that_have_moved():
    P = fibonacci_sphere(200)
    local = POINT_OPERATORS["local_delaunay"]
    first = local(PointCloud(P))
    from lbskel.operators.points import cloud_stars

    again = local(PointCloud(P * [1, 1, 0.5]), stars=cloud_stars(PointCloud(P)))
    assert ((abs(first.stiffness).sign() - abs(again.stiffness).sign()).nnz) == 0
    assert abs(first.stiffness - again.stiffness).max() > 0.1
