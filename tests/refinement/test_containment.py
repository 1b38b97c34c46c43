"""Containment: which segments leave the surface, and paths that stay inside."""

import numpy as np
import pytest
from helpers import joined, loop_in, moved, path_in

from lbskel import Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import (
    N_SAMPLES,
    _on_their_side,
    inside_fraction,
    interior_paths,
    paths_outside,
    reroute_inside,
    segments_outside,
)
from lbskel.refinement.tunnel_sides import n_tunnels_missed, paths_that_pass
from lbskel.shapes import capsule, cylinder, perforated_plate, sphere, torus, tube


def test_a_segment_is_outside_where_its_middle_or_either_end_is():
    """In a torus of radii 1 and 0.3, where the middle of a chord is 0.87 from the center, or 0.5 over 120 degrees."""
    turn = np.array([0, np.pi / 3, 2 * np.pi / 3, 0])
    nodes = np.stack([np.cos(turn), np.sin(turn), [0, 0, 0, 1.0]], axis=1)
    edges = np.array([[0, 1], [0, 2], [0, 3], [3, 0]])
    assert segments_outside(nodes, edges, Surface(torus(1.0, 0.3, 96, 32))).tolist() == [False, True, True, True]


def test_nodes_and_edges_outside_are_brought_inside():
    t = np.linspace(0, np.pi, 60)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    surface = Surface(mesh)
    straight = path_in(mesh, [[1, 0.15, 0], [0, 1.3, 0], [-1, 0.15, 0]])
    assert inside_fraction(straight, surface) < 0.5
    rerouted = reroute_inside(straight, surface)
    assert surface.contains(rerouted.nodes).all()
    assert inside_fraction(rerouted, surface) == 1.0
    assert np.array_equal(rerouted.radii[2:], surface.distance(rerouted.nodes[2:]))  # the two kept nodes keep theirs
    assert (rerouted.n_components, rerouted.cycle_rank) == (1, 0)
    assert len(rerouted.tips) == 2


def test_a_rerouted_part_begins_and_ends_in_the_middle_of_the_solid():
    """Half a ring, and nodes that drift to its inner side before they leave it, over sixty degrees of the ring."""
    t = np.linspace(0, np.pi, 60)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    turn = np.radians([10, 20, 30, 40, 50, 60, 120, 130, 140, 150, 160, 170])
    from_center = np.array([1, 1, 1, 0.99, 0.95, 0.91, 0.91, 0.95, 0.99, 1, 1, 1])
    drifting = path_in(mesh, np.stack([from_center * np.cos(turn), from_center * np.sin(turn), 0 * turn], axis=1))
    surface = Surface(mesh)
    assert surface.distance(drifting.nodes).min() < 0.02
    assert surface.distance(reroute_inside(drifting, surface).nodes).min() > 0.08


def test_a_rerouted_loop_stays_a_loop():
    mesh = torus(1.0, 0.1, 64, 16)
    surface = Surface(mesh)
    for n_nodes, shift in ((5, 0.0), (9, 0.25)):  # the edges alone lie outside, all of them; then every node does, too
        angle = np.linspace(0, 2 * np.pi, n_nodes, endpoint=False)
        loop = loop_in(mesh, np.stack([np.cos(angle) + shift, np.sin(angle), 0 * angle], axis=1))
        assert shift > 0 or segments_outside(loop.nodes, loop.edges, surface).all()
        rerouted = reroute_inside(loop, surface)
        assert rerouted.cycle_rank == 1
        if shift == 0:
            assert inside_fraction(rerouted, surface) == 1.0
            turns = np.arctan2(rerouted.nodes[:, 1], rerouted.nodes[:, 0])
            assert np.diff(np.sort(turns)).max() < np.radians(60)  # and goes around the hole


