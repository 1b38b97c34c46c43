"""Scaling by powers of two, and factors between units."""

import numpy as np
import pytest

from lbskel import Mesh, UnknownChoice
from lbskel.geometry.scaling import require_scale, unit_scale, unit_vertices


@pytest.mark.parametrize("size", [1e-300, 0.3, 1.0, 2.0, 7.0, 1e300])
def test_the_largest_coordinate_is_brought_to_between_a_half_and_one_exactly(size):
    points = size * np.array([[1.0, -0.25, 0.1], [0.5, 0.0, -1.0]])
    scaled, exponent = unit_scale(points)
    assert 0.5 <= np.abs(scaled).max() < 1
    assert np.array_equal(np.ldexp(scaled, exponent), points)


def test_vertices_without_a_face_have_no_influence():
    square = np.array([[0.0, 0, 0], [3, 0, 0], [0, 5, 0]])
    far = Mesh(np.concatenate([[[1e16, -1e16, 0]], square]), [[1, 2, 3]])
    scaled, exponent = unit_vertices(far)
    expected, expected_exponent = unit_scale(square)
    assert exponent == expected_exponent
    assert np.array_equal(scaled[1:], expected)
    assert scaled[0] == pytest.approx(expected.mean(axis=0))
    assert np.array_equal(unit_vertices(Mesh(square, [[0, 1, 2]]))[0], expected)


def test_points_at_the_origin_stay():
    scaled, exponent = unit_scale(np.zeros((2, 3)))
    assert exponent == 0
    assert not scaled.any()


@pytest.mark.parametrize("scale", [0, -1, np.inf, np.nan])
def test_a_factor_between_units_is_positive_and_finite(scale):
    require_scale(1e-9)
    with pytest.raises(UnknownChoice, match="scale must be a positive number, not"):
        require_scale(scale)
