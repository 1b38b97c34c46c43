"""The unit frame: there and back, through a translation, a scale and a reflection."""

import numpy as np
import pytest

from lbskel.geometry.unit_frame import UnitFrame


@pytest.mark.parametrize("mirror", [[1.0, 1, 1], [-1.0, 1, 1]])
def test_points_go_to_unit_coordinates_and_back(mirror):
    frame = UnitFrame(np.array([3.0, -2, 7]), 4.0, np.array(mirror))
    points = np.random.default_rng(0).normal(size=(20, 3))
    unit = frame.to_unit(points)
    assert frame.from_unit(unit) == pytest.approx(points, rel=1e-15, abs=1e-15)
    assert np.abs(frame.to_unit(frame.center[None])).max() == 0
    edges = [np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (points, unit)]
    assert edges[1] * 4 == pytest.approx(edges[0], rel=1e-14)
    turns = [np.linalg.det(each[1:4] - each[0]) for each in (points, unit)]
    assert turns[1] * 64 == pytest.approx(turns[0] * np.prod(mirror), rel=1e-12)
