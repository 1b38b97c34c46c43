"""Marching cubes on solids, and Newton's method onto their surfaces."""

import numpy as np
import pytest

from lbskel.shapes import marching_cubes, project, solid_of

ROUNDING = 1e-12  # of sums of a few dozen numbers near 1


def test_marching_cubes_of_a_ball_converge_at_second_order():
    ball = solid_of([(np.zeros(3), 1.0)])
    volumes = []
    for step in (0.2, 0.1):
        raw = marching_cubes(ball, step)
        assert raw.is_closed_manifold
        assert (raw.genus, raw.n_components) == (0, 1)
        projected = project(ball, raw.vertices, step=step)
        assert np.abs(np.linalg.norm(projected, axis=1) - 1).max() < ROUNDING
        volumes.append(raw.volume)
    errors = 4 * np.pi / 3 - np.array(volumes)
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)  # second order in the step, and inscribed
    assert errors[1] > 0


def test_no_part_of_the_surface_is_missed_by_the_coarse_cells():
    solid = solid_of([([0, 0, 0], 0.05), ([3, 0, 0], 1.0), ([0, 3, 3], 0.05)])
    mesh = marching_cubes(solid, 0.03)
    assert mesh.n_components == 3
    assert mesh.is_closed_manifold
    assert mesh.area == pytest.approx(4 * np.pi * (1 + 2 * 0.05**2), rel=0.01)  # second order in step / radius = 0.6


def test_faces_point_outwards():
    mesh = marching_cubes(solid_of([([[0, 0, 0], [0, 0, 2]], 0.5)]), 0.1)
    assert mesh.volume == pytest.approx(np.pi * 0.5**2 * (2 + 4 / 3 * 0.5), rel=0.02)


def test_projection_moves_points_along_the_normal_of_a_cylinder():
    solid = solid_of([([[-9, 0, 0], [9, 0, 0]], 0.5)])
    angle = np.linspace(0, 2 * np.pi, 50)
    directions = np.stack([np.zeros(50), np.cos(angle), np.sin(angle)], axis=1)
    points = [1.0, 0, 0] + directions * np.linspace(0.4, 0.6, 50)[:, None]
    assert np.abs(project(solid, points, step=0.1) - ([1.0, 0, 0] + 0.5 * directions)).max() < 1e-9


def test_projection_converges_where_the_gradient_is_short():
    """In the blend of two branches at 30 degrees the gradient of the smooth minimum is well below 1."""
    solid = solid_of([([[0, 0, 0], [2, 0, 0]], 0.2), ([[0, 0, 0], [np.sqrt(3), 1, 0]], 0.2)])
    raw = marching_cubes(solid, 0.05).vertices
    assert np.linalg.norm(solid.gradient(raw, step=1e-5), axis=1).min() < 0.5
    assert np.abs(solid.distance(project(solid, raw, step=0.05), cutoff=0.1)).max() < 1e-12


def test_newton_steps_are_no_longer_than_the_bound():
    solid = solid_of([([[-9, 0, 0], [9, 0, 0]], 0.5)])
    moved = project(solid, np.array([[0.1, 0.6, 0]]), step=0.01)
    # 2 gradients with 4 steps each, of at most 0.01, do not reach the surface
    assert np.linalg.norm(moved - [[0.1, 0.6, 0]]) == pytest.approx(0.08)
