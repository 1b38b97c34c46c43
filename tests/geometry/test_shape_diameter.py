"""Local thickness: rays from faces, against shapes whose thickness is known."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.shape_diameter import local_thickness, thickness_along_normal
from lbskel.shapes import flat_grid, sphere


def test_thickness_of_a_ball_and_of_a_sheet():
    ball = sphere(3)
    every = np.arange(len(ball.faces))
    # straight through is 2; a slanted ray ends on the sphere a quarter nearer
    assert local_thickness(ball, every) == pytest.approx(np.full(len(every), 1.5), rel=0.02)
    assert np.isinf(local_thickness(flat_grid(), np.array([0]))).all()


def test_thickness_along_the_normal_is_the_diameter_of_a_ball_also_inside_out():
    ball = sphere(3)
    faces = np.arange(0, len(ball.faces), 10)
    for mesh in (ball, Mesh(ball.vertices, ball.faces[:, ::-1])):
        # faces with edges h of 0.15 lie up to h^2 / 3 below the sphere
        assert thickness_along_normal(mesh, faces) == pytest.approx(np.full(len(faces), 2.0), abs=0.02)
    assert np.isinf(thickness_along_normal(flat_grid(), np.array([0]))).all()


def test_no_faces_have_no_thickness():
    assert local_thickness(sphere(1), np.array([], dtype=np.int64)).shape == (0,)
