"""Joining: the shortest edges between components, with cycles and the map unchanged."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers import joined, moved, without_faces
from scipy.spatial.distance import cdist

from lbskel import (
    Mesh,
    Skeleton,
    UnknownChoice,
    join_components,
    prune,
    resample,
    score,
    simplify_branches,
    skeletonize,
)
from lbskel.shapes import cylinder, torus, vessel_tree
from lbskel.skeleton.joining import join_pieces, joining_by_report, without_joining_edges


def dashes(n, seed=0, span=(1, 1, 1)):
    """Short edges at random positions, each a component."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(size=(n, 3)) * span
    nodes = np.concatenate([start, start + 0.01 * rng.normal(size=(n, 3)) * span])
    return Skeleton(nodes, np.stack([np.arange(n), n + np.arange(n)], axis=1), np.full(2 * n, 0.01))


def shortest(skeleton):
    """The length of the minimum spanning tree between the components, by Prim's algorithm on all pairs."""
    n = len(skeleton.nodes) // 2
    gap = cdist(skeleton.nodes, skeleton.nodes).reshape(2, n, 2, n).min(axis=(0, 2))
    reached, total = np.zeros(n, dtype=bool), 0.0
    reached[0] = True
    while not reached.all():
        gaps = np.where(reached[:, None] & ~reached, gap, np.inf)
        a, b = np.unravel_index(gaps.argmin(), gaps.shape)
        reached[b], total = True, total + gaps[a, b]
    return total


@pytest.mark.parametrize("span", [(1, 1, 1), (1, 1, 0), (1, 0, 0)])
@pytest.mark.parametrize("n", [2, 30, 90])
def test_the_added_edges_are_the_minimum_spanning_tree(n, span):
    given = dashes(n, span=span)
    whole = join_components(given)
    assert (whole.n_components, whole.cycle_rank) == (1, 0)
    assert whole.length - given.length == pytest.approx(shortest(given), rel=1e-6)


def test_components_beyond_reach_stay_separate():
    given = dashes(30)
    near = join_components(given, reach=5.0)
    assert 1 < near.n_components < 30
    one, other = given.component_of_node[near.edges].T
    added = near.edge_lengths[one != other]
    assert len(added) == 30 - near.n_components
    assert added.max() <= 5.0 * 0.02
    with pytest.raises(UnknownChoice, match="reach must be positive"):
        join_components(given, reach=0.0)


def test_cycles_and_the_map_are_kept():
    ring = torus(1.0, 0.25, 16, 8)
    apart = skeletonize(joined(ring, moved(ring, 3.0), moved(ring, 6.0)))
    whole = join_components(apart)
    assert (whole.n_components, whole.cycle_rank) == (1, 3)
    assert np.array_equal(whole.node_of_vertex, apart.node_of_vertex)
    assert len(whole.edges) == len(apart.edges) + 2
    assert join_components(whole) is whole


def test_coincident_nodes_are_joined():
    whole = join_components(Skeleton(np.zeros((4, 3)), np.array([[0, 1], [2, 3]]), np.ones(4)))
    assert whole.n_components == 1


def line(start, end, n=6, radius=0.1):
    """A path of nodes from a point to another."""
    k = np.arange(n - 1)
    return Skeleton(np.linspace(start, end, n), np.stack([k, k + 1], axis=1), np.full(n, radius))


def both(*lines):
    """Several skeletons as one with as many components."""
    first = np.cumsum([0, *(len(each.nodes) for each in lines)])
    return Skeleton(
        np.concatenate([each.nodes for each in lines]),
        np.concatenate([each.edges + offset for each, offset in zip(lines, first[:-1], strict=True)]),
        np.concatenate([each.radii for each in lines]),
    )


@pytest.mark.parametrize(("degrees", "n_components"), [(0, 1), (29, 1), (31, 2), (90, 2)])
def test_an_edge_continues_a_branch_within_the_angle(degrees, n_components):
    """The gap of 2 goes off from the first line at an angle, and is crossed by the second line in its middle."""
    angle = np.radians(degrees)
    across = np.array([np.cos(angle), np.sin(angle), 0])
    end = np.array([5.0, 0, 0])
    beside = np.array([0, 0, 0.2])  # the second line stands on the first
    given = both(line([0, 0, 0], end), line(end + 2 * across - 9 * beside, end + 2 * across + 9 * beside, 7))
    assert join_components(given).n_components == 1
    assert join_components(given, max_angle=30.0).n_components == n_components


