"""Bounding volume hierarchy: nearest points, ray hits and winding numbers, compared with tests of every triangle."""

import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel import Mesh
from lbskel.geometry import bvh
from lbskel.shapes import make, sphere, torus


def rays(mesh, k, seed=0):
    rng = np.random.default_rng(seed)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    ways = rng.normal(size=(k, 3))
    return low + (high - low) * rng.random((k, 3)), ways / np.linalg.norm(ways, axis=1, keepdims=True)


def met(mesh, origin, way):
    """Distance at which a ray hits each triangle, from the signed volumes of the ray with the triangle's edges."""
    A, B, C = (mesh.vertices[mesh.faces[:, corner]] - origin for corner in range(3))
    volumes = np.stack([np.cross(P, Q) @ way for P, Q in ((B, C), (C, A), (A, B))])
    normal = np.cross(B - A, C - A)
    far = np.einsum("fi,fi->f", normal, A) / (normal @ way)
    return np.where(((volumes > 0).all(axis=0) | (volumes < 0).all(axis=0)) & (far >= 0), far, np.inf)


@pytest.mark.parametrize("name", ["knot", "octopus"])
def test_nearest_points_are_those_of_libigl(name):
    mesh = make(name, n_vertices=3000).mesh
    points = np.concatenate([rays(mesh, 400)[0], mesh.vertices[::50], mesh.vertices[:5]])
    distance, place = mesh.aabb_tree.nearest(points)
    squared = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)[0]
    assert np.abs(distance - np.sqrt(squared)).max() < 1e-12 * mesh.diameter_bound
    assert np.abs(np.linalg.norm(place - points, axis=1) - distance).max() < 1e-12 * mesh.diameter_bound


def test_unused_vertices_far_away_do_not_enlarge_the_boxes():
    mesh = sphere(2)
    unused = Mesh([*mesh.vertices, [1e16, 0, 0]], mesh.faces)
    corners = mesh.vertices[mesh.faces]
    for tree in (mesh.aabb_tree, unused.aabb_tree):
        pairs = tree.overlapping_faces(corners.min(axis=1), corners.max(axis=1))
        assert sum(len(box) for box, _ in pairs) < 40 * len(mesh.faces)
    points, _ = rays(mesh, 50)
    assert np.array_equal(unused.aabb_tree.nearest(points)[0], mesh.aabb_tree.nearest(points)[0])


def test_the_nearest_point_is_on_a_corner_an_edge_or_inside():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    points = np.array([[-1, -1, 1], [0.5, -2, 0], [2, 2, 0], [0.2, 0.2, 3], [0, 0, 0], [3, -1, 0.0]])
    distance, place = mesh.aabb_tree.nearest(points)
    assert np.allclose(place, [[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0.2, 0.2, 0], [0, 0, 0], [1, 0, 0]], atol=1e-15)
    assert np.allclose(distance, np.linalg.norm(points - place, axis=1), atol=1e-15)


def test_the_nearest_face_has_the_nearest_point():
    mesh = make("knot", n_vertices=800).mesh
    points = np.concatenate([rays(mesh, 200)[0], mesh.vertices[:20]])  # in no order, and on faces
    distance, _, face = mesh.aabb_tree.nearest_faces(points)
    of_face = zip(points[:, None], mesh.faces[face, None], strict=True)
    own = [igl.point_mesh_squared_distance(point, mesh.vertices, corners)[0][0] for point, corners in of_face]
    assert np.abs(np.sqrt(own) - distance).max() < 1e-12 * mesh.diameter_bound


@pytest.mark.parametrize("size", [2.0**200, 2.0**-200])
def test_nearest_points_scale_with_the_mesh(size):
    mesh = make("knot", n_vertices=800).mesh
    points = rays(mesh, 50)[0]
    distance, place = mesh.aabb_tree.nearest(points)
    sized = mesh.with_vertices(size * mesh.vertices).aabb_tree.nearest(size * points)
    assert np.array_equal(sized[0], size * distance)
    assert np.array_equal(sized[1], size * place)


def test_faces_without_area_have_nearest_points():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], [[0, 1, 2], [3, 3, 3]])
    distance, place = mesh.aabb_tree.nearest(np.array([[1.5, 1, 0], [6, 5, 5.0]]))
    assert np.allclose(distance, [1, 1])
    assert np.allclose(place, [[1.5, 0, 0], [5, 5, 5]])


