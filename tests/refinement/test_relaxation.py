"""Relaxed paths: ends that stay, the middle of narrow parts, no fold, and each path as if it were alone."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.relaxation import MAX_PIECES, SPACINGS, relax_inside
from lbskel.shapes import capsule, sphere, torus

ROD = capsule(8.0, 0.5, 48)  # from -4.5 to 4.5 along z


def turns(path):
    """Angles in degrees between the segments of a path that follow one another."""
    steps = np.diff(path, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    return np.degrees(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1, 1)))


def test_a_path_at_the_side_of_a_rod_goes_to_its_axis_between_its_ends():
    surface = Surface(ROD)
    side = np.array([[0.35, 0, -3.0], [0.45, 0, 0], [0.35, 0, 3.0]])
    [path] = relax_inside([side], surface)
    assert np.array_equal(path[[0, -1]], side[[0, 2]])
    middle = path[np.abs(path[:, 2]) < 2]
    # a step of the ascent is a quarter of the radius at first and a fiftieth before the last, and goes past the axis
    assert np.linalg.norm(middle[:, :2], axis=1).max() < 0.03 * 0.5
    gaps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    # spaced before the last steps, in which the balls grow and the path becomes shorter
    assert np.abs(gaps / (SPACINGS[-1] * surface.distance(middle[:-1])) - 1).max() < 0.25


def test_a_fold_is_straightened():
    folded = np.array([[0, 0, -3.0], [0.1, 0, 1.0], [-0.1, 0.1, -1.0], [0, 0, 3.0]])
    assert turns(folded).min() > 150
    [path] = relax_inside([folded], Surface(ROD))
    assert turns(path).max() < 10


def test_a_path_keeps_to_its_side_of_a_tunnel():
    """In a torus, from one end of a diameter to the other: either half is as short."""
    angles = np.linspace(0, np.pi, 13)
    half = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    there, back = relax_inside([0.8 * half, 1.2 * half * [1, -1, 1]], Surface(torus(1.0, 0.3, 96, 32)))
    assert there[1:-1, 1].min() > 0
    assert back[1:-1, 1].max() < 0
    # the last steps shorten more than they center: each by a third of the square of their length, times the curvature
    assert np.abs(np.linalg.norm(there[8:-8], axis=1) - 1).max() < 3 * (SPACINGS[-1] * 0.3) ** 2 / 3


def test_a_path_is_relaxed_as_if_it_were_alone():
    surface = Surface(ROD)
    paths = [np.array([[0.3, 0, z], [-0.3, 0.1, z + 1], [0.3, 0, z + 2.5]]) for z in (-3, -1, 0.5)]
    together = relax_inside(paths, surface)
    # places along the paths are added up over all of them
    assert all(
        np.allclose(each, relax_inside([path], surface)[0], atol=1e-9)
        for each, path in zip(together, paths, strict=True)
    )


def test_points_outside_come_inside():
    surface = Surface(sphere(3))
    [path] = relax_inside([np.array([[-0.8, 0, 0], [0, 1.05, 0], [0.8, 0, 0]])], surface)
    assert surface.contains(path).all()


def test_a_path_of_no_length_is_its_ends():
    point = np.zeros((2, 3))
    [path] = relax_inside([point], Surface(sphere(2)))
    assert np.array_equal(path, point)


CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TETRAHEDRON = Mesh(CORNERS, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.mark.parametrize("n_points", [2, 3, 20])
def test_a_path_on_the_surface_keeps_the_number_of_its_points(n_points):
    """Along an edge of a tetrahedron, where no ball fits, up to rounding, and beside one inside."""
    along = np.linspace(*CORNERS[:2], n_points) + 1e-7
    inside = np.array([[0.1, 0.1, 0.1], [0.3, 0.2, 0.2]])
    path, other = relax_inside([along, inside], Surface(TETRAHEDRON))
    assert len(path) == n_points
    assert np.allclose(path, along, atol=1e-6)
    assert len(other) > 2


def test_a_path_nearly_on_the_surface_does_not_become_long():
    """Along an edge of a tetrahedron, but for a small ball: without a bound there would be ten thousand points."""
    path = np.linspace(*CORNERS[:2], 5)
    path[2] += 3e-4
    [relaxed] = relax_inside([path], Surface(TETRAHEDRON))
    assert len(relaxed) <= MAX_PIECES + 1
