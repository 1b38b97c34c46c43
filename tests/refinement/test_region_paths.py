"""Edges outside led along the regions of their nodes, so that a cycle goes around its tunnel again."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.contraction.cycle_classes import tunnels_missed
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.region_paths import reroute_through_regions
from lbskel.shapes import perforated_plate, sphere, torus


def ring_of(mesh, radius, n=6):
    """A ring of nodes around the axis of a torus, each with the vertices of its sector."""
    angles = 2 * np.pi * np.arange(n) / n
    nodes = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    edges = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
    turn = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) / (2 * np.pi) * n
    return Skeleton(nodes, edges, np.full(n, 0.2), np.round(turn).astype(int) % n)


@pytest.mark.parametrize("radius", [0.1, 0.5, 1.9])
def test_a_ring_beside_the_solid_goes_around_the_tunnel_again(radius):
    mesh = torus(1.0, 0.2)
    ring = ring_of(mesh, radius)
    assert tunnels_missed(ring.nodes, ring.edges, mesh) == 1
    led = reroute_through_regions(ring, Surface(mesh), ring.node_of_vertex)
    assert led.cycle_rank == 1
    assert tunnels_missed(led.nodes, led.edges, mesh) == 0
    assert Surface(mesh).contains(led.nodes).all()
    assert not segments_outside(led.nodes, led.edges, Surface(mesh)).any()


def test_a_ring_inside_stays():
    mesh = torus(1.0, 0.4)
    ring = ring_of(mesh, 1.0, n=12)
    assert np.array_equal(reroute_through_regions(ring, Surface(mesh), ring.node_of_vertex).nodes, ring.nodes)


def test_a_tree_stays():
    mesh = sphere(2)
    stick = Skeleton([[0, 0, 0], [0, 0, 3]], [[0, 1]], np.ones(2), (mesh.vertices[:, 2] > 0.5).astype(int))
    assert reroute_through_regions(stick, Surface(mesh), stick.node_of_vertex) is stick


def test_a_node_without_vertices_keeps_its_edges():
    mesh = torus(1.0, 0.2)
    ring = ring_of(mesh, 0.5)
    without = np.where(ring.node_of_vertex == 2, 1, ring.node_of_vertex)
    led = reroute_through_regions(ring, Surface(mesh), without)
    assert (led.nodes == ring.nodes[2]).all(axis=1).any()
    assert led.cycle_rank == 1


def test_a_path_stays_in_the_two_regions_where_a_shorter_one_leads_through_a_third():
    """Two regions from 0 to 160 and to 320 degrees, with their nodes at 10 and 310, and a third between these."""
    mesh = torus(1.0, 0.1)
    angles = np.radians([10.0, 310.0, 340.0])
    nodes = 1.9 * np.stack([np.cos(angles), np.sin(angles), np.zeros(3)], axis=1)
    turn = np.degrees(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])) % 360
    three = Skeleton(nodes, [[0, 1], [1, 2], [0, 2]], np.full(3, 0.1), np.searchsorted([160.0, 320.0], turn, "right"))
    led = reroute_through_regions(three, Surface(mesh), three.node_of_vertex)
    assert tunnels_missed(led.nodes, led.edges, mesh) == 0


def test_an_edge_inside_on_the_other_side_of_the_hole_is_led_around_it():
    """Two nodes in a plate with one hole, joined by two paths of which one is drawn on the wrong side."""
    mesh = perforated_plate(1)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle, half = (low + high) / 2, 0.4 * (high - low)[0]
    west, north, east, south = middle + half * np.array([[-1, 0, 0], [0, 1, 0], [1, 0, 0], [0, -1, 0]])
    corners = middle + half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
    nodes = np.stack([west, corners[0], north, corners[1], east, corners[2], south, corners[3]])
    edges = np.stack([np.arange(8), (np.arange(8) + 1) % 8], axis=1)
    region = np.linalg.norm(mesh.vertices[:, None] - nodes, axis=2).argmin(axis=1)
    ring = Skeleton(nodes, edges, np.full(8, 0.3), region)
    assert tunnels_missed(ring.nodes, ring.edges, mesh) == 0
    drawn = nodes.copy()
    drawn[[1, 2, 3]] = nodes[[7, 6, 5]] + [0, 0, 0.2]  # all inside, but the cycle goes there and back
    ring = Skeleton(drawn, edges, ring.radii, region)
    assert not segments_outside(drawn, edges, Surface(mesh)).any()
    assert tunnels_missed(ring.nodes, ring.edges, mesh) == 1
    led = reroute_through_regions(ring, Surface(mesh), ring.node_of_vertex)
    assert tunnels_missed(led.nodes, led.edges, mesh) == 0
    assert not segments_outside(led.nodes, led.edges, Surface(mesh)).any()
