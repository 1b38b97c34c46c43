"""Junctions pulled into another part: moved back to the centroids of their regions, where that is inside."""

import numpy as np
import pytest
from helpers import nearest_rows

from lbskel import Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.pulled_junctions import move_pulled_junctions_back
from lbskel.shapes import capsule, torus

EDGES = [[0, 1], [0, 2], [2, 3], [0, 4], [1, 5], [1, 6], [6, 7]]  # two junctions, and two ends at each


def pair_in(mesh, first, second, outward, radius, region_of_second):
    """Two junctions and their ends; the vertices of a region are mapped to the second, and all others to the first."""
    first, second, outward = map(np.asarray, (first, second, outward))
    steps = [0 * outward, 0 * outward, outward, 2 * outward, -outward, outward, -outward, -2 * outward]
    nodes = np.array([first, second, first, first, first, second, second, second]) + steps
    return Skeleton(nodes, EDGES, np.full(8, radius), np.where(region_of_second, 1, 0))


def on_ring(angle, distance=1.0):
    """A point in the middle of a torus, or nearer to its axis."""
    return distance * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])


def near_angle(mesh, angle, reach):
    """Which vertices of a torus are within a reach of an angle, both in degrees."""
    around = np.degrees(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]))
    return np.abs((around - angle + 180) % 360 - 180) < reach


def test_two_junctions_in_the_middle_of_a_rod_go_to_the_middles_of_its_halves():
    rod = capsule(4.0, 0.6)
    upper = rod.vertices[:, 2] > 0
    skeleton = pair_in(rod, [0, 0, -0.15], [0, 0, 0.15], [0.1, 0, 0], 0.6, upper)
    moved = move_pulled_junctions_back(skeleton, Surface(rod))
    for node, middle in ((0, -1.3), (1, 1.3)):
        assert moved.nodes[node] == pytest.approx([0, 0, middle], abs=0.2)  # the rings of vertices are 0.4 apart
    shift = moved.nodes[1] - skeleton.nodes[1]
    # the node in the middle of an end branch by half, and the ends not at all
    assert np.allclose(moved.nodes[[5, 6, 7]] - skeleton.nodes[[5, 6, 7]], [0 * shift, shift / 2, 0 * shift])
    far = pair_in(rod, [0, 0, -0.35], [0, 0, 0.35], [0.1, 0, 0], 0.6, upper)  # that would not be merged
    assert np.array_equal(move_pulled_junctions_back(far, Surface(rod)).nodes, far.nodes)


def test_junctions_whose_regions_have_the_same_middle_stay():
    rod = capsule(4.0, 0.6)
    skeleton = pair_in(rod, [0, 0, 1.6], [0, 0, 1.9], [0.1, 0, 0], 0.6, np.arange(len(rod.vertices)) % 2 == 0)
    moved = move_pulled_junctions_back(skeleton, Surface(rod))
    assert np.array_equal(moved.nodes, skeleton.nodes)


def test_a_junction_near_the_middle_of_its_region_stays():
    rod = capsule(4.0, 0.6)
    ends = [[0, 0, -1.35], [0, 0, -1.05]]
    skeleton = pair_in(rod, *ends, [0.1, 0, 0], 0.6, nearest_rows(rod.vertices, np.array(ends)) == 1)
    nodes = move_pulled_junctions_back(skeleton, Surface(rod)).nodes
    assert np.array_equal(nodes[0], skeleton.nodes[0])
    assert nodes[1][2] > 0.3


@pytest.mark.parametrize(("angle", "reach", "moves"), [(40, 30, True), (150, 30, False), (40, 75, False)])
def test_a_junction_stays_if_its_branch_would_leave_or_its_region_is_bent(angle, reach, moves):
    """In a ring a chord of 150 degrees leaves, and the centroid of an arc of 150 degrees is near the surface."""
    ring = torus(1.0, 0.3, 96, 32)
    skeleton = pair_in(ring, on_ring(0), on_ring(8), [0, 0, 0.05], 0.3, near_angle(ring, angle, reach))
    nodes = move_pulled_junctions_back(skeleton, Surface(ring)).nodes
    assert (np.linalg.norm(nodes[1] - skeleton.nodes[1]) > 0.3) == moves
    assert np.array_equal(nodes[0], skeleton.nodes[0])
