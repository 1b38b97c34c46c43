"""The graph of contracted points: samples, links, no triangles, nobody alone."""

import numpy as np

from lbskel import PRESETS, PointCloud, collapse, contract
from lbskel.contraction.point_graph import SAMPLE_RADIUS, collapse_stars
from lbskel.geometry.point_stars import PointStars
from lbskel.operators.star_rings import stars_in_order
from lbskel.shapes import torus


def _graph(points, linked):
    """The graph of points whose rings are those given."""
    faces = [[center, ring[0], ring[-1]] for center, ring in enumerate(linked)]
    stars = PointStars(points, faces)
    return collapse_stars(stars, stars)


LINE = np.arange(6)[:, None] * np.array([[1.0, 0, 0]])


def test_points_apart_are_samples_linked_along_their_rings():
    graph = _graph(LINE, [[1, 2], [2, 0], [3, 1], [4, 2], [5, 3], [4, 3]])
    assert len(graph.nodes) == 6
    assert graph.edges.tolist() == [[i, i + 1] for i in range(5)]
    assert graph.nodes[graph.node_of_vertex].tolist() == LINE.tolist()


def test_points_in_one_ball_are_one_sample():
    near = np.concatenate([LINE, LINE + [0, 0.01, 0]])  # the ball has a radius of 0.1
    graph = _graph(near, [[(i + 1) % 12, (i + 2) % 12] for i in range(12)])
    assert len(graph.nodes) <= 6
    distances = np.linalg.norm(near - graph.nodes[graph.node_of_vertex], axis=1)
    assert np.median(distances) <= 0.011


def test_triangles_collapse_to_midpoints():
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0.8, 0], [9, 0, 0]])
    graph = _graph(triangle, [[1, 2], [2, 0], [0, 1], [1, 2]])
    i, j = np.sort(graph.nodes[:, 0])[:2]
    assert len(graph.edges) == len(graph.nodes) - 1
    assert (i, j) != (0.0, 0.5)


def test_a_sample_without_links_is_joined_to_the_nearest():
    apart = np.concatenate([LINE, [[7.0, 0, 0], [7.05, 0, 0], [7.0, 0.05, 0]]])
    graph = _graph(apart, [[1, 2], [2, 0], [3, 1], [4, 2], [5, 3], [4, 3], [7, 8], [6, 8], [6, 7]])
    assert len(np.unique(graph.edges)) == len(graph.nodes) == 7
    assert [5, 6] in graph.edges.tolist()


def test_a_contracted_ring_of_points_is_a_loop():
    cloud = PointCloud(torus(1.0, 0.2).vertices)
    contraction = contract(cloud, PRESETS["cao2010"])
    graph = collapse(contraction)
    assert len(graph.edges) == len(graph.nodes)
    assert abs(np.linalg.norm(graph.nodes, axis=1).mean() - 1) < 0.05
    spacing = np.linalg.norm(graph.nodes[graph.edges[:, 0]] - graph.nodes[graph.edges[:, 1]], axis=1)
    assert spacing.min() > 0.5 * SAMPLE_RADIUS * stars_in_order(cloud).diagonal
