"""Closest points on the edges of a skeleton, against closed forms."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.skeleton.edge_distances import nearest_on_edges

BENT = Skeleton([[0, 0, 0], [2, 0, 0], [2, 1, 0], [9, 9, 9]], [[0, 1], [1, 2]], [1.0, 2.0, 4.0, 1.0])


def test_points_beside_before_and_beyond_an_edge():
    points = np.array([[0.5, 0.3, 0], [-3.0, 4, 0], [2.5, 0.25, 0], [2, 3, 0], [9, 9, 9]])
    distances, nearest, radii = nearest_on_edges(BENT, points)
    assert nearest == pytest.approx(np.array([[0.5, 0, 0], [0, 0, 0], [2, 0.25, 0], [2, 1, 0], [9, 9, 9]]))
    assert distances == pytest.approx([0.3, 5, 0.5, 2, 0])  # the last is an isolated node
    assert radii == pytest.approx([1.25, 1, 2.5, 4, 1])


def test_distances_agree_with_those_to_all_segments():
    random = np.random.default_rng(0)
    nodes, points = random.standard_normal((40, 3)).cumsum(axis=0), 5 * random.standard_normal((200, 3))
    edges = np.stack([np.arange(39), np.arange(1, 40)], axis=1)
    start, along = nodes[:-1], np.diff(nodes, axis=0)
    share = np.clip(((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    expected = np.linalg.norm(start + share[..., None] * along - points[:, None], axis=2).min(axis=1)
    assert nearest_on_edges(Skeleton(nodes, edges, np.ones(40)), points)[0] == pytest.approx(expected, abs=1e-12)


def test_where_there_is_no_edge_nodes_are_nearest():
    alone = Skeleton([[0, 0, 0], [4, 0, 0]], np.empty((0, 2)), [1.0, 2.0])
    distances, nearest, radii = nearest_on_edges(alone, np.array([[3.0, 0, 0]]))
    assert (distances.tolist(), nearest.tolist(), radii.tolist()) == ([1], [[4, 0, 0]], [2])


def test_edges_of_no_length_have_the_radius_of_their_node():
    point = Skeleton([[1, 1, 1], [1, 1, 1]], [[0, 1]], [3.0, 3.0])
    distances, _, radii = nearest_on_edges(point, np.array([[1.0, 1, 2]]))
    assert (distances.tolist(), radii.tolist()) == ([1], [3])


def test_no_points_have_no_nearest_ones():
    assert [len(each) for each in nearest_on_edges(BENT, np.empty((0, 3)))] == [0, 0, 0]
