"""Short loops: which are opened, at which branch, and where the vertices of that branch go."""

import numpy as np
import pytest
from helpers import joined, loop_in, moved, theta_skeleton

from lbskel import Skeleton, UnknownChoice, open_short_loops, skeletonize, to_tree
from lbskel.shapes import torus

# a loop with a tail on either side: the sides of the loop have lengths of 2 * sqrt(2)
NODES = [[0, 0, 0], [1, 0, 0], [2, 1, 0], [2, -1, 0], [3, 0, 0], [4, 0, 0]]
EDGES = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [4, 5]]


def eye(radii=(1, 1, 1, 0.5, 1, 1), **more):
    return Skeleton(NODES, EDGES, np.array(radii, dtype=float), np.arange(6), **more)


def test_the_thinnest_branch_is_removed_and_its_vertices_go_to_its_ends():
    opened = open_short_loops(eye(), 10)
    assert (opened.cycle_rank, opened.n_components, len(opened.tips)) == (0, 1, 2)
    assert opened.nodes.tolist() == [NODES[k] for k in (0, 1, 2, 4, 5)]  # node 3 is the thin one
    kept = opened.nodes[opened.node_of_vertex]
    assert np.delete(kept, 3, axis=0).tolist() == np.delete(NODES, 3, axis=0).tolist()
    assert kept[3].tolist() in (NODES[1], NODES[4])


@pytest.mark.parametrize("first", [1.4, np.nan])
def test_neither_thin_junctions_nor_unknown_radii_decide_which_branch_is_removed(first):
    for sides, thin in (((first, 0.7), 3), ((0.7, first), 2)):
        opened = open_short_loops(eye((1, 0.6, *sides, 0.6, 1)), 50)
        assert opened.nodes.tolist() == [NODES[k] for k in range(6) if k != thin]


def test_a_single_edge_is_as_thin_as_its_ends():
    """The side of one edge is thicker than the other side, of a radius of 0.5 at its middle."""
    chord = Skeleton(NODES, [*EDGES[:2], EDGES[3], [1, 4], EDGES[5], [0, 3]], [1, 1, 0.5, 1, 1, 1])
    opened = open_short_loops(chord, 10)
    assert (opened.cycle_rank, NODES[2] in opened.nodes.tolist()) == (0, False)


def test_the_length_is_that_in_local_radii():
    """The thick side is 2 sqrt(2) radii long; that with a radius of 0.5 at its middle, 4 / 3 of it."""
    length = 2 * np.sqrt(2) * (1 + 4 / 3)
    given = eye()
    assert open_short_loops(given, 0.999 * length) is given
    assert open_short_loops(given, 1.001 * length).cycle_rank == 0
    half = eye(0.5 * np.array([1, 1, 1, 0.5, 1, 1]))
    assert open_short_loops(half, 1.999 * length).cycle_rank == 1
    assert open_short_loops(half, 2.001 * length).cycle_rank == 0


def test_zero_opens_nothing_and_a_bad_number_is_refused():
    given = eye()
    assert open_short_loops(given, 0) is given
    for bad in (-1, np.nan):
        with pytest.raises(UnknownChoice, match="min_loop must be a number of local radii"):
            open_short_loops(given, bad)


def test_an_anchor_keeps_its_branch():
    opened = open_short_loops(eye(anchors=[3]), 10)
    assert opened.cycle_rank == 0
    assert [2, -1, 0] in opened.nodes.tolist()
    assert [2, 1, 0] not in opened.nodes.tolist()
    both = eye(anchors=[2, 3])
    assert open_short_loops(both, 10) is both


def test_of_two_loops_the_short_one_is_opened():
    """The second is three times as large as the first, and as thick."""
    second = 3 * np.array(NODES) + [5.0, 0, 0]
    edges = [*EDGES, *(np.array(EDGES) + 6).tolist(), [5, 6]]
    two = Skeleton([*NODES, *second.tolist()], edges, np.ones(12))
    assert open_short_loops(two, 5.6).cycle_rank == 2  # 4 sqrt(2) is 5.66
    opened = open_short_loops(two, 16.9)  # three times that is 16.97
    assert (opened.cycle_rank, opened.n_components) == (1, 1)
    assert all(node in opened.nodes.tolist() for node in second.tolist())
    assert open_short_loops(two, 17.0).cycle_rank == 0


def test_of_loops_that_share_a_branch_both_are_opened():
    theta = theta_skeleton((8, 8, 8))
    tree = open_short_loops(theta, 100 * theta.length)
    assert (tree.cycle_rank, tree.n_components) == (0, 1)


