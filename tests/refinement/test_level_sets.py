"""Geodesic caps: limbs told from flat patches, and the centroids of their level sets."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.refinement.level_sets import find_geodesic_caps
from lbskel.refinement.tips import MIN_LIMB_LENGTH
from lbskel.shapes import capsule, sphere


def test_half_a_rod_is_a_limb_with_a_straight_axis():
    rod = capsule(4.0, 0.5, 48)
    patch = np.where(rod.vertices[:, 2] > 0.3, 7, -1)
    (number, cap) = next(iter(find_geodesic_caps(rod, patch).items()))
    assert number == 7
    assert cap.end == pytest.approx([0, 0, 2.5], abs=1e-9)
    # from the pole: a quarter of a circle, and 1.7 along the rod, less the row of vertices at the border
    assert cap.length == pytest.approx(0.5 * np.pi / 2 + 1.7, rel=0.05)
    # the cap has less area than the cylinder of its length by 1 - 2 / pi
    assert cap.radius == pytest.approx(0.5 * (1 - (np.pi / 2 - 1) * 0.5 / cap.length), rel=0.05)
    assert cap.axis[:, :2] == pytest.approx(0, abs=1e-6)
    assert (np.diff(cap.axis[:, 2]) > 0).all()
    assert 0.3 < cap.axis[0, 2] < 0.3 + 0.25  # a step of half a radius
    assert cap.axis[-1, 2] == pytest.approx(2.0, abs=0.1)  # the rows of vertices are 0.06 to 0.1 apart


def test_a_hemisphere_and_a_flat_patch_are_too_short_for_limbs():
    ball = sphere(4)
    for height, max_ratio in ((0.0, 2.5), (0.9, 2.1)):  # a hemisphere, and a nearly flat patch
        cap = find_geodesic_caps(ball, np.where(ball.vertices[:, 2] > height, 0, -1))[0]
        # distances along edges are up to 15 % too long
        assert cap.length / cap.radius < 1.15**2 * max_ratio
        assert cap.length / cap.radius < MIN_LIMB_LENGTH


def test_a_patch_without_a_border_or_inner_vertices_has_no_cap():
    ball = sphere(2)
    assert find_geodesic_caps(ball, np.zeros(len(ball.vertices), dtype=int)) == {}
    assert find_geodesic_caps(ball, np.full(len(ball.vertices), -1)) == {}
    assert find_geodesic_caps(ball, np.where(np.arange(len(ball.vertices)) == 5, 0, -1)) == {}


def test_patches_do_not_influence_each_other():
    rod = capsule(4.0, 0.5, 24)
    z = rod.vertices[:, 2]
    both = find_geodesic_caps(rod, np.select([z > 0.3, z < -0.3], [0, 1], -1))
    alone = find_geodesic_caps(rod, np.where(z > 0.3, 0, -1))
    assert sorted(both) == [0, 1]
    assert both[0].length == alone[0].length
    assert both[1].axis == pytest.approx(both[0].axis * [1, 1, -1], abs=1e-6)


def test_the_axes_of_a_random_triangle_soup_are_finite():
    rng = np.random.default_rng(0)
    V, F = rng.normal(size=(40, 3)), rng.integers(40, size=(120, 3))
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    V[5] = V[6]
    for cap in find_geodesic_caps(Mesh(V, F), rng.integers(-1, 3, size=40)).values():
        assert np.isfinite(cap.axis).all()