def test_points_that_are_near_in_space_are_joined_along_the_tube():
    t = np.linspace(0, 1.9 * np.pi, 120)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    P = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)[[2, 117, 60, 90, 61]]
    pairs = np.array([[0, 1], [0, 2], [2, 3], [2, 4]])
    paths = interior_paths(P, pairs, Surface(mesh))
    assert [len(path) > 1 for path in paths] == [True, True, True, False]
    lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in paths[:3]]
    assert lengths[0] > 1.5 * lengths[1] > 1.5 * lengths[2] > 1  # half a circle is longer than a fourth


def test_a_segment_is_sampled_along_its_whole_length():
    """Three balls in a row: the ends and the middle of a segment through all are inside, the gaps are not."""
    ball = sphere(2)
    row = joined(moved(ball, -3.0), ball, moved(ball, 3.0))
    nodes = np.array([[-3.0, 0, 0], [3, 0, 0], [-2.5, 0, 0]])
    assert segments_outside(nodes, np.array([[0, 1], [0, 2]]), Surface(row)).tolist() == [True, False]


def test_the_inside_fraction_is_a_fraction_of_the_length():
    mesh = capsule(4.0, 0.5, 32)  # from -2.5 to 2.5 on its axis
    uneven = path_in(mesh, [[0, 0, -4], [0, 0, -1], [0, 0, 0], [0, 0, 4]])
    # samples at the middles of the parts of an edge: at each crossing half a part of its edge, of 3 and of 4, is unsure
    limit = (3 + 4) / N_SAMPLES / 2 / 8
    assert inside_fraction(uneven, Surface(mesh)) == pytest.approx(5 / 8, abs=1.001 * limit)
    assert inside_fraction(path_in(mesh, [[0, 0, -2], [0, 0, 2]]), Surface(mesh)) == 1
    assert inside_fraction(path_in(mesh, [[0, 0, 3], [0, 0, 9]]), Surface(mesh)) == 0
    points = Skeleton([[0, 0, 0], [9, 0, 0]], [], np.ones(2))
    assert inside_fraction(points, Surface(mesh)) == 0.5


def test_within_a_tolerance_outside_counts_as_inside():
    """Two paths along a rod of radius 0.5, 0.2 and 0.4 outside, with a tolerance of 0.3 at all nodes or at one."""
    mesh = capsule(4.0, 0.5, 64)
    surface = Surface(mesh)
    near, far = (path_in(mesh, [[x, 0, -1], [x, 0, 0], [x, 0, 1]]) for x in (0.7, 0.9))
    assert (inside_fraction(near, surface), inside_fraction(near, surface, 0.3)) == (0, 1)
    assert (inside_fraction(far, surface, 0.3), inside_fraction(far, surface, 0.5)) == (0, 1)
    # an edge has the smaller tolerance of its ends
    assert inside_fraction(near, surface, np.array([0.3, 0.3, 0.1])) == 0.5
    assert inside_fraction(Skeleton([[0.7, 0, 0], [0.9, 0, 0]], [], np.ones(2)), surface, 0.3) == 0.5


def test_a_long_edge_counts_by_its_points_though_its_ends_are_within_the_tolerance():
    mesh = sphere(3)
    surface = Surface(mesh)
    over = path_in(mesh, [[-2.0, 1.1, 0], [0, 1.1, 0], [2.0, 1.1, 0]])  # 0.1 outside in the middle, 1.28 at the ends
    within = 2 * np.sqrt(1.3**2 - 1.1**2) / 4  # of the length, at most 0.3 outside
    assert inside_fraction(over, surface, 0.3) == pytest.approx(within, abs=1.001 / 12)


def test_a_tip_outside_is_moved_as_far_inside_as_it_was_outside():
    mesh = capsule(4.0, 0.5, 64)
    path = path_in(mesh, [[0, 0, -1], [0, 0, 0], [0.8, 0, 1]])
    moved_in = reroute_inside(path, Surface(mesh)).nodes
    # 0.3 outside the side of radius 0.5, so 0.3 inside it
    assert np.linalg.norm(moved_in - [0.2, 0, 1], axis=1).min() < 0.01
    far = reroute_inside(path_in(mesh, [[0, 0, -1], [0, 0, 0], [3.0, 0, 1]]), Surface(mesh)).nodes
    assert np.linalg.norm(far - [0, 0, 1], axis=1).min() < 0.01  # not past the middle