def test_a_loop_at_one_junction_and_a_ring_are_opened_by_an_edge(ring):
    angle = np.linspace(0, 2 * np.pi, 9)[:-1]
    circle = loop_in(ring, np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), 0.25)
    opened = open_short_loops(circle, 4 * 8)  # a circumference of at most 8 units
    assert (opened.cycle_rank, opened.n_components, len(opened.edges)) == (0, 1, 7)
    k = len(circle.nodes)
    with_tail = Skeleton(
        [*circle.nodes.tolist(), [3, 0, 0]], [*circle.edges.tolist(), [0, k]], [*circle.radii, 0.25], np.zeros(1)
    )
    opened = open_short_loops(with_tail, 4 * 8)
    assert (opened.cycle_rank, opened.n_components, len(opened.tips)) == (0, 1, 2)


@pytest.mark.parametrize("radius", [0.0, np.nan])
def test_where_no_radius_is_known_nothing_is_opened(radius):
    given = eye(np.full(6, radius))
    assert open_short_loops(given, 10).cycle_rank == 1


def test_only_small_handles_of_a_mesh_are_opened_and_the_score_does_not_fail_for_it():
    """A ring of radius 1 and one of radius 6 with tubes as thick: about 4 pi and 12 pi times 1 / 0.5 radii long."""
    given = joined(torus(1.0, 0.5, 24, 12), moved(torus(6.0, 0.5, 96, 12), 9.0))
    kept, opened = skeletonize(given), skeletonize(given, min_loop=30.0)
    assert (kept.cycle_rank, kept.report["loops_opened"]) == (2, 0)
    assert (opened.cycle_rank, opened.report["loops_opened"]) == (1, 1)
    assert open_short_loops(kept, 14).report["loops_opened"] == 1
    assert (opened.n_components, len(opened.tips)) == (2, 2)
    assert opened.report["score"]["measures"]["extra_cycles"] == 0
    assert opened.report["score"]["verdicts"]["extra_cycles"] == "pass"
    # the same graph that nobody asked for fails
    assert kept.report["score"]["measures"]["extra_cycles"] == 0


def test_vertices_of_a_removed_branch_go_to_the_nearer_end_by_arc_length():
    nodes = [[0, 0, 0], [1.1, 0, 0], [5, 0, 0], [6, 0, 0], [2, 3, 0], [4, 3, 0], [-1, 0, 0]]
    edges = [[0, 1], [1, 2], [2, 3], [0, 4], [4, 5], [2, 5], [0, 6]]
    opened = open_short_loops(Skeleton(nodes, edges, [1, 0.5, 1, 1, 1, 1, 1], np.arange(7)), 100)
    assert opened.nodes[opened.node_of_vertex[1]].tolist() == [0, 0, 0]


@pytest.mark.parametrize("order", [1, -1])
def test_a_loop_at_one_junction_is_opened_where_it_is_thinnest_however_it_is_numbered(order):
    turn = np.linspace(0, 2 * np.pi, 9)[:-1]
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)  # the first node is the junction
    radii = np.array([1, 1, 1, 0.5, 0.2, 0.4, 1, 1, 1])
    place = np.append(order * np.arange(8) % 8, 8)  # of each node
    edges = place[[[i, (i + 1) % 8] for i in range(8)] + [[0, 8]]]
    nodes, numbered = np.empty((9, 3)), np.empty(9)
    nodes[place], numbered[place] = np.concatenate([ring, [[3, 0, 0]]]), radii
    looped = Skeleton(nodes, edges, numbered)
    opened = open_short_loops(looped, 100.0)
    assert opened.cycle_rank == 0
    assert opened.edges.tolist() == to_tree(looped).edges.tolist()
    assert 0.2 in opened.radii[opened.tips]


def test_of_cable_that_touches_twice_one_edge_is_removed():
    """Two cables side by side: of the thinner one, whose balls touch the other's at its ends, an edge between these."""
    x = np.arange(7.0)
    straight, bent = np.stack([x, 0 * x, 0 * x], axis=1), np.stack([x, np.minimum(x, 6 - x), 0 * x], axis=1)[1:-1]
    edges = [*((k, k + 1) for k in range(6)), (0, 7), (7, 8), (8, 9), (9, 10), (10, 11), (11, 6), (0, 12), (6, 13)]
    nodes = np.concatenate([straight, bent, [[-2, 0, 0], [8, 0, 0]]])
    radii = np.where(np.isin(np.arange(14), np.arange(7, 12)), [*7 * [0], 0.5, 0.55, 0.6, 0.7, 0.5, 0, 0], 0.8)
    opened = open_short_loops(Skeleton(nodes, edges, radii), 100)
    assert len(opened.nodes) == 14
    assert {tuple(sorted(edge)) for edge in edges} - {tuple(edge) for edge in opened.edges.tolist()} == {(8, 9)}
    assert opened.report["loops_opened"] == 1
