"""The implicit solids, their surfaces and the skeletons that they are built around."""

import numpy as np
import pytest

from lbskel.errors import MeshError
from lbskel.shapes import SHAPES, marching_cubes, project, solid_of
from lbskel.shapes.solid import BLEND

ROUNDING = 1e-12  # of sums of a few dozen numbers near 1


def _points_near(solid, n=4000, spread=0.15, seed=0):
    """Points scattered around the axes of a solid."""
    random = np.random.default_rng(seed)
    return solid.centers[random.integers(len(solid.centers), size=n)] + spread * random.standard_normal((n, 3))


def test_a_round_cone_is_the_union_of_its_spheres():
    start, end, r0, r1 = np.array([0.1, -0.2, 0.3]), np.array([0.9, 0.5, -0.4]), 0.4, 0.15
    solid = solid_of([([start, end], [r0, r1])])
    points = np.random.default_rng(1).uniform(-1, 1.5, (300, 3))
    s = np.linspace(0, 1, 4001)
    centers = start + s[:, None] * (end - start)
    spheres = np.linalg.norm(points[:, None] - centers, axis=2) - (r0 + s * (r1 - r0))
    # Between two samples half a spacing h from the best one the distance rises by at most (h/2)^2 / (2 * nearest).
    assert np.abs(solid.distance(points, reach=3.0) - spheres.min(axis=1)).max() < 1e-6


def test_a_ball_is_a_polyline_of_one_point():
    solid = solid_of([([0.5, 0, 0], 0.3)])
    points = np.random.default_rng(0).standard_normal((50, 3))
    expected = np.linalg.norm(points - [0.5, 0, 0], axis=1) - 0.3
    assert np.abs(solid.distance(points, reach=9.0) - expected).max() < ROUNDING


def test_nothing_bulges_along_a_branch():
    whole = solid_of([([[0, 0, 0], [1, 0, 0]], 0.2)])
    in_parts = solid_of([([[0, 0, 0], [0.3, 0, 0], [0.45, 0, 0], [1, 0, 0]], 0.2)])
    points = _points_near(whole)
    assert np.abs(whole.distance(points, reach=2.0) - in_parts.distance(points, reach=2.0)).max() < ROUNDING


def test_branches_blend_only_where_they_meet():
    trunk, bough = ([[0, 0, -1], [0, 0, 1]], 0.3), ([[0, 0, 0], [1, 0, 0]], 0.1)
    together = solid_of([trunk, bough])
    points = _points_near(together)
    apart = np.stack([solid_of([branch]).distance(points, reach=9.0) for branch in (trunk, bough)])
    blended, least = together.distance(points, reach=9.0), apart.min(axis=0)
    dip = least - blended
    width = BLEND * 0.1
    assert dip.min() > -ROUNDING
    assert dip.max() == pytest.approx(width / 4, rel=0.05)  # a quarter of the width, where both are equally near
    far = np.abs(apart[0] - apart[1]) > width
    assert far.any()
    assert np.abs(dip[far]).max() < ROUNDING


@pytest.mark.parametrize("name", ["octopus", "tree", "dinosaur"])
def test_the_value_does_not_depend_on_the_reach(name):
    solid = SHAPES[name]()
    points = _points_near(solid)
    value = solid.distance(points, reach=3.0)
    near = np.abs(value) < 0.01
    assert near.sum() > 100
    assert np.abs(solid.distance(points[near], reach=0.01) - value[near]).max() < ROUNDING
    assert (solid.distance(points, reach=0.01)[value > 0.01] > 0.01 - ROUNDING).all()


@pytest.mark.parametrize("name", ["octopus", "limbs"])
def test_the_function_is_no_steeper_than_a_distance(name):
    solid = SHAPES[name]()
    points = _points_near(solid)
    moved = points + 0.02 * np.random.default_rng(2).standard_normal(points.shape)
    change = np.abs(solid.distance(points, reach=3.0) - solid.distance(moved, reach=3.0))
    assert (change <= np.linalg.norm(points - moved, axis=1) + ROUNDING).all()


def test_the_gradient_of_a_ball_points_away_from_its_center():
    points = np.random.default_rng(0).standard_normal((30, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    gradient = solid_of([(np.zeros(3), 1.0)]).gradient(points, step=1e-4)
    assert (
        np.abs(gradient - points).max() < 1e-7
    )  # the differences err by step^2 / 2 of a third derivative of 3 at most


def test_a_sphere_inside_its_neighbor_is_refused():
    with pytest.raises(MeshError, match="branch 1 has a sphere inside its neighbor"):
        solid_of([([[0, 0, 0], [1, 0, 0]], 0.1), ([[0, 0, 0], [0.1, 0, 0]], [0.5, 0.1])])


def test_truth_joins_branches_and_knows_the_thickness_at_their_joints():
    solid = solid_of([([[0, 0, -1], [0, 0, 0], [0, 0, 1]], 0.3), ([[0, 0, 0], [1, 0, 0]], [0.1, 0.05])])
    truth = solid.truth
    assert (truth.n_tips, truth.genus, len(truth.junctions)) == (3, 0, 1)
    joint, tip = (np.flatnonzero((truth.nodes == place).all(axis=1))[0] for place in ([0, 0, 0], [1, 0, 0]))
    assert truth.radii[joint] == pytest.approx(0.3)
    assert truth.radii[tip] == pytest.approx(0.05)
    assert truth.length == pytest.approx(3.0)


def test_truth_is_sampled_evenly_with_both_ends():
    truth = solid_of([([[0, 0, 0], [2, 0, 0]], [0.4, 0.2])]).truth
    points, radii = truth.sample(0.3)
    x = np.sort(points[:, 0])
    assert np.allclose(np.diff(x), 2 / 7)  # seven steps are the fewest that are no longer than 0.3
    assert (x[0], x[-1]) == (0.0, 2.0)
    assert np.allclose(radii, 0.4 - 0.1 * points[:, 0])


def test_truth_of_a_loop_is_sampled_all_around():
    points, radii = SHAPES["knot"]().truth.sample(0.1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.array_equal(points[0], points[-1])
    assert steps.max() <= 0.1 + ROUNDING
    assert np.allclose(radii, 0.16)


def test_marching_cubes_of_a_ball():
    ball = solid_of([(np.zeros(3), 1.0)])
    volumes = []
    for step in (0.2, 0.1):
        raw = marching_cubes(ball, step)
        assert raw.is_closed_manifold
        assert (raw.genus, raw.n_components) == (0, 1)
        on_it = project(ball, raw.vertices, step=step)
        assert np.abs(np.linalg.norm(on_it, axis=1) - 1).max() < ROUNDING
        volumes.append(raw.volume)
    errors = 4 * np.pi / 3 - np.array(volumes)
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)  # second order in the step, and inscribed
    assert errors[1] > 0
