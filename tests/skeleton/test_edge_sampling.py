"""Points along the edges of a skeleton."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.skeleton.edge_sampling import sample_edges


def test_points_are_the_middles_of_equal_pieces_and_radii_are_linear():
    two = Skeleton([[0, 0, 0], [1, 0, 0], [1, 3, 0]], [[0, 1], [1, 2]], [1.0, 2.0, 5.0])
    points, radii = sample_edges(two, 0.6)
    assert points == pytest.approx(
        np.array([[0.25, 0, 0], [0.75, 0, 0], *([1, 0.3 + 0.6 * k, 0] for k in range(5))]), abs=1e-12
    )
    assert radii == pytest.approx([1.25, 1.75, *(2.3 + 0.6 * k for k in range(5))])


@pytest.mark.parametrize("spacing", [0.1, 0.31, 1.0, 7.0])
def test_the_spacing_is_an_upper_bound_and_every_edge_has_a_point(spacing):
    nodes = np.random.default_rng(0).normal(size=(6, 3))
    skeleton = Skeleton(nodes, [[0, 1], [0, 2], [2, 3], [3, 4], [3, 5]], np.ones(6))
    points, _ = sample_edges(skeleton, spacing)
    n_pieces = np.ceil(skeleton.edge_lengths / spacing)
    assert len(points) == n_pieces.sum() >= len(skeleton.edges)


def test_a_skeleton_without_edges_is_sampled_at_its_nodes():
    points, radii = sample_edges(Skeleton([[1, 2, 3]], [], [4.0]), 0.1)
    assert (points.tolist(), radii.tolist()) == ([[1, 2, 3]], [4])


def test_an_edge_of_length_zero_has_one_point():
    points, _ = sample_edges(Skeleton(np.zeros((2, 3)), [[0, 1]], np.ones(2)), 0.1)
    assert points.tolist() == [[0, 0, 0]]
