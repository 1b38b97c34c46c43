"""Radii: inscribed, of the own component, and the mean distance of a node's vertices from it or from its axis."""

import numpy as np
import pytest
from helpers import joined, path_in

from lbskel import Mesh, Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.radii import inscribed_radii, mean_axis_distances, mean_radii, own_radii
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


@pytest.mark.parametrize("n_nodes", [3, 9, 33])
def test_the_mean_distance_from_the_axis_of_a_rod_is_its_radius_whatever_the_spacing(n_nodes):
    rod = capsule(4.0, 0.5, 32)
    path = path_in(rod, np.linspace([0, 0, -2], [0, 0, 2], n_nodes))
    found = mean_axis_distances(path, rod.vertices)
    assert found == pytest.approx(0.5, rel=1e-9)  # beyond a tip, distances are from the tip


def test_noise_does_not_change_the_mean_distance_from_the_axis():
    """Noise of a tenth of the radius makes inscribed balls 13 to 28 % smaller."""
    rod = capsule(4.0, 0.5, 32)
    heights = np.random.default_rng(0).normal(scale=0.05, size=len(rod.vertices))
    away = rod.vertices * [1, 1, 0]
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
    path = path_in(rod, np.linspace([0, 0, -1.5], [0, 0, 1.5], 7))
    rough = rod.with_vertices(rod.vertices + heights[:, None] * away)
    assert mean_axis_distances(path, rough.vertices)[1:-1] == pytest.approx(0.5, rel=0.03)
    assert (inscribed_radii(path, Surface(rough)).radii[1:-1] < 0.45).all()


def test_distances_at_a_junction_and_at_a_single_node_are_from_the_node():
    mesh = Mesh([[0, 3, 4], [0, -3, 4], [9, 0, 2]], [[0, 1, 2]])
    star = Skeleton(
        [[0, 0, 0], [0, 0, 9], [0, 9, 0], [0, -9, 0], [9, 0, 0]], [[0, 1], [0, 2], [0, 3]], np.zeros(5), [0, 0, 4]
    )
    assert mean_axis_distances(star, mesh.vertices).tolist() == [5, 5, 5, 5, 2]


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
    assert found[4] == Surface(both).distance(nodes[4:])  # no vertex is mapped to its graph
