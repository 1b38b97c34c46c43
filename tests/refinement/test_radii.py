"""Radii: inscribed, of the own component, and the mean distance to the vertices of a node."""

import numpy as np
import pytest
from helpers import joined, path_in

from lbskel import Mesh, Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.radii import inscribed_radii, mean_radii, own_radii
from lbskel.shapes import capsule, sphere


def test_radii_of_a_ball_and_of_a_cloud():
    mesh = sphere(3)
    center = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.zeros(1), np.zeros(len(mesh.vertices)))
    assert mean_radii(center, mesh).radii[0] == pytest.approx(1, rel=1e-12)
    inscribed = inscribed_radii(center, Surface(mesh)).radii[0]
    assert 0.98 < inscribed < 1  # facets lie a little inside their sphere: 1 - h^2 / 8 at edges of h = 0.14 to 0.2


def test_nodes_without_vertices_take_the_radius_of_their_neighbors():
    mesh = sphere(1)
    skeleton = Skeleton(np.zeros((3, 3)), [[0, 1], [1, 2]], np.zeros(3), np.zeros(len(mesh.vertices)))
    assert mean_radii(skeleton, mesh).radii == pytest.approx([1, 1, 1])


def test_only_neighbors_with_vertices_count_for_a_node_without():
    """Of five nodes in a row, the first and the third have vertices, 1 and 3 away from them."""
    nodes = np.arange(5)[:, None] * np.array([10.0, 0, 0])
    mesh = Mesh([[0, 1, 0], [0, -1, 0], [20, 3, 0]], [[0, 1, 2]])
    skeleton = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [3, 4]], np.zeros(5), [0, 0, 2])
    found = mean_radii(skeleton, mesh)
    assert found.radii.tolist() == [1, 2, 3, 3, 3]
    assert found.radius_kind == "mean"


def test_a_graph_without_any_vertex_has_zero_mean_radii():
    mesh = sphere(1)
    two = Skeleton(np.zeros((3, 3)), [[0, 1]], np.ones(3), np.zeros(len(mesh.vertices)))
    assert mean_radii(two, mesh).radii == pytest.approx([1, 1, 0])


def test_own_radii_do_not_count_the_surfaces_of_other_components():
    """A rod of radius 0.5 with a ball of radius 0.1 about a node inside it."""
    rod, ball = capsule(4.0, 0.5, 32), sphere(3)
    both = joined(rod, ball.with_vertices(0.1 * ball.vertices + [0.15, 0, 0]))
    path = path_in(rod, [[0, 0, -1], [0, 0, 0], [0, 0, 1]])
    node_of_vertex = np.concatenate([path.node_of_vertex, np.full(len(ball.vertices), 3)])
    nodes = np.concatenate([path.nodes, [[0.15, 0, 0], [9, 9, 9]]])
    skeleton = Skeleton(nodes, path.edges, np.full(5, 7.0), node_of_vertex)
    assert inscribed_radii(skeleton, Surface(both)).radii[1] == pytest.approx(0.05, rel=0.05)
    found = own_radii(skeleton, both).radii
    assert found[:3] == pytest.approx(0.5, rel=0.02)
    assert found[3] == pytest.approx(0.1, rel=0.03)
    assert found[4] == 7  # no vertex is mapped to its graph
