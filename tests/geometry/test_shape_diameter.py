"""Local thickness: rays from faces, against shapes whose thickness is known."""

import numpy as np
import pytest

from lbskel.geometry.shape_diameter import local_thickness
from lbskel.shapes import flat_grid, sphere


def test_thickness_of_a_ball_and_of_a_sheet():
    ball = sphere(3)
    every = np.arange(len(ball.faces))
    # straight through is 2; a slanted ray ends on the sphere a quarter nearer
    assert local_thickness(ball, every) == pytest.approx(np.full(len(every), 1.5), rel=0.02)
    assert np.isinf(local_thickness(flat_grid(), np.array([0]))).all()