def test_a_ray_hits_the_first_of_all_triangles_on_it():
    mesh = make("octopus", n_vertices=3000).mesh
    origins, ways = rays(mesh, 300)
    face, far = mesh.aabb_tree.first_hits(origins, ways)
    every = np.array([met(mesh, origin, way) for origin, way in zip(origins, ways, strict=True)])
    nearest = every.min(axis=1)
    assert 30 < np.isfinite(nearest).sum() < 300
    assert np.array_equal(face >= 0, np.isfinite(nearest))
    assert np.array_equal(np.isfinite(far), np.isfinite(nearest))
    hit = face >= 0
    assert np.array_equal(face[hit], every.argmin(axis=1)[hit])
    assert far[hit] == pytest.approx(nearest[hit], rel=1e-9)


def test_rays_hit_small_faces():
    """libigl misses faces with determinants below 1e-6, as those of a unit shape of a million faces."""
    mesh = torus(1e-3, 3e-4, 96, 32)
    origins = np.array([[1e-3, 0, 0]])
    for way in np.eye(3):
        assert np.isfinite(mesh.aabb_tree.first_hits(origins, way[None])[1]).all()


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
    assert (mesh.aabb_tree.first_hits(origins, np.tile([0, 0, -1.0], (u.size, 1)))[1] == 2).all()
    assert np.isinf(mesh.aabb_tree.first_hits(origins, np.tile([0, 0, 1.0], (u.size, 1)))[1]).all()


