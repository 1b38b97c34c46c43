"""Steps towards larger inscribed balls: from a side to the middle, and no farther."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.inscribed_balls import climb_to_middle
from lbskel.shapes import cylinder, sphere

FRAMES = np.stack([np.eye(3), [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]])


@pytest.mark.parametrize("frame", FRAMES)
def test_a_point_in_a_ball_gets_to_its_center(frame):
    places, radii = climb_to_middle(np.array([[0.5, 0.3, -0.2]]), frame[None], Surface(sphere(4)))
    # the slope falls below one half within the width of the last steps, and the faces are flat
    assert np.linalg.norm(places[0]) < 0.05
    assert radii[0] > 0.95


def test_a_point_in_a_cylinder_gets_to_the_axis_and_not_along_it():
    rod = Surface(cylinder(0.5, 6.0, 48, 60))
    start = np.array([[0.3, 0.2, 0.1]]) + rod.mesh.vertices.mean(axis=0)
    places, radii = climb_to_middle(start, FRAMES[1:], rod)
    moved = places[0] - start[0]
    assert np.linalg.norm((places[0] - rod.mesh.vertices.mean(axis=0))[:2]) < 0.03
    assert abs(moved[2]) < 0.1
    assert radii[0] == pytest.approx(rod.distance(places)[0])


def test_a_cone_of_a_quarter_is_not_climbed_along_its_axis():
    """The ball grows by sin(atan(1 / 4)) = 0.24 of the way along the axis, which is less than a half."""
    rod = cylinder(0.5, 6.0, 48, 60)
    z = rod.vertices[:, 2] - rod.vertices[:, 2].min()
    widened = rod.vertices * np.stack([1 + z / 2, 1 + z / 2, np.ones(len(z))], axis=1)
    cone = Surface(Mesh(widened, rod.faces))
    start = np.array([[0, 0, 3.0 + rod.vertices[:, 2].min()]])
    places, _ = climb_to_middle(start, FRAMES[:1], cone)
    assert np.linalg.norm(places - start) < 0.05


def test_no_points_are_no_error():
    places, radii = climb_to_middle(np.empty((0, 3)), np.empty((0, 3, 3)), Surface(sphere(1)))
    assert places.shape == (0, 3)
    assert radii.shape == (0,)
