"""Moves and paths that pass another side of a tunnel: told, and taken back edge by edge."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.tunnel_sides import (
    edges_that_pass,
    keep_sides,
    n_tunnels_missed,
    on_their_side,
    paths_that_pass,
)
from lbskel.shapes import perforated_plate, torus


def square(center, half_width, n=24):
    """Points around a center, in a plane across the third axis."""
    angle = 2 * np.pi * np.arange(n) / n
    direction = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return np.array(center) + half_width * direction / np.abs(direction).max(axis=1, keepdims=True)


@pytest.fixture(scope="module")
def plate():
    """A square plate with one square hole in its middle, and the middle of the plate."""
    mesh = perforated_plate(1)
    return Surface(mesh), (mesh.vertices.max(axis=0) + mesh.vertices.min(axis=0)) / 2, np.ptp(mesh.vertices[:, 0])


def ring_around_the_hole(plate):
    """A ring of 24 nodes inside the plate, around the hole."""
    _, middle, width = plate
    nodes = square(middle, 0.4 * width)
    return Skeleton(nodes, np.stack([np.arange(24), (np.arange(24) + 1) % 24], axis=1), np.ones(24))


def test_nodes_drawn_past_the_hole_stay_and_the_others_move(plate):
    """Half of the nodes move to the other side of the hole, and one a little along the ring."""
    surface, middle, width = plate
    ring = ring_around_the_hole(plate)
    assert n_tunnels_missed(ring, surface) == 0
    moved = np.array(ring.nodes)
    moved[2] = (moved[2] + moved[3]) / 2
    moved[8:17, 0] = middle[0] + 0.4 * width
    assert edges_that_pass(ring.nodes, moved, ring.edges, surface).any()
    kept = keep_sides(ring, moved, surface)
    assert n_tunnels_missed(Skeleton(kept, ring.edges, ring.radii), surface) == 0
    assert np.array_equal(kept[2], moved[2])
    assert not edges_that_pass(ring.nodes, kept, ring.edges, surface).any()


def test_moves_on_the_same_side_are_all_kept(plate):
    surface, *_ = plate
    ring = ring_around_the_hole(plate)
    moved = ring.nodes + [0.0, 0.0, 0.01]
    assert keep_sides(ring, moved, surface) is moved


def test_a_path_through_the_other_half_passes_the_hole(plate):
    surface, middle, width = plate
    ring = square(middle, 0.4 * width)
    upper, lower = ring[:13], np.concatenate([ring[:1], ring[:11:-1]])
    assert np.array_equal(upper[-1], lower[-1])
    nearer = np.concatenate([ring[:1], square(middle, 0.35 * width)[1:12], ring[12:13]])
    assert paths_that_pass([upper, upper, upper], [lower, nearer, upper[1:-1]], surface).tolist() == [
        True,
        False,
        False,
    ]


def test_of_two_new_paths_the_one_past_the_hole_is_not_taken(plate):
    surface, middle, width = plate
    ring = square(middle, 0.4 * width)
    upper, lower = ring[:13], np.concatenate([ring[:1], ring[:11:-1]])
    nearer = np.concatenate([ring[:1], square(middle, 0.35 * width)[1:12], ring[12:13]])
    first, second = on_their_side([upper, upper], [lower, nearer], surface)
    assert first is upper
    assert second is nearer


def test_a_count_is_of_the_nodes_and_of_the_edges(plate):
    """Counts are cached: the open ring has the nodes of the closed one, and the small ring its edges."""
    surface, middle, width = plate
    ring = ring_around_the_hole(plate)
    is_open = Skeleton(ring.nodes, ring.edges[:-1], ring.radii)
    beside = Skeleton(square(middle + [0.4 * width, 0, 0], 0.01 * width), ring.edges, ring.radii)
    for _ in range(2):
        assert [n_tunnels_missed(each, surface) for each in (ring, is_open, beside)] == [0, 1, 1]


def test_a_graph_in_two_parts_is_not_judged():
    mesh = torus(1.0, 0.3, 24, 12)
    two = Skeleton([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1], [2, 3]], np.ones(4))
    assert n_tunnels_missed(two, Surface(mesh)) == 0
