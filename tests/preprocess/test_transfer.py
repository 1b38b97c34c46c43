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
