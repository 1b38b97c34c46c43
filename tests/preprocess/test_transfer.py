"""The vertex map to a remeshed surface: normals agree, and patches are connected."""

import numpy as np
import pytest
from helpers import patches_are_connected

from lbskel.preprocess.transfer import transfer_map
from lbskel.shapes import sphere


def test_vertices_of_a_thin_slab_are_mapped_to_their_own_side():
    """The two sides of the slab are nearer to each other than vertices on one side."""
    slab = sphere(4)
    slab = slab.with_vertices(slab.vertices * [1, 1, 0.01])
    other = sphere(3)
    other = other.with_vertices(other.vertices * [1, 1, 0.01])
    result = transfer_map(slab, other)
    height = slab.vertices[:, 2]
    is_clear = np.abs(height) > 0.002
    assert (np.sign(other.vertices[result.vertex_map.indices, 2]) == np.sign(height))[is_clear].mean() > 0.99
    assert patches_are_connected(slab, result.vertex_map.indices)
    assert np.asarray(result.weights.sum(axis=1)).ravel() == pytest.approx(np.ones(len(slab.vertices)))


def test_vertices_are_mapped_to_the_side_with_their_normal_even_if_the_other_is_nearer():
    """The target is shifted by three quarters of its thickness: its bottom is nearer to the top than its own top is."""
    slab = sphere(4)
    slab = slab.with_vertices(slab.vertices * [1, 1, 0.01])
    target = slab.with_vertices(slab.vertices + [0, 0, 0.015])
    indices = transfer_map(slab, target).vertex_map.indices
    is_top = slab.vertices[:, 2] > 0.008
    assert is_top.sum() > 100
    assert (target.vertices[indices[is_top], 2] > 0.015).mean() > 0.99