def test_balls_that_touch_are_joined_in_any_direction():
    beside = line([0, 0.15, 0], [5, 0.15, 0])
    assert join_components(both(line([0, 0, 0], [5, 0, 0]), beside), max_angle=30.0).n_components == 1
    apart = line([0, 0.25, 0], [5, 0.25, 0])  # of a sum of radii of 0.2
    assert join_components(both(line([0, 0, 0], [5, 0, 0]), apart), max_angle=30.0).n_components == 2
    with pytest.raises(UnknownChoice, match="max_angle must be positive"):
        join_components(both(beside, apart), max_angle=0.0)


def test_only_components_that_may_be_joined_are():
    given = both(*(line([3 * k, 0, 0], [3 * k + 2, 0, 0]) for k in range(4)))
    is_joinable = np.array([True, False, True, True])
    some = join_components(given, is_joinable=is_joinable.tolist())
    assert some.n_components == 2
    added = some.edges[len(given.edges) :]
    assert not (given.component_of_node[added] == 1).any()
    assert join_components(given, is_joinable=np.zeros(4, dtype=bool)).n_components == 4
    with pytest.raises(UnknownChoice, match="is_joinable needs a value for each of 4 components"):
        join_components(given, is_joinable=[True])


def test_the_nearest_pair_of_nodes_may_be_one_that_is_not_allowed():
    """The second line leaves the first at a right angle from its middle, beside the nodes that it is nearest to."""
    trunk = line([0, 0, 0], [5, 0, 0], 60)
    twig = line([2.5, 0.5, 0.3], [2.5, 3, 0.3])
    assert join_components(both(trunk, twig), reach=10.0, max_angle=45.0).n_components == 1


def test_an_empty_skeleton_stays_empty():
    empty = Skeleton(np.empty((0, 3)), np.empty((0, 2), dtype=np.int64), [])
    assert join_components(empty) is empty


@pytest.fixture(scope="module")
def rod_and_ring(rod, ring):
    """Two bodies beside each other, and their skeleton in one graph."""
    mesh = joined(rod, moved(ring, 4.0))
    return mesh, skeletonize(mesh, join="all")


@pytest.mark.parametrize(
    "edit", [partial(resample, spacing=0.3), partial(resample, n_nodes=40), partial(simplify_branches, tolerance=0.1)]
)
def test_edges_that_join_bodies_are_not_edited(edit, rod_and_ring):
    mesh, skeleton = rod_and_ring
    edited = edit(skeleton)
    (added,) = np.sort(skeleton.report["joining_edges"], axis=1)
    assert (np.sort(edited.nodes[edited.edges], axis=1) == added).all(axis=(1, 2)).sum() == 1
    assert np.count_nonzero(joining_by_report(edited)) == 1
    assert len(edited.anchors) == 0
    assert score(edited, mesh).inside_fraction == 1


