"""Bodies of voxels: which voxels they consist of, and where their surface lies."""

import numpy as np
import pytest

from benchmarks.voxels import voxel_body
from lbskel import Skeleton
from lbskel.shapes import tube_mesh
from lbskel.skeleton.edge_distances import nearest_on_edges


def test_the_surface_of_voxels_lies_between_those_inside_and_outside_a_tube():
    shape = tube_mesh(Skeleton([[0, 0, 0], [0, 0, 9], [5, 0, 15]], [[0, 1], [1, 2]], [2.0, 2.0, 2.0]))
    body, step = voxel_body(shape, 0.4), 0.4 * 2.0
    assert (body.mesh.is_closed_manifold, body.mesh.n_components, body.mesh.genus) == (True, 1, 0)
    halves = 2 * (body.mesh.vertices - body.mesh.vertices[0]) / step
    assert halves == pytest.approx(np.rint(halves), abs=1e-6)  # centers of voxels, and middles between them
    to_axis, _, radii = nearest_on_edges(
        Skeleton(shape.truth.nodes, shape.truth.edges, shape.truth.radii), body.mesh.vertices
    )
    assert np.abs(to_axis - radii).max() <= 0.5 * step * (1 + 1e-9)
    assert np.abs(to_axis - radii).mean() > 0.1 * step  # steps
    assert body.truth is shape.truth
