"""Meshes in closed form: positions, areas, volumes and orientation against their formulas."""

import numpy as np
import pytest

from lbskel import MeshError
from lbskel.shapes import capsule, cylinder, flat_grid, schwarz_lantern, sphere, torus, tube

ROUNDING = 1e-12  # coordinates near 1


def _face_normals(mesh):
    """(m, 3) face normals, whose length is twice the area."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


@pytest.mark.parametrize(
    ("mesh", "genus", "volume"),
    [
        (sphere(4), 0, 4 * np.pi / 3),
        (torus(1.0, 0.4, 96, 48), 1, 2 * np.pi**2 * 0.4**2),
        (capsule(2.0, 0.5, 96), 0, np.pi * 0.5**2 * 2 + 4 * np.pi / 3 * 0.5**3),
        (tube([[0, 0, 0], [1, 2, 2]], 0.3, sides=96), 0, np.pi * 0.3**2 * 3),
    ],
    ids=["sphere", "torus", "capsule", "tube"],
)
def test_closed_surfaces_are_manifolds_oriented_outwards(mesh, genus, volume):
    assert mesh.is_closed_manifold
    assert (mesh.genus, mesh.n_components) == (genus, 1)
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)
    # An inscribed polygon of n sides has the area of the circle times 1 - 2 pi^2 / (3 n^2), 7e-4 less for n = 96; twice
    # that for surfaces curved in two directions.
    assert mesh.volume == pytest.approx(volume, rel=4e-3)
    assert mesh.volume < volume


def test_sphere_has_its_vertices_on_the_sphere_and_second_order_area():
    areas = np.array([sphere(k).area for k in (2, 3, 4)])
    assert np.abs(np.linalg.norm(sphere(3).vertices, axis=1) - 1).max() < ROUNDING
    assert len(sphere(3).vertices) == 642
    errors = 4 * np.pi - areas
    assert errors[:-1] / errors[1:] == pytest.approx([4, 4], rel=0.05)  # the edge length halves


def test_torus_vertices_are_at_the_angles_of_their_indices():
    R, r, n, m = 2.0, 0.5, 12, 8
    mesh = torus(R, r, n, m)
    i, j = 5, 3
    around, section = 2 * np.pi * i / n, 2 * np.pi * j / m
    ring = R + r * np.cos(section)
    expected = [ring * np.cos(around), ring * np.sin(around), r * np.sin(section)]
    assert np.abs(mesh.vertices[i * m + j] - expected).max() < ROUNDING
    distance = np.hypot(np.hypot(*mesh.vertices.T[:2]) - R, mesh.vertices[:, 2])
    assert np.abs(distance - r).max() < ROUNDING


def test_cylinder_is_open_at_both_ends_and_oriented_outwards():
    mesh = cylinder(0.5, 3.0, 20, 7)
    assert mesh.is_edge_manifold
    assert (mesh.faces_per_edge == 1).sum() == 40
    assert mesh.area == pytest.approx(20 * 2 * 0.5 * np.sin(np.pi / 20) * 3.0)  # the prism with 20 sides
    outwards = mesh.vertices[mesh.faces].mean(axis=1) * [1, 1, 0]
    assert ((_face_normals(mesh) * outwards).sum(axis=1) > 0).all()


def test_capsule_vertices_have_one_distance_from_its_segment():
    mesh = capsule(1.5, 0.3, 24)
    x, y, z = mesh.vertices.T
    beyond = np.maximum(np.abs(z) - 0.75, 0)
    assert np.abs(np.sqrt(x**2 + y**2 + beyond**2) - 0.3).max() < ROUNDING
    assert z.max() == pytest.approx(0.75 + 0.3)


def test_tube_keeps_its_radii_and_does_not_twist():
    t = np.linspace(0, 4, 60)
    axis = np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1)
    radii = np.linspace(0.3, 0.1, 60)
    mesh = tube(axis, radii, sides=12)
    rings = mesh.vertices[: 60 * 12].reshape(60, 12, 3)[::-1]
    assert mesh.is_closed_manifold
    assert mesh.volume > 0
    assert np.abs(np.linalg.norm(rings - axis[:, None], axis=2) - radii[:, None]).max() < ROUNDING
    # Sections do not rotate about the axis: a line along the tube has no component normal to both radius and axis, up
    # to second order in the angle 4/59 between two sections.
    spokes = (rings - axis[:, None]) / radii[:, None, None]
    tangents = np.gradient(axis, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    rotation = (np.cross(tangents[:-1, None], spokes[:-1]) * spokes[1:]).sum(axis=2)
    assert np.abs(rotation).max() < (4 / 59) ** 2


def test_flat_grid_is_the_unit_square_facing_up():
    mesh = flat_grid(4, 6)
    assert len(mesh.vertices) == 24
    assert mesh.area == pytest.approx(1.0)
    assert mesh.euler_characteristic == 1
    assert (_face_normals(mesh)[:, 2] > 0).all()


def test_schwarz_lantern_area_equals_its_formula():
    n, m = 12, 50
    mesh = schwarz_lantern(n, m)
    height = np.hypot(1 / m, 1 - np.cos(np.pi / n))
    assert mesh.is_edge_manifold
    assert mesh.area == pytest.approx(2 * n * m * np.sin(np.pi / n) * height)
    assert np.abs(np.hypot(*mesh.vertices.T[:2]) - 1).max() < ROUNDING
    outwards = mesh.vertices[mesh.faces].mean(axis=1) * [1, 1, 0]
    assert ((_face_normals(mesh) * outwards).sum(axis=1) > 0).all()


def test_schwarz_lantern_area_grows_without_bound():
    assert schwarz_lantern(8, 8**3).area > 3 * schwarz_lantern(8, 8).area


def test_flat_grid_vertices_run_along_y_first():
    mesh = flat_grid(3, 5)
    assert np.allclose(mesh.vertices[1], [0, 1 / 4, 0])
    assert np.allclose(mesh.vertices[5], [1 / 2, 0, 0])


def test_tube_sections_are_normal_to_the_mean_direction_of_their_segments():
    mesh = tube([[0, 0, 0], [2, 0, 0], [2, 3, 0]], [0.1, 0.2, 0.3], sides=8)
    start, corner, end = mesh.vertices[:24].reshape(3, 8, 3)[::-1]
    assert np.abs(start[:, 0]).max() < ROUNDING
    assert np.abs((corner - [2, 0, 0]) @ [1, 1, 0]).max() < ROUNDING
    assert np.abs(end[:, 1] - 3).max() < ROUNDING


@pytest.mark.parametrize("sides", [3, 12])
def test_rounded_ends_are_half_spheres(sides):
    mesh = tube([[0, 0, 0], [1, 2, 2]], [0.3, 0.2], sides=sides, rounded=True)
    assert mesh.is_closed_manifold
    assert mesh.volume > 0
    direction = np.array([1, 2, 2]) / 3
    along = mesh.vertices @ direction
    below, above = mesh.vertices[along < ROUNDING], mesh.vertices[along > 3 - ROUNDING] - [1, 2, 2]
    assert len(below) == len(above) == max(sides // 4, 1) * sides + 1
    assert np.abs(np.linalg.norm(below, axis=1) - 0.3).max() < ROUNDING
    assert np.abs(np.linalg.norm(above, axis=1) - 0.2).max() < ROUNDING
    assert (along.min(), along.max()) == pytest.approx((-0.3, 3.2))


@pytest.mark.parametrize(
    ("polyline", "message"),
    [
        ([[0, 0, 0]], "must have two points or more, not 1"),
        ([[0, 0, 1], [0, 0, 0], [0, 0, 0], [1, 0, 0]], "points 1 and 2 of the polyline, counted from 0, coincide"),
        ([[0, 0, 0], [np.nan, 0, 0]], "points of the polyline 1 have NaN"),
    ],
)
def test_the_fault_of_a_polyline_is_named(polyline, message):
    with pytest.raises(MeshError, match=message):
        tube(polyline, 1.0)