@pytest.mark.parametrize("edit", [partial(resample, n_nodes=4), partial(resample, spacing=3.0), simplify_branches])
def test_the_first_node_stays_within_a_branch(edit):
    """As the soma of a bipolar neuron, which is the root."""
    nodes = [[0, 0, 0], [-1, 0, 0], [-2, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]
    edited = edit(Skeleton(nodes, [[0, 1], [1, 2], [0, 3], [3, 4], [4, 5]], [2, 1, 1, 1, 1, 1], anchors=[4]))
    assert (edited.nodes[0].tolist(), edited.radii[0], edited.degrees[0]) == ([0, 0, 0], 2, 2)
    assert edited.nodes[edited.anchors].tolist() == [[2, 0, 0]]


def test_anchors_stay_where_edges_are_set_aside(rod_and_ring):
    skeleton = replace(rod_and_ring[1], anchors=[3])
    resampled = without_joining_edges(partial(resample, spacing=0.3), skeleton)
    assert np.array_equal(resampled.nodes[resampled.anchors], skeleton.nodes[[3]])
    unknown = replace(skeleton, report={})
    assert without_joining_edges(lambda given: given, unknown) is unknown


def test_edges_that_were_added_are_told_to_the_score_and_to_later_edits(rod_and_ring):
    """As the option does."""
    bodies, whole = rod_and_ring
    apart = skeletonize(bodies, join="none")
    once = join_components(apart)
    assert (once.report["pieces_joined"], len(once.report["joining_edges"])) == (1, 1)
    assert joining_by_report(once).sum() == 1
    assert score(once, bodies).report() == score(whole, bodies).report()
    assert apart.report["pieces_joined"] == 0


def test_joining_again_adds_to_the_report():
    path = Skeleton(
        [[0, 0, 0], [1, 0, 0], [3, 0, 0], [4, 0, 0], [9, 0, 0], [10, 0, 0]], [[0, 1], [2, 3], [4, 5]], [1] * 6
    )
    whole = join_components(join_components(path, reach=1.0))
    assert whole.report == {"pieces_joined": 2, "joining_edges": [[[1, 0, 0], [3, 0, 0]], [[4, 0, 0], [9, 0, 0]]]}


def test_an_edge_between_bodies_that_is_pruned_is_no_longer_reported():
    """A short twig on a thick rod is a body of its own."""
    nodes = [[-3, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, 1.5, 0], [3, 0, 0], [4, 0, 0]]
    pieces = Skeleton(nodes, [[0, 1], [1, 2], [3, 4], [5, 6]], [1, 1, 1, 0.1, 0.1, 1, 1], np.arange(7))
    mesh = Mesh(np.array(nodes), [[0, 1, 3], [1, 2, 3], [2, 3, 4], [2, 5, 6]])
    pruned = prune(join_components(pieces), mesh, min_branch_ratio=1.6)
    assert (len(pruned.tips), pruned.report["pieces_joined"]) == (2, 1)
    assert pruned.report["joining_edges"] == [[[2, 0, 0], [3, 0, 0]]]
    assert joining_by_report(pruned).sum() == 1


def test_edges_without_length_are_found_again():
    """Pieces of a tracing that was cut at a node."""
    nodes = [[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0], [2, 0, 0], [3, 0, 0]]
    whole = join_components(Skeleton(nodes, [[0, 1], [2, 3], [4, 5]], [1] * 6))
    assert whole.report["pieces_joined"] == 2
    assert whole.edges[joining_by_report(whole)].tolist() == [[1, 2], [3, 4]]
    simplified = simplify_branches(whole)
    assert joining_by_report(simplified).sum() == 2


@pytest.mark.parametrize(("across", "n_joined"), [((0.0, 0.0, 1.0), 0), ((0.0, 1.0, 0.0), 1)])
def test_an_edge_leaves_a_cut_outwards(across, n_joined):
    """Two branches at 45 degrees to the edge between their tips: both cut by one plane, or each at its own end."""
    nodes = np.array([[0, -5, -4], [0, -3, -2], [0, -1, 0], [0, 1, 0], [0, 3, -2], [0, 5, -4]], dtype=float)
    apart = Skeleton(nodes, np.array([[0, 1], [1, 2], [3, 4], [4, 5]]), np.ones(6))
    outwards = np.zeros_like(nodes)
    outwards[2], outwards[3] = across, np.array(across) * [1, -1, 1]
    both = np.ones(2, dtype=bool)
    assert join_pieces(apart, both).report["pieces_joined"] == 1
    assert join_pieces(apart, both, outwards).report["pieces_joined"] == n_joined


def test_two_tubes_that_one_plane_cuts_are_no_pieces_of_one():
    """Each is tilted by 45 degrees, towards the other."""
    pipe = cylinder(0.5, 10.0, 24, 60)
    x, y, z = pipe.vertices.T
    z = z + x * z / 5  # so that the upper rim is level once the pipe is tilted
    left = Mesh(np.stack([(x + z) / np.sqrt(2) - 5, y, (z - x) / np.sqrt(2)], axis=1), pipe.faces)
    right = Mesh(left.vertices * [-1, 1, 1], left.faces[:, ::-1])
    skeleton = skeletonize(joined(left, right))
    assert skeleton.n_components == 2


@pytest.mark.parametrize("overlap", [0.0, 0.02, -0.02])
def test_blocks_that_touch_at_a_cut_are_joined_there(overlap):
    """The edge between the centers of their cuts has no direction, or points backwards."""
    whole = cylinder(0.5, 10.0, 24, 60)
    low = whole.vertices[whole.faces].mean(axis=1)[:, 2] < whole.vertices[24 * 30, 2]
    upper = Mesh(whole.vertices - [0.01, 0, overlap], whole.faces[~low])
    skeleton = skeletonize(joined(Mesh(whole.vertices, whole.faces[low]), upper))
    assert (skeleton.n_components, len(skeleton.tips)) == (1, 2)


def test_pieces_of_a_tree_that_oblique_planes_cut_have_no_more_tips_than_the_tree():
    """Two gaps across a tree of vessels: the shortest edge leaves one branch two nodes before its tip."""
    tree = vessel_tree(5, seed=8)
    heights = tree.mesh.vertices[tree.mesh.faces].mean(axis=1)[:, 2]
    gap = 0.005 * np.ptp(tree.mesh.vertices, axis=0).max()
    cut = without_faces(tree.mesh, np.flatnonzero(np.abs(heights - np.median(heights)) <= gap))
    skeleton = skeletonize(cut)
    assert (skeleton.n_components, len(skeleton.tips)) == (1, len(tree.truth.tips))
