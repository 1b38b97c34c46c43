"""The implicit function of solids made of round cones: distances, blending, cutoff and gradient."""

import numpy as np
import pytest

from lbskel.errors import MeshError
from lbskel.shapes import SHAPES, solid_of
from lbskel.shapes.round_cones import BLEND_WIDTH

ROUNDING = 1e-12  # of sums of a few dozen numbers near 1


def _points_near(solid, n=4000, spread=0.15, seed=0):
    """Scatter points around the axes of a solid."""
    random = np.random.default_rng(seed)
    return solid.centers[random.integers(len(solid.centers), size=n)] + spread * random.standard_normal((n, 3))


def test_a_round_cone_is_the_union_of_its_spheres():
    start, end, r0, r1 = np.array([0.1, -0.2, 0.3]), np.array([0.9, 0.5, -0.4]), 0.4, 0.15
    solid = solid_of([([start, end], [r0, r1])])
    points = np.random.default_rng(1).uniform(-1, 1.5, (300, 3))
    s = np.linspace(0, 1, 4001)
    centers = start + s[:, None] * (end - start)
    spheres = np.linalg.norm(points[:, None] - centers, axis=2) - (r0 + s * (r1 - r0))
    # Between two samples of spacing h the minimum is off by at most (h/2)^2 / (2 * distance to the nearest center).
    assert np.abs(solid.distance(points, cutoff=3.0) - spheres.min(axis=1)).max() < 1e-6


def test_a_ball_is_a_polyline_of_one_point():
    solid = solid_of([([0.5, 0, 0], 0.3)])
    points = np.random.default_rng(0).standard_normal((50, 3))
    expected = np.linalg.norm(points - [0.5, 0, 0], axis=1) - 0.3
    assert np.abs(solid.distance(points, cutoff=9.0) - expected).max() < ROUNDING


def test_subdividing_a_branch_does_not_change_its_distance():
    whole = solid_of([([[0, 0, 0], [1, 0, 0]], 0.2)])
    subdivided = solid_of([([[0, 0, 0], [0.3, 0, 0], [0.45, 0, 0], [1, 0, 0]], 0.2)])
    points = _points_near(whole)
    assert np.abs(whole.distance(points, cutoff=2.0) - subdivided.distance(points, cutoff=2.0)).max() < ROUNDING


def test_branches_blend_only_where_they_meet():
    trunk, twig = ([[0, 0, -1], [0, 0, 1]], 0.3), ([[0, 0, 0], [1, 0, 0]], 0.1)
    together = solid_of([trunk, twig])
    points = _points_near(together)
    apart = np.stack([solid_of([branch]).distance(points, cutoff=9.0) for branch in (trunk, twig)])
    blended, smaller = together.distance(points, cutoff=9.0), apart.min(axis=0)
    dip = smaller - blended
    width = BLEND_WIDTH * 0.1
    assert dip.min() > -ROUNDING
    assert dip.max() == pytest.approx(width / 4, rel=0.05)  # a quarter of the width, where both are equally near
    unblended = np.abs(apart[0] - apart[1]) > width
    assert unblended.any()
    assert np.abs(dip[unblended]).max() < ROUNDING


@pytest.mark.parametrize("name", ["octopus", "tree", "dinosaur"])
def test_values_below_the_cutoff_do_not_depend_on_it(name):
    solid = SHAPES[name]()
    points = _points_near(solid)
    value = solid.distance(points, cutoff=3.0)
    near = np.abs(value) < 0.01
    assert near.sum() > 100
    assert np.abs(solid.distance(points[near], cutoff=0.01) - value[near]).max() < ROUNDING
    assert (solid.distance(points, cutoff=0.01)[value > 0.01] > 0.01 - ROUNDING).all()


@pytest.mark.parametrize("name", ["octopus", "limbs"])
def test_the_function_has_lipschitz_constant_one(name):
    solid = SHAPES[name]()
    points = _points_near(solid)
    moved = points + 0.02 * np.random.default_rng(2).standard_normal(points.shape)
    change = np.abs(solid.distance(points, cutoff=3.0) - solid.distance(moved, cutoff=3.0))
    assert (change <= np.linalg.norm(points - moved, axis=1) + ROUNDING).all()


def test_the_gradient_of_a_ball_points_away_from_its_center():
    points = np.random.default_rng(0).standard_normal((30, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    gradient = solid_of([(np.zeros(3), 1.0)]).gradient(points, step=1e-4)
    # truncation error: step^2 / 6 times a third derivative of at most 3
    assert np.abs(gradient - points).max() < 1e-7


def test_a_sphere_that_contains_its_neighbor_is_refused():
    with pytest.raises(MeshError, match="branch 1 has a sphere inside its neighbor"):
        solid_of([([[0, 0, 0], [1, 0, 0]], 0.1), ([[0, 0, 0], [0.1, 0, 0]], [0.5, 0.1])])


def test_the_thickest_branch_is_blended_over_the_width_of_each_other_branch():
    """The order of the branches and their widths do not depend on the order in which they are given."""
    branches = [([[0, 0, 0], [1, 0, 0]], 0.1), ([[0, 0, -1], [0, 0, 1]], 0.3), ([[0, 0, 0], [0, 1, 0]], 0.2)]
    points = _points_near(solid_of(branches))
    values = solid_of(branches).distance(points, cutoff=9.0)
    assert np.abs(solid_of(branches[::-1]).distance(points, cutoff=9.0) - values).max() < ROUNDING


def test_solids_scale_with_their_coordinates():
    branches = [([[0, 0, -1], [0, 0, 1]], 0.3), ([[0, 0, 0], [1, 0, 0]], [0.1, 0.05])]
    scaled = [(np.multiply(points, 8.0), np.multiply(radii, 8.0)) for points, radii in branches]
    points = _points_near(solid_of(branches))
    values = solid_of(branches).distance(points, cutoff=9.0)
    assert np.abs(solid_of(scaled).distance(8 * points, cutoff=72.0) / 8 - values).max() < ROUNDING


def test_segments_are_at_most_half_a_radius_long():
    solid = solid_of([([[0, 0, 0], [1, 0, 0], [1, 2, 0]], [0.4, 0.2, 0.3])])
    start, end = solid.centers[solid.segments].transpose(1, 0, 2)
    assert (np.linalg.norm(end - start, axis=1) <= 0.5 * solid.radii.min(axis=1) + ROUNDING).all()
    assert np.linalg.norm(end - start, axis=1).sum() == pytest.approx(3.0)
    assert solid.radii.max() == pytest.approx(0.4)
    assert solid.radii.min() == pytest.approx(0.2)


def test_the_nearest_branch_of_a_point():
    """Branches are numbered by decreasing radius."""
    solid = solid_of([([[0, 0, 0], [3, 0, 0]], 0.2), ([[0, 0, 0], [0, 3, 0]], 0.5)])
    points = np.array([[2.0, 0, 0.2], [0, 2, 0.5], [2.0, 0, 0], [0, 1, 0.1]])
    assert solid.nearest_branches(points).tolist() == [1, 0, 1, 0]
