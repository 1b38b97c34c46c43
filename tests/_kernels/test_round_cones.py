"""Nearest round cones, against the balls of which they are the union."""

import numpy as np
import pytest

rng = np.random.default_rng(3)
POSITIONS, RADII = rng.normal(size=(6, 3)), rng.uniform(0.1, 0.4, 6)
EDGES = np.array([[0, 1], [1, 2], [1, 3], [3, 4], [4, 5]])
FIRST, EDGES_OF_BALL = np.array([0, 1, 4, 5, 7, 9, 10]), np.array([0, 0, 1, 2, 1, 2, 3, 3, 4, 4])
POINTS = rng.normal(scale=2, size=(40, 3))
ALL_BALLS = np.tile(np.arange(6), (len(POINTS), 1))


def test_the_distance_from_a_cone_is_that_from_the_nearest_ball_between_its_ends(kernel):
    nearest, feet = kernel.nearest_cones(POINTS, ALL_BALLS, POSITIONS, RADII, EDGES, FIRST, EDGES_OF_BALL)
    share = np.linspace(0, 1, 10_001)[:, None, None]
    i, j = EDGES.T
    centers, radii = (
        (1 - share) * POSITIONS[i] + share * POSITIONS[j],
        (1 - share[..., 0]) * RADII[i] + share[..., 0] * RADII[j],
    )
    for row, point in enumerate(POINTS):
        distances = np.linalg.norm(point - centers, axis=2) - radii
        along = distances[:, nearest[row]]
        assert along.min() == pytest.approx(distances.min(), abs=1e-12)  # at a shared end, two cones are as near
        assert feet[row, 0] == pytest.approx(share[along.argmin(), 0, 0], abs=1e-4)  # the step of the samples
        assert feet[row, 2] == pytest.approx(along.min(), abs=1e-6)
    share, radius = feet[:, :1], feet[:, 1]
    i, j = EDGES[nearest].T
    assert radius == pytest.approx((1 - share[:, 0]) * RADII[i] + share[:, 0] * RADII[j])
    foot = (1 - share) * POSITIONS[i] + share * POSITIONS[j]
    assert foot + feet[:, 3:] * (radius + feet[:, 2])[:, None] == pytest.approx(POINTS, abs=1e-12)


def test_only_edges_of_the_given_balls_count(kernel):
    balls = np.full((len(POINTS), 1), 5)
    nearest, _ = kernel.nearest_cones(POINTS, balls, POSITIONS, RADII, EDGES, FIRST, EDGES_OF_BALL)
    assert set(nearest.tolist()) == {4}


def test_arrays_of_other_lengths_are_refused(kernel):
    with pytest.raises(ValueError, match="balls for each point"):
        kernel.nearest_cones(POINTS, ALL_BALLS[1:], POSITIONS, RADII, EDGES, FIRST, EDGES_OF_BALL)


def test_compiled_or_not_is_the_same(assert_same):
    assert_same(lambda kernel: kernel.nearest_cones(POINTS, ALL_BALLS, POSITIONS, RADII, EDGES, FIRST, EDGES_OF_BALL))
