"""Color scales: their ranges, ends and colors."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps

from lbskel.visualization.colormaps import OUTLIER_PERCENT, PLASMA_FRACTION, ColorScale, field_scales, radius_scale


def test_colors_run_from_the_first_to_the_fraction_of_the_color_map():
    scale = ColorScale(2.0, 6.0, "viridis", 0.5)
    expected = [colormaps["viridis"](position)[:3] for position in (0.0, 0.25, 0.5)]
    np.testing.assert_allclose(scale.colors([2.0, 4.0, 6.0]), expected, atol=2 / 256)  # 256 colors
    np.testing.assert_array_equal(scale.colors([-9.0, 99.0]), scale.colors([2.0, 6.0]))
    assert scale.colors([2.0]).dtype == np.float32


def test_nan_is_gray():
    np.testing.assert_allclose(ColorScale(0.0, 1.0, "plasma").colors([np.nan]), [[0.75] * 3])


def test_radii_of_all_skeletons_share_the_range_of_the_known_ones():
    scale = radius_scale([np.array([0.5, np.nan]), np.array([2.0, np.inf]), np.empty(0)])
    assert (scale.low, scale.high, scale.colormap, scale.fraction) == (0.5, 2.0, "plasma", PLASMA_FRACTION)
    assert radius_scale([np.array([np.nan])]) is None
    assert radius_scale([]) is None


@pytest.mark.parametrize("value", [3.0, 0.0, -2.0])
def test_a_range_of_one_number_is_widened_around_it(value):
    scale = radius_scale([np.full(4, value)])
    assert scale.low < value < scale.high
    assert (scale.low + scale.high) / 2 == pytest.approx(value)


def test_a_positive_field_uses_the_range_without_outliers():
    values = np.linspace(1, 101, 1001)
    scale = field_scales([("curvature", values)])["curvature"]
    expected = np.percentile(values, [OUTLIER_PERCENT, 100 - OUTLIER_PERCENT])
    assert (scale.low, scale.high) == pytest.approx(tuple(expected))
    assert scale.low == pytest.approx(1 + 100 * OUTLIER_PERCENT / 100)
    assert (scale.colormap, scale.extend) == ("viridis", "both")


def test_a_field_of_both_signs_is_symmetric_around_zero():
    values = np.linspace(-1, 3, 1001)
    scale = field_scales([("f", values)])["f"]
    bound = 3 - 4 * OUTLIER_PERCENT / 100
    assert (scale.low, scale.high) == pytest.approx((-bound, bound))
    assert (scale.colormap, scale.extend) == ("RdBu_r", "max")  # only the largest values are beyond
    red, _, blue = scale.colors([bound])[0]
    assert red > blue
    np.testing.assert_allclose(scale.colors([0.0]), [[0.97] * 3], atol=0.02)  # neutral in the middle


def test_fields_of_one_name_share_one_scale():
    scales = field_scales([("a", np.array([0.0, 1.0])), ("b", np.array([5.0, 5.0])), ("a", np.array([1.0, 3.0]))])
    assert set(scales) == {"a", "b"}
    assert scales["a"].high == pytest.approx(np.percentile([0, 1, 1, 3], 95))
    assert (scales["b"].low, scales["b"].high, scales["b"].extend) == (2.5, 7.5, "neither")


def test_a_field_without_finite_values_has_a_scale():
    scale = field_scales([("f", np.full(3, np.nan))])["f"]
    assert scale.low < scale.high


def test_a_soma_does_not_take_the_colors_of_the_branches():
    """1,000 radii from 1 to 2, three of 100, and three of 0: the scale is that of the thousand."""
    radii = np.concatenate([np.linspace(1, 2, 1000), [100.0] * 3, [0.0] * 3])
    scale = radius_scale([radii])
    assert 1 <= scale.low < 1.03
    assert 1.97 < scale.high <= 2
    assert scale.extend == "both"
    assert radius_scale([radii[:-3]]).extend == "max"
    assert radius_scale([np.linspace(1, 2, 1000)]).extend == "neither"
    assert radius_scale([np.linspace(1, 2, 1000)]).high == 2
