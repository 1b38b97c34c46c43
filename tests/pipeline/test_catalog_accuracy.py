"""Skeletons of the catalog: a bug that moves them by a tenth of a local radius is noticed."""

import numpy as np
import pytest

from lbskel import Skeleton, ground_truth_distances, skeletonize
from lbskel.shapes import make
from lbskel.skeleton.edge_distances import nearest_on_edges

# Vertices, and mean distance to the axis, in local radii, that the skeleton has to keep below: 0.015 where it is good.
# The hand is not here: its fused fingers leave more.
BOUNDS = {
    "limbs": (800, 0.015),
    "tree": (800, 0.015),
    "octopus": (800, 0.03),
    "helix": (800, 0.015),
    "knot": (1500, 0.015),
    "spiked_ring": (800, 0.015),
    "ladder": (800, 0.015),
    "cube_frame": (800, 0.015),
    "dumbbell": (800, 0.015),
    "figure_eight": (800, 0.015),
    "tripod": (800, 0.015),
    "dinosaur": (800, 0.06),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_a_move_by_a_tenth_of_a_radius_is_noticed(name):
    n_vertices, bound = BOUNDS[name]
    shape = make(name, n_vertices=n_vertices)
    skeleton = skeletonize(shape.mesh)
    assert ground_truth_distances(skeleton, shape.truth).accuracy < bound
    radii = nearest_on_edges(shape.truth, skeleton.nodes)[2]
    away = np.random.default_rng(0).normal(size=skeleton.nodes.shape)
    away *= 0.1 * radii[:, None] / np.linalg.norm(away, axis=1, keepdims=True)
    moved = Skeleton(skeleton.nodes + away, skeleton.edges, skeleton.radii)
    assert ground_truth_distances(moved, shape.truth).accuracy > bound