def joined(*meshes):
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + first for mesh, first in zip(meshes, firsts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


@pytest.mark.parametrize("name", ["knot", "octopus", "hand"])
def test_winding_numbers_are_those_of_the_solid_angles(name):
    mesh = make(name, n_vertices=2000).mesh
    near = mesh.vertices + np.random.default_rng(1).normal(scale=0.01 * mesh.diameter_bound, size=mesh.vertices.shape)
    points = np.concatenate([rays(mesh, 1000)[0], near])
    expected = igl.winding_number(mesh.vertices, mesh.faces, points)
    assert 300 < (expected > 0.5).sum() < len(points) - 300
    assert np.array_equal(mesh.aabb_tree.winding_numbers(points), np.round(expected))


def test_winding_numbers_of_overlapping_hollow_and_reversed_surfaces():
    ball = sphere(2)
    inner = ball.with_vertices(0.5 * ball.vertices)
    hollow = joined(ball, Mesh(inner.vertices, inner.faces[:, ::-1]))
    twice = joined(ball, inner)
    points = np.array([[0.01, 0.02, 0.03], [0.1, 0.7, 0.2], [0.1, 1.2, 0.2]])
    assert hollow.aabb_tree.winding_numbers(points).tolist() == [0, 1, 0]
    assert twice.aabb_tree.winding_numbers(points).tolist() == [2, 1, 0]
    assert Mesh(ball.vertices, ball.faces[:, ::-1]).aabb_tree.winding_numbers(points).tolist() == [-1, -1, 0]


@pytest.mark.parametrize("degrees", [0, 1, 30, 45, 77])
def test_winding_numbers_at_points_above_corners_edges_and_walls(degrees):
    """A building of boxes on a grid: rays pass through its corners, along its edges, and in the planes of its walls.

    When it is rotated, they do so up to rounding.
    """
    turn = Rotation.from_euler("z", degrees, degrees=True)
    height = np.array([[0, 0, 0, 0, 0], [0, 3, 1, 2, 0], [0, 3, 3, 1, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, 0]])
    solid = np.arange(4) < height[..., None]
    cells = np.argwhere(solid)
    sides = []
    for axis in range(3):
        for way in (-1, 1):
            beside = cells + way * np.eye(3, dtype=int)[axis]
            is_wall = ~np.array([solid[tuple(cell)] if (cell >= 0).all() else False for cell in beside])
            u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
            low = cells[is_wall] + max(way, 0) * np.eye(3, dtype=int)[axis]
            quads = np.stack([low, low + u, low + u + v, low + v], axis=1)
            sides.append(quads if way > 0 else quads[:, ::-1])
    corners = np.concatenate(sides)
    V, number = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    quads = number.reshape(-1, 4)
    mesh = Mesh(V, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    assert mesh.is_closed
    grid = np.stack(np.meshgrid(np.arange(0, 5.01, 0.5), np.arange(0, 5.01, 0.5), np.arange(0.25, 4, 0.5)), axis=-1)
    points = grid.reshape(-1, 3)
    is_clear = mesh.aabb_tree.nearest(points)[0] > 0
    points = points[is_clear]
    cell = np.floor(points).astype(int)
    expected = np.zeros(len(points), dtype=int)
    inside_grid = (cell < solid.shape).all(axis=1)
    expected[inside_grid] = solid[tuple(cell[inside_grid].T)]
    assert 20 < expected.sum() < len(points) - 20
    assert np.array_equal(mesh.with_vertices(turn.apply(V)).aabb_tree.winding_numbers(turn.apply(points)), expected)


def test_winding_numbers_do_not_depend_on_a_face_without_area():
    mesh = sphere(2)
    (a, b, c), k = mesh.faces[0], len(mesh.vertices)
    middle = 0.7 * mesh.vertices[a] + 0.3 * mesh.vertices[b]
    on_edge = np.linspace(mesh.vertices[a], mesh.vertices[b], 50)
    faces = np.concatenate([mesh.faces[1:], [[a, k, c], [k, b, c], [a, b, k]]])  # the last lies on a line
    split = Mesh(np.concatenate([mesh.vertices, middle[None]]), faces)
    assert split.is_closed_manifold
    aside = np.concatenate([on_edge + [0, 0, height] for height in (-0.2, -0.1, -0.03, 0.03, 0.1)])
    points = np.concatenate([rays(split, 1000)[0], middle * np.linspace(0.5, 1.5, 40)[:, None], aside])
    points = points[mesh.aabb_tree.nearest(points)[0] > 1e-12]
    assert np.array_equal(split.aabb_tree.winding_numbers(points), mesh.aabb_tree.winding_numbers(points))


def test_winding_numbers_in_the_plane_of_a_vertical_face():
    """Seen along the ray the face is a line, and rounding decides on which side of it a point lies."""
    rng = np.random.default_rng(0)
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    for _ in range(200):
        V = rng.normal(size=(4, 3))
        V[2, :2] = V[0, :2] + rng.random() * (V[1, :2] - V[0, :2])
        mesh = Mesh(V, faces)
        share, height = rng.random((200, 1)), rng.uniform(-2, 2, size=200)
        points = np.column_stack([V[0, :2] + share * (V[1, :2] - V[0, :2]), height])
        points = points[mesh.aabb_tree.nearest(points)[0] > 1e-12]
        assert len(points) > 100
        assert not mesh.aabb_tree.winding_numbers(points).any()  # all of a tetrahedron is on one side of each face


def test_the_boxes_of_a_surface_overlap_little():
    assert 1 < sphere(3).aabb_tree.overlap < 10


@pytest.mark.parametrize("n_faces", [1, 4, 5, 150])
@pytest.mark.parametrize("block_size", [3, 10_000])
def test_overlapping_faces_are_those_whose_boxes_overlap(n_faces, block_size, monkeypatch):
    """Large and small triangles on a coarse grid, so that boxes touch; boxes come in their order, in small blocks."""
    monkeypatch.setattr(bvh, "BLOCK_SIZE", block_size)
    rng = np.random.default_rng(n_faces)
    corners = rng.integers(0, 9, (n_faces, 1, 3)) + np.round(rng.normal(size=(n_faces, 3, 3)))
    mesh = Mesh(corners.reshape(-1, 3), np.arange(3 * n_faces).reshape(-1, 3))
    lowest, highest = corners.min(axis=1), corners.max(axis=1)
    low = rng.integers(-1, 9, (40, 3)).astype(float)
    high = low + rng.integers(0, 3, (40, 3))
    blocks = list(mesh.aabb_tree.overlapping_faces(low, high))
    box = np.concatenate([block[0] for block in blocks])
    face = np.concatenate([block[1] for block in blocks])
    assert (np.diff(box) >= 0).all()
    assert max(len(block[0]) for block in blocks) <= 4 * block_size
    expected = ((low[:, None] <= highest) & (lowest <= high[:, None])).all(axis=2)
    assert sorted(map(list, zip(box.tolist(), face.tolist(), strict=True))) == np.argwhere(expected).tolist()
