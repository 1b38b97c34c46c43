"""The known skeleton of a shape: its topology, its radii and its samples."""

import numpy as np
import pytest

from lbskel.shapes import SHAPES, Shape, Truth, solid_of, sphere

ROUNDING = 1e-12  # of sums of a few dozen numbers near 1


def test_branches_are_joined_and_the_radius_at_a_joint_is_that_of_the_thickest():
    solid = solid_of([([[0, 0, -1], [0, 0, 0], [0, 0, 1]], 0.3), ([[0, 0, 0], [1, 0, 0]], [0.1, 0.05])])
    truth = solid.truth
    assert (truth.n_tips, truth.genus, len(truth.junctions)) == (3, 0, 1)
    joint, tip = (np.flatnonzero((truth.nodes == position).all(axis=1))[0] for position in ([0, 0, 0], [1, 0, 0]))
    assert truth.radii[joint] == pytest.approx(0.3)
    assert truth.radii[tip] == pytest.approx(0.05)
    assert truth.length == pytest.approx(3.0)


def test_samples_are_evenly_spaced_and_include_both_ends():
    truth = solid_of([([[0, 0, 0], [2, 0, 0]], [0.4, 0.2])]).truth
    points, radii = truth.sample(0.3)
    x = np.sort(points[:, 0])
    assert np.allclose(np.diff(x), 2 / 7)  # seven is the smallest number of steps of at most 0.3
    assert (x[0], x[-1]) == (0.0, 2.0)
    assert np.allclose(radii, 0.4 - 0.1 * points[:, 0])


def test_samples_of_a_loop_end_where_they_start():
    points, radii = SHAPES["knot"]().truth.sample(0.1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.array_equal(points[0], points[-1])
    assert steps.max() <= 0.1 + ROUNDING
    assert np.allclose(radii, 0.16)


def test_every_branch_is_sampled_with_its_own_radii():
    truth = Truth([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 4]], [[0, 1], [0, 2], [0, 3]], [1.0, 2.0, 3.0, 5.0])
    points, radii = truth.sample(0.5)
    assert len(points) == 3 + 5 + 9
    x, y, z = points.T
    assert np.allclose(radii, 1 + x + y + z)
    assert (truth.genus, truth.n_tips) == (0, 3)


def test_genus_is_the_number_of_independent_cycles():
    square = Truth([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]], np.ones(4))
    assert (square.genus, square.n_tips) == (2, 0)


def test_a_shape_holds_its_mesh_and_its_truth():
    ball = solid_of([(np.zeros(3), 1.0)])
    shape = Shape(sphere(2), ball.truth, "ball")
    assert (
        np.abs(np.linalg.norm(shape.mesh.vertices - shape.truth.nodes[0], axis=1) - shape.truth.radii[0]).max() < 1e-12
    )
