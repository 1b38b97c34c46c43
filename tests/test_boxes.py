"""The tree of boxes: what is nearest and what a ray meets first, against every triangle in turn."""

import igl
import numpy as np
import pytest

from lbskel import Mesh
from lbskel.shapes import make, torus


def rays(mesh, k, seed=0):
    rng = np.random.default_rng(seed)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    ways = rng.normal(size=(k, 3))
    return low + (high - low) * rng.random((k, 3)), ways / np.linalg.norm(ways, axis=1, keepdims=True)


def met(mesh, origin, way):
    """How far on each triangle is met by a ray, from the volumes that it makes with the triangle's edges."""
    A, B, C = (mesh.vertices[mesh.faces[:, corner]] - origin for corner in range(3))
    volumes = np.stack([np.cross(P, Q) @ way for P, Q in ((B, C), (C, A), (A, B))])
    normal = np.cross(B - A, C - A)
    far = np.einsum("fi,fi->f", normal, A) / (normal @ way)
    return np.where(((volumes > 0).all(axis=0) | (volumes < 0).all(axis=0)) & (far >= 0), far, np.inf)


@pytest.mark.parametrize("name", ["knot", "octopus"])
def test_the_nearest_place_is_that_of_libigl(name):
    mesh = make(name, n_vertices=3000).mesh
    points = np.concatenate([rays(mesh, 400)[0], mesh.vertices[::50], mesh.vertices[:5]])
    distance, place = mesh.boxes.nearest(points)
    squared = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)[0]
    assert np.abs(distance - np.sqrt(squared)).max() < 1e-12 * mesh.extent
    assert np.abs(np.linalg.norm(place - points, axis=1) - distance).max() < 1e-12 * mesh.extent


def test_what_is_near_is_nearer_than_the_distance():
    mesh = make("knot", n_vertices=800).mesh
    points = rays(mesh, 300)[0]
    distance = mesh.boxes.nearest(points)[0]
    for limit in np.quantile(distance, [0.1, 0.5, 0.9]) * 1.0001:
        assert np.array_equal(mesh.boxes.are_near(points, limit), distance < limit)


def test_the_nearest_place_is_on_a_corner_an_edge_or_inside():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    points = np.array([[-1, -1, 1], [0.5, -2, 0], [2, 2, 0], [0.2, 0.2, 3], [0, 0, 0], [3, -1, 0.0]])
    distance, place = mesh.boxes.nearest(points)
    assert np.allclose(place, [[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0.2, 0.2, 0], [0, 0, 0], [1, 0, 0]], atol=1e-15)
    assert np.allclose(distance, np.linalg.norm(points - place, axis=1), atol=1e-15)


@pytest.mark.parametrize("size", [2.0**200, 2.0**-200])
def test_what_is_nearest_does_not_depend_on_size(size):
    mesh = make("knot", n_vertices=800).mesh
    points = rays(mesh, 50)[0]
    distance, place = mesh.boxes.nearest(points)
    sized = mesh.with_vertices(size * mesh.vertices).boxes.nearest(size * points)
    assert np.array_equal(sized[0], size * distance)
    assert np.array_equal(sized[1], size * place)


def test_faces_without_area_are_near_too():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], [[0, 1, 2], [3, 3, 3]])
    distance, place = mesh.boxes.nearest(np.array([[1.5, 1, 0], [6, 5, 5.0]]))
    assert np.allclose(distance, [1, 1])
    assert np.allclose(place, [[1.5, 0, 0], [5, 5, 5]])


def test_a_ray_meets_what_the_nearest_of_all_triangles_it_meets_is():
    mesh = make("octopus", n_vertices=3000).mesh
    origins, ways = rays(mesh, 300)
    face, far = mesh.boxes.first_hits(origins, ways)
    every = np.array([met(mesh, origin, way) for origin, way in zip(origins, ways, strict=True)])
    nearest = every.min(axis=1)
    assert 30 < np.isfinite(nearest).sum() < 300
    assert np.array_equal(face >= 0, np.isfinite(nearest))
    assert np.array_equal(np.isfinite(far), np.isfinite(nearest))
    hit = face >= 0
    assert np.array_equal(face[hit], every.argmin(axis=1)[hit])
    assert far[hit] == pytest.approx(nearest[hit], rel=1e-9)


def test_rays_meet_small_faces():
    """With determinants under 1e-6, which faces of a million on a shape of size one have, libigl misses them."""
    mesh = torus(1e-3, 3e-4, 96, 32)
    origins = np.array([[1e-3, 0, 0]])
    for way in np.eye(3):
        assert np.isfinite(mesh.boxes.first_hits(origins, way[None])[1]).all()


def test_rays_along_the_axes_and_along_edges_do_not_pass_between_faces():
    n = 17
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    V = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1).astype(float)
    i = (x[:-1, :-1] * n + y[:-1, :-1]).ravel()
    mesh = Mesh(V, np.concatenate([np.stack([i, i + n, i + 1], 1), np.stack([i + n, i + n + 1, i + 1], 1)]))
    u, v = np.meshgrid(
        np.linspace(0.5, n - 1.5, 2 * n - 3), np.linspace(0.5, n - 1.5, 2 * n - 3)
    )  # on edges and corners
    origins = np.stack([u.ravel(), v.ravel(), np.full(u.size, 2.0)], axis=1)
    assert (mesh.boxes.first_hits(origins, np.tile([0, 0, -1.0], (u.size, 1)))[1] == 2).all()
    assert np.isinf(mesh.boxes.first_hits(origins, np.tile([0, 0, 1.0], (u.size, 1)))[1]).all()
