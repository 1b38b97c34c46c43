"""Weights: partition of unity, bounds, a closed form on a cylinder, the largest kept."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.applications.bone_heat import HEAT, bone_weights, keep_largest
from lbskel.shapes import tube


def bar(length=20.0):
    """A tube of radius 1 along x, with two bones that meet in the middle."""
    mesh = tube(np.stack([np.linspace(-length, length, 161), *np.zeros((2, 161))], axis=1), 1.0, sides=24)
    heads, tails = np.array([[-length, 0, 0], [0, 0, 0]]), np.array([[0, 0, 0], [length, 0, 0]])
    return mesh, heads, tails, (mesh.vertices[:, 0] > 0).astype(np.int64)


def test_weights_around_a_joint_decay_by_the_radius():
    """On a tube of radius 1, w'' = c (w - p) along the axis: exp(-sqrt(c) |x|) / 2 from the joint."""
    mesh, heads, tails, own = bar()
    weights = bone_weights(mesh, heads, tails, own)
    x = mesh.vertices[:, 0]
    side = (x < -0.1) & (x > -3)
    expected = 0.5 * np.exp(np.sqrt(HEAT) * (x[side] - 0.125))  # the joint is between the sections at 0 and 0.25
    assert weights[side, 1] == pytest.approx(expected, abs=0.01)


def test_weights_are_shares_at_any_scale_and_where_vertices_have_no_area():
    mesh, heads, tails, own = bar()
    weights = bone_weights(mesh, heads, tails, own)
    assert weights.sum(axis=1) == pytest.approx(1)
    assert weights.min() >= 0
    small = bone_weights(mesh.with_vertices(1e-6 * mesh.vertices + 3), 1e-6 * heads + 3, 1e-6 * tails + 3, own)
    assert small == pytest.approx(weights, abs=1e-4)  # coordinates of 3 have eight digits of 1e-6
    lonely = Mesh(np.concatenate([mesh.vertices, [[9, 9, 9]]]), np.concatenate([mesh.faces, [[0, 1, 1]]]))
    more = bone_weights(lonely, heads, tails, np.append(own, 1))
    assert more[-1] == pytest.approx([0, 1])
    assert np.isfinite(more).all()


def test_the_largest_weights_are_kept():
    weights = np.array([[0.4, 0.3, 0.2, 0.1], [1, 0, 0, 0]])
    assert keep_largest(weights, 2) == pytest.approx(np.array([[4 / 7, 3 / 7, 0, 0], [1, 0, 0, 0]]))
    assert keep_largest(weights, 4) is weights
