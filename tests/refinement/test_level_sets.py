"""Geodesic caps: limbs and flat patches, and the centroids of their level sets."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.level_sets import centered_axes, find_geodesic_caps
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


def test_the_centroid_of_a_level_set_does_not_depend_on_the_sampling():
    """A rod that has four times as many vertices on one side as on the other; its level sets are still circles."""
    angle = np.concatenate(
        [np.linspace(0, np.pi, 24, endpoint=False), np.linspace(np.pi, 2 * np.pi, 6, endpoint=False)]
    )
    z = np.linspace(0, 4, 41)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.5
    V = np.concatenate([np.column_stack([ring, np.full(30, height)]) for height in z] + [[[0, 0, 4.0]]])
    k = np.arange(30)
    a, b = k, (k + 1) % 30
    side = [
        np.concatenate([np.stack([a, b, b + 30], 1), np.stack([a, b + 30, a + 30], 1)]) + 30 * row for row in range(40)
    ]
    top = np.stack([a + 1200, b + 1200, np.full(30, 1230)], axis=1)
    mesh = Mesh(V, np.concatenate([*side, top]))
    [cap] = find_geodesic_caps(mesh, np.where(V[:, 2] > 0.05, 0, -1)).values()
    # the chords of 30 degrees on one side leave out 1 % of the radius; vertices alone would be off by half of it
    assert np.abs(cap.axis[2:-2, :2]).max() < 0.05


def test_a_cap_ends_at_the_nearest_part_of_a_slanted_border():
    rod = capsule(4.0, 0.5, 48)
    slanted = find_geodesic_caps(rod, np.where(rod.vertices @ [1.0, 0, 1] > 0, 0, -1))[0]
    straight = find_geodesic_caps(rod, np.where(rod.vertices[:, 2] > 0.5, 0, -1))[0]
    # the border is highest at z = 0.5, where x = -0.5; from the pole its middle is 0.5 farther and its lowest point 1
    assert straight.length < slanted.length < straight.length + 0.5


def test_points_of_an_axis_inside_the_body_are_dropped():
    ball = sphere(3)
    drawn = ball.with_vertices(ball.vertices * np.where(ball.vertices[:, 2:] > 0.9, [1, 1, 4], 1))
    axis = np.array([[0.05, 0, z] for z in (0.0, 0.3, 1.5, 2.5, 3.5)])
    [points] = centered_axes([axis], np.array([0.4]), Surface(drawn))
    assert points == pytest.approx(np.array([[0, 0, z] for z in (1.5, 2.5, 3.5)]), abs=0.02)  # the triangles are coarse
