"""Weights: partition of unity, bounds, a closed form on a cylinder, the largest kept."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.applications.bone_heat import HEAT, bone_weights, keep_largest
from lbskel.shapes import tube

PARENTS = np.array([-1, 0])


def bar(length=6.0):
    """A tube of radius 1 along x, with two bones that meet in the middle."""
    mesh = tube(np.stack([np.linspace(-length, length, 81), *np.zeros((2, 81))], axis=1), 1.0, sides=42)
    heads, tails = np.array([[-length, 0, 0], [0, 0, 0]]), np.array([[0, 0, 0], [length, 0, 0]])
    return mesh, heads, tails, (mesh.vertices[:, 0] > 0).astype(np.int64)


def test_weights_around_a_joint_decay_by_the_radius():
    """On a tube of radius 1, w'' = c (w - p) along the axis: exp(-sqrt(c) |x|) / 2 from the joint."""
    mesh, heads, tails, own = bar()
    weights = bone_weights(mesh, heads, tails, PARENTS, own)
    x = mesh.vertices[:, 0]
    side = (x < -0.1) & (x > -3)
    expected = 0.5 * np.exp(np.sqrt(HEAT) * x[side])
    assert weights[side, 1] == pytest.approx(expected, abs=0.01)


def test_weights_are_shares_at_any_scale_and_where_vertices_have_no_area():
    mesh, heads, tails, own = bar()
    weights = bone_weights(mesh, heads, tails, PARENTS, own)
    assert weights.sum(axis=1) == pytest.approx(1)
    assert weights.min() >= 0
    small = bone_weights(mesh.with_vertices(1e-6 * mesh.vertices + 3), 1e-6 * heads + 3, 1e-6 * tails + 3, PARENTS, own)
    assert small == pytest.approx(weights, abs=1e-4)  # coordinates of 3 have eight digits of 1e-6
    lonely = Mesh(np.concatenate([mesh.vertices, [[9, 9, 9]]]), np.concatenate([mesh.faces, [[0, 1, 1]]]))
    more = bone_weights(lonely, heads, tails, PARENTS, np.append(own, 1))
    assert more[-1] == pytest.approx([0, 1])
    assert np.isfinite(more).all()


def test_a_vertex_belongs_to_the_nearest_of_the_bones_that_meet():
    """Regions that end too far on one side do not move the joint, and a bone that meets neither is left out."""
    mesh, heads, tails, own = bar()
    x = mesh.vertices[:, 0]
    expected = bone_weights(mesh, heads, tails, PARENTS, own)
    late = bone_weights(mesh, heads, tails, PARENTS, (x > 0.6).astype(np.int64))
    assert np.abs(late - expected).max() < 0.1
    beside = np.array([[5.0, 2, 0], [9.0, 2, 0]])  # outside the tube, nearer to its side than its own bone
    more = bone_weights(mesh, np.vstack([heads, beside[0]]), np.vstack([tails, beside[1]]), np.append(PARENTS, -1), own)
    assert np.abs(more[:, :2] - expected).max() < 1e-9
    assert np.abs(more[:, 2]).max() < 1e-9


def test_the_largest_weights_are_kept():
    weights = np.array([[0.4, 0.3, 0.2, 0.1], [1, 0, 0, 0]])
    assert keep_largest(weights, 2) == pytest.approx(np.array([[4 / 7, 3 / 7, 0, 0], [1, 0, 0, 0]]))
    assert keep_largest(weights, 4) is weights
    equal = np.array([[0.4, 0.3, 0.15, 0.15], [0.25, 0.25, 0.25, 0.25]])
    assert keep_largest(equal, 3) == pytest.approx(np.array([[4 / 7, 3 / 7, 0, 0], [1 / 3, 1 / 3, 1 / 3, 0]]))