def test_the_vertices_of_a_rerouted_part_stay_at_their_share_of_its_length():
    t = np.linspace(0, np.pi, 60)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    path = path_in(mesh, [[1, 0.15, 0], [0, 1.3, 0], [-1, 0.15, 0]])
    rerouted = reroute_inside(path, Surface(mesh))
    of_middle = rerouted.nodes[rerouted.node_of_vertex[path.node_of_vertex == 1]]
    assert np.abs(of_middle[:, 0]).max() < 0.1  # half the way, where the nodes are half a radius apart


def test_a_path_below_the_surface_is_no_deeper_than_its_ends():
    """In half a torus, where ends half a radius below the surface are joined along the outer side."""
    mesh = torus(1.0, 0.3, 96, 32)
    ends = np.array([[1.15, 0, 0], [-1.15, 0, 0]])
    surface = Surface(mesh)
    [path] = interior_paths(ends, np.array([[0, 1]]), surface)
    assert surface.contains(path).all()
    assert surface.distance(path)[3:-3].min() > 0.1
    assert surface.distance(path).max() < 0.3


def test_a_segment_is_outside_where_only_its_end_is():
    """By less than the distance between samples."""
    surface = Surface(capsule(4.0, 0.5, 48))
    nodes = np.array([[0, 0, 0], [0, 0, 2.49], [0, 0, 2.51]])
    assert segments_outside(nodes, np.array([[0, 1], [0, 2], [2, 0]]), surface).tolist() == [False, True, True]


def test_a_rerouted_part_passes_the_hole_on_its_side():
    """A ring in a plate with one hole leaves the plate below along one side; the way around the hole is the shorter."""
    surface = Surface(perforated_plate(1))
    low, high = surface.mesh.vertices.min(axis=0), surface.mesh.vertices.max(axis=0)
    middle, half = (low + high) / 2, 0.4 * (high - low)[0]
    corners = middle + half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    ring = Skeleton(corners, [[0, 1], [1, 2], [2, 3], [0, 3]], np.ones(4))
    assert n_tunnels_missed(ring, surface) == 0
    assert n_tunnels_missed(reroute_inside(ring, surface), surface) == 0
    part, path = np.arange(4), corners[3] + np.linspace(0.1, 0.9, 9)[:, None] * (corners[0] - corners[3])
    (beside,) = _on_their_side([corners[part]], [path[::-1]], surface)
    assert len(beside) > 2  # not the two corners between the ends
    whole = np.concatenate([corners[:1], beside, corners[3:]])
    assert not paths_that_pass([corners], [whole], surface).any()
    assert surface.contains(whole).all()


def test_paths_outside_are_told_from_those_inside():
    surface = Surface(sphere(2))
    inside, outside = np.array([[-0.5, 0, 0], [0.5, 0, 0]]), np.array([[0.0, 0, 0], [0, 0, 2], [0, 0, 0]])
    assert paths_outside([inside, outside, inside[:1]], surface).tolist() == [False, True, False]
    assert paths_outside([], surface).tolist() == []


def test_an_edge_without_length_on_the_surface_is_measured_without_a_warning():
    ball = sphere(2)
    surface = Surface(ball)
    edges = np.repeat(np.arange(len(ball.vertices)), 2).reshape(
        -1, 2
    )  # from each vertex to itself; some count as inside
    assert np.array_equal(segments_outside(ball.vertices, edges, surface), ~surface.contains(ball.vertices))


@pytest.mark.parametrize("height", [1.5, 1.6])
def test_what_is_within_a_cut_is_inside(height):
    """Short open tubes, whose edges from the cuts have one end within the radius of the cut."""
    skeleton = skeletonize(cylinder(0.5, height, 32, 1 + round(10 * height)))
    assert skeleton.length == pytest.approx(height, abs=0.01)
    assert skeleton.report["score"]["measures"]["inside_fraction"] == 1
