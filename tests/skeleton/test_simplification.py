"""Simplification of branches: the fewest segments within the tolerance, on the same graph."""

import itertools

import numpy as np
import pytest

from lbskel import Skeleton, UnknownChoice, simplify_branches, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import is_in_largest_piece
from lbskel.refinement.containment import inside_fraction
from lbskel.shapes import make


def path(points, radius=1.0, node_of_vertex=()):
    n = len(points)
    edges = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    return Skeleton(points, edges, np.broadcast_to(radius, n), node_of_vertex)


def ring(n, radius=0.1):
    angle = 2 * np.pi * np.arange(n) / n
    nodes = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    return Skeleton(nodes, np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1), np.full(n, radius))


def distance(P, a, b):
    """Distance of points from a segment."""
    along = b - a
    share = np.clip((P - a) @ along / max(along @ along, 1e-300), 0, 1)
    return np.linalg.norm(P - a - share[:, None] * along, axis=1)


def furthest(before, after):
    """Largest distance from the nodes of a path to their segments, in radii."""
    rows = [np.flatnonzero((before.nodes == node).all(axis=1))[0] for node in after.nodes]
    return max(
        (distance(before.nodes[i : j + 1], before.nodes[i], before.nodes[j]) / before.radii[i : j + 1]).max()
        for i, j in itertools.pairwise(sorted(rows))
    )


@pytest.mark.parametrize("seed", range(10))
def test_no_choice_of_nodes_gives_fewer(seed):
    rng = np.random.default_rng(seed)
    wiggle = path(np.cumsum(rng.normal(size=(9, 3)), axis=0), rng.uniform(0.5, 2.0, size=9))
    simplified = simplify_branches(wiggle, tolerance=0.7)
    assert furthest(wiggle, simplified) <= 0.7
    fewer = len(simplified.nodes) - 1
    for inner in itertools.chain.from_iterable(itertools.combinations(range(1, 8), k) for k in range(fewer - 1)):
        chosen = wiggle.nodes[[0, *inner, 8]]
        assert furthest(wiggle, path(chosen)) > 0.7


def test_a_straight_path_is_one_segment_and_a_bend_is_kept():
    straight = path(np.linspace([0, 0, 0], [9, 0, 0], 40))
    assert len(simplify_branches(straight).edges) == 1
    bend = path(np.concatenate([straight.nodes, straight.nodes[-1] + np.linspace([0, 1, 0], [0, 9, 0], 30)]))
    assert simplify_branches(bend, tolerance=0.01).nodes.tolist() == [[0, 0, 0], [9, 0, 0], [9, 9, 0]]


def test_the_tolerance_is_in_local_radii():
    nodes = [[0, 0, 0], [1, 0.3, 0], [2, 0, 0]]
    assert len(simplify_branches(path(nodes, [1.0, 1.0, 1.0]), tolerance=0.4).nodes) == 2
    assert len(simplify_branches(path(nodes, [1.0, 0.5, 1.0]), tolerance=0.4).nodes) == 3


def test_a_segment_spans_a_limited_number_of_nodes():
    long = path(np.linspace([0, 0, 0], [1, 0, 0], 300))
    assert len(simplify_branches(long).edges) == 3


def test_a_loop_keeps_three_nodes_whatever_the_tolerance():
    for loop in (ring(20), ring(3)):
        simplified = simplify_branches(loop, tolerance=100.0)
        assert (len(simplified.nodes), simplified.cycle_rank) == (3, 1)


def test_nodes_at_one_place_stay_where_each_is_kept():
    """A triangle with two nodes at one place, and an anchor at the place of a tip."""
    triangle = Skeleton([[0, 0, 0], [0, 0, 0], [1, 0, 0]], [[0, 1], [1, 2], [0, 2]], [1, 1, 1], [0, 1, 2])
    simplified = simplify_branches(triangle)
    assert (simplified.cycle_rank, simplified.node_of_vertex.tolist()) == (1, [0, 1, 2])
    line = Skeleton([[0, 0, 0], [0, 0, 0], [3, 0, 0]], [[0, 1], [1, 2]], [1, 1, 1], anchors=[1])
    simplified = simplify_branches(line)
    assert (len(simplified.nodes), simplified.n_components, simplified.anchors.tolist()) == (3, 1, [1])


def test_loops_at_a_junction_and_parallel_paths_are_kept():
    # a ring of eight with a stalk at 0, and two paths from 10 to 12 besides the direct one
    loop = ring(8)
    edges = [*loop.edges.tolist(), [0, 8], [8, 9], [9, 10], [10, 11], [11, 12], [10, 13], [13, 12], [10, 12], [12, 14]]
    nodes = np.concatenate([loop.nodes, [[2, 0, 0], [3, 0, 0], [4, 0, 0], [5, 1, 0], [6, 0, 0], [5, -1, 0], [7, 0, 0]]])
    before = Skeleton(nodes, edges, np.full(15, 0.1))
    after = simplify_branches(before, tolerance=1000.0)
    assert (after.cycle_rank, after.n_components, len(after.tips)) == (3, 1, 1)
    assert before.cycle_rank == 3
    assert len(after.nodes) == 3 + 5  # of the ring, and 10 to 14


def test_anchors_are_kept_also_on_a_straight_line():
    line = path(np.linspace([0, 0, 0], [9, 0, 0], 10))
    anchored = Skeleton(line.nodes, line.edges, line.radii, anchors=[3])
    simplified = simplify_branches(anchored)
    assert simplified.nodes[:, 0].tolist() == [0, 3, 9]
    assert simplified.nodes[simplified.anchors, 0].tolist() == [3]


def test_vertices_go_to_the_nearest_node_along_the_branch():
    simplified = simplify_branches(path(np.linspace([0, 0, 0], [9, 0, 0], 10), node_of_vertex=np.arange(10)))
    assert simplified.node_of_vertex.tolist() == [0] * 5 + [1] * 5


def test_nodes_without_edges_are_kept():
    alone = Skeleton(np.zeros((1, 3)), [], [1.0], [0, 0])
    assert simplify_branches(alone).node_of_vertex.tolist() == [0, 0]


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan])
def test_a_tolerance_that_is_not_positive_is_refused(tolerance):
    with pytest.raises(UnknownChoice, match="tolerance must be positive"):
        simplify_branches(ring(4), tolerance=tolerance)


def test_a_whole_skeleton_keeps_its_topology_and_stays_inside():
    shape = make("spiked_ring", n_vertices=1500)
    skeleton = skeletonize(shape.mesh)
    simplified = simplify_branches(skeleton)
    before, after = ((s.n_components, s.cycle_rank, len(s.tips), len(s.junctions)) for s in (skeleton, simplified))
    assert before == after
    assert len(simplified.nodes) < 0.25 * len(skeleton.nodes)
    assert is_in_largest_piece(simplified.node_of_vertex, shape.mesh).all()
    # at most half a radius off the axis, so well inside
    assert inside_fraction(simplified, Surface(shape.mesh)) == 1


def test_an_infinite_tolerance_keeps_the_ends_and_anchors_alone():
    """A node of radius 0 on the line between the ends is no anchor."""
    line, edges = [[0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 0, 0]], [[0, 1], [1, 2], [2, 3]]
    assert len(simplify_branches(Skeleton(line, edges, [1, 1, 0, 1]), tolerance=np.inf).nodes) == 2
    held = Skeleton(line, edges, [1, 1, 0, 1], anchors=[1])
    assert len(simplify_branches(held, tolerance=np.inf).nodes) >= 3
