"""Surface queries: distances, rays, inside tests, and the answers that are remembered."""

import numpy as np
import pytest

from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import sphere, torus


def test_a_surface_answers_the_same_question_with_the_same_answer():
    mesh = torus(1.0, 0.3, 48, 16)
    points = np.random.default_rng(0).uniform(-1, 1, (50, 3))
    surface, other = Surface(mesh), Surface(torus(1.0, 0.3, 48, 16))
    first, inside = surface.distance(points), surface.contains(points)
    assert surface.closest(points.copy())[0] is surface.closest(points)[0]
    assert not first.flags.writeable
    assert not inside.flags.writeable
    for shift in np.linspace(0, 1, 40):  # more questions than are remembered
        assert np.array_equal(surface.distance(points + shift), other.closest(points + shift)[0])
    assert np.array_equal(surface.distance(points), first)
    assert np.array_equal(surface.contains(points), inside)


def test_surface_queries():
    surface = Surface(sphere(3))
    assert np.array_equal(surface.contains(np.array([[0, 0, 0], [0, 0, 2.0]])), [True, False])
    ahead = surface.ray_distance(np.array([[0.0, 0, 0], [0, 0, 2]]), np.array([[0.0, 0, 1], [0, 0, 1]]))
    assert ahead[0] == pytest.approx(1, rel=0.02)
    assert np.isinf(ahead[1])
