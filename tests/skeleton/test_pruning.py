"""Pruning and merging: which branches are removed, where their vertices go, and that no cycle is lost."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import fan, joined, star_skeleton, theta_skeleton

from lbskel import Mesh, MeshError, Skeleton, UnknownChoice, merge_junctions, prune, skeletonize
from lbskel.shapes import capsule, make
from lbskel.skeleton.pruning import farthest_vertices, without_stubs


def test_a_short_branch_is_removed_and_long_ones_are_kept():
    skeleton, mesh = star_skeleton([3, 3, 0.5, 2])
    pruned = prune(skeleton, mesh, min_branch_ratio=1.5)
    assert len(pruned.tips) == 3
    assert pruned.nodes[:, 1].max() == 0
    assert pruned.nodes[:, 1].min() == -2
    # the spur's vertices go to the junction
    spur = np.flatnonzero(skeleton.nodes[:, 1] > 0)
    assert np.array_equal(pruned.nodes[pruned.node_of_vertex[spur]], np.zeros((len(spur), 3)))


def test_the_ratio_is_in_radii_of_the_junction():
    for radius, n_tips in ((0.3, 4), (0.7, 3)):
        skeleton, mesh = star_skeleton([3, 3, 0.75, 2], 5.0)
        skeleton = replace(skeleton, radii=[radius, *skeleton.radii[1:]])
        assert len(prune(skeleton, mesh, min_branch_ratio=1.5).tips) == n_tips


def test_pruning_never_cuts_a_cycle():
    skeleton = theta_skeleton()
    mesh = Mesh(skeleton.nodes, fan(len(skeleton.nodes)))
    assert prune(skeleton, mesh, min_branch_ratio=1e9).cycle_rank == 2


def test_close_junctions_are_merged():
    nodes = np.array([[0.0, 0, 0], [0.3, 0, 0], [-1, 1, 0], [-1, -1, 0], [1.3, 1, 0], [1.3, -1, 0]])
    skeleton = Skeleton(
        nodes, [[0, 1], [0, 2], [0, 3], [1, 4], [1, 5]], np.array([0.5, 0.4, 0.2, 0.3, 0.4, 0.2]), [0, 1]
    )
    merged = merge_junctions(skeleton, ratio=1.0)
    assert len(merged.junctions) == 1
    assert np.array_equal(merged.nodes[merged.junctions[0]], [0, 0, 0])
    assert len(set(merged.node_of_vertex)) == 1
    assert len(merge_junctions(skeleton, ratio=0.5).junctions) == 2


@pytest.mark.parametrize(("thin", "n_junctions"), [(0.1, 2), (0.2, 1), (0.5, 1)])
def test_junctions_stay_where_thin_limbs_have_room_beside_each_other(thin, n_junctions):
    """Two limbs leave a trunk of radius 0.5 at a distance of 0.3; within its ball, their nodes are as thick as it."""
    trunk = [[x, 0, 0] for x in (-2, -1, 0, 0.3, 1.3, 2.3)]
    limbs = [[x, y, 0] for x, sign in ((0, 1), (0.3, -1)) for y in sign * np.array([0.2, 0.4, 0.6, 0.9, 1.2])]
    edges = [[k, k + 1] for k in (0, 1, 2, 3, 4, 6, 7, 8, 9, 11, 12, 13, 14)] + [[2, 6], [3, 11]]
    skeleton = Skeleton(trunk + limbs, edges, [0.5] * 6 + [0.5, 0.5, thin, thin, thin] * 2)
    assert len(merge_junctions(skeleton).junctions) == n_junctions


@pytest.mark.parametrize("lengths", [(1, 2, 3), (1, 4, 4), (2, 2, 2), (1, 3, 2)])
def test_merging_keeps_the_cycles(lengths):
    assert merge_junctions(theta_skeleton(lengths), ratio=1e9).cycle_rank == 2


def test_the_junctions_of_a_triangle_are_not_merged():
    """Each pair is joined by one branch only, and by a path through the third."""
    ring = np.array([[np.cos(angle), np.sin(angle), 0.0] for angle in 2 * np.pi * np.arange(3) / 3])
    edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 4], [2, 5]]
    tailed = Skeleton(np.concatenate([ring, 3 * ring]), np.array(edges), np.full(6, 5.0))
    merged = merge_junctions(tailed)
    assert (merged.cycle_rank, len(merged.nodes)) == (1, 6)


def test_the_reach_of_a_branch_is_measured_from_its_first_node_to_the_vertices_of_the_others():
    skeleton = Skeleton([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1], [1, 2]], np.ones(3), [0, 1, 2, 2])
    mesh = Mesh([[-9, 0, 0], [1, 3, 0], [2, 1, 0], [3, 0, 0]], fan(4))
    farthest, reaches = farthest_vertices(skeleton, mesh, [np.array([0, 1, 2])])
    assert (farthest.tolist(), reaches.tolist()) == ([1], [np.hypot(1, 3)])
    farthest, reaches = farthest_vertices(skeleton, mesh, [np.array([2, 1, 0]), np.array([0])])
    assert (farthest.tolist(), reaches.tolist()) == ([0, 0], [11, 0])


def test_the_shortest_branch_goes_first_and_its_junction_may_be_none_after_it():
    """Both side branches are below the ratio, but without the shorter one the other is part of a longer path."""
    skeleton, mesh = star_skeleton([3, 0.5, 0.75])
    pruned = prune(skeleton, mesh, min_branch_ratio=1.5)
    assert (len(pruned.tips), len(pruned.junctions)) == (2, 0)
    assert pruned.nodes[:, 0].min() == 0
    assert pruned.nodes[:, 1].max() == 0.75


def test_in_a_round_one_branch_goes_at_every_junction():
    """Two junctions with three short branches each, and a long branch between them and beyond."""
    one, _ = star_skeleton([3, 3, 0.5, 0.75, 0.5])
    shift = np.array([6.0, 0, 0])
    nodes = np.concatenate([one.nodes, one.nodes + shift])
    k = len(one.nodes)
    ends = (np.flatnonzero((one.nodes == [3, 0, 0]).all(axis=1)), np.flatnonzero((one.nodes == [-3, 0, 0]).all(axis=1)))
    edges = np.concatenate([one.edges, one.edges + k, [[ends[0][0], k + ends[1][0]]]])
    both = Skeleton(nodes, edges, np.full(2 * k, 0.5), np.arange(2 * k))
    pruned = prune(both, Mesh(nodes, fan(len(nodes))), min_branch_ratio=1.6)
    assert (len(pruned.tips), len(pruned.junctions)) == (2, 0)
    # what each junction had at first is a path again, and its vertices went to it
    for junction in (0, k):
        assert np.bincount(pruned.node_of_vertex)[pruned.node_of_vertex[junction]] == 1 + 2 + 3 + 2


def test_anchors_are_not_pruned():
    skeleton, mesh = star_skeleton([3, 3, 0.5, 2])
    anchored = replace(skeleton, anchors=np.flatnonzero(skeleton.nodes[:, 1] == 0.5))
    assert len(prune(anchored, mesh, min_branch_ratio=1.5).tips) == 4


def test_prune_takes_what_as_mesh_takes():
    skeleton, mesh = star_skeleton([3, 3, 0.5, 2])
    assert len(prune(skeleton, (mesh.vertices, mesh.faces)).tips) == 3


def test_prune_refuses_another_mesh_and_a_ratio_that_is_none():
    skeleton, mesh = star_skeleton([3, 3, 0.5, 2])
    smaller = Mesh(mesh.vertices[:9], [[0, 1, 2]])
    with pytest.raises(MeshError, match=rf"the map has {len(mesh.vertices)} vertices and the mesh 9"):
        prune(skeleton, smaller)
    with pytest.raises(MeshError, match="the map has 0 vertices"):
        prune(replace(skeleton, node_of_vertex=[]), mesh)
    for ratio in (-1.0, np.nan):
        with pytest.raises(UnknownChoice, match="min_branch_ratio must be a number of local radii, 0 or more"):
            prune(skeleton, mesh, min_branch_ratio=ratio)
        with pytest.raises(UnknownChoice, match="ratio must be a number of local radii, 0 or more"):
            merge_junctions(skeleton, ratio=ratio)


def test_vertices_without_a_face_do_not_reach():
    rod = capsule(6.0, 0.5)
    skeleton = skeletonize(rod)
    far = Mesh(np.concatenate([rod.vertices, [[0, 60, 0]]]), rod.faces)
    tip = int(skeleton.tips[0])
    with_far = replace(skeleton, node_of_vertex=np.append(skeleton.node_of_vertex, tip))
    branch = skeleton.branches[0] if skeleton.branches[0][-1] == tip else skeleton.branches[0][::-1]
    assert farthest_vertices(with_far, far, [branch])[1] == pytest.approx(farthest_vertices(skeleton, rod, [branch])[1])


def test_crumbs_do_not_reach(tetrahedron):
    """A tetrahedron beside the end of the shortest limb is mapped to its tip."""
    tripod = make("tripod", n_vertices=1500).mesh
    skeleton = skeletonize(tripod)
    ends = skeleton.end_branches
    reach = farthest_vertices(skeleton, tripod, ends)[1]
    tip = int(ends[np.argmin(reach)][-1])
    both = joined(tripod, tetrahedron.with_vertices(1e-3 * tetrahedron.vertices + 9 * skeleton.nodes[tip]))
    with_crumb = replace(skeleton, node_of_vertex=np.append(skeleton.node_of_vertex, [tip] * 4))
    ratio = 1.01 * reach.min() / skeleton.radii[skeleton.junctions[0]]
    assert len(prune(with_crumb, both, min_branch_ratio=ratio).tips) == 2


def test_a_mesh_of_nothing_but_crumbs_is_taken_as_it_is():
    skeleton, mesh = star_skeleton([3, 3, 1])
    assert np.array_equal(mesh.faces[:, 0], np.zeros(len(mesh.faces)))
    few = Mesh(mesh.vertices, [[0, int(tip), 0] for tip in skeleton.tips])
    assert len(prune(skeleton, few, min_branch_ratio=3.0).tips) == 2


@pytest.mark.parametrize("unknown", [[0], [4], [0, 1, 4, 5], [2], [0, 1, 2, 3, 4, 5]])
def test_junctions_merge_by_the_radii_that_are_known(unknown):
    nodes = [[-2, 1, 0], [-2, -1, 0], [0, 0, 0], [0.2, 0, 0], [2, 1, 0], [2, -1, 0]]
    radii = np.ones(6)
    radii[unknown] = np.nan
    near = Skeleton(nodes, [[0, 2], [1, 2], [2, 3], [3, 4], [3, 5]], radii)
    merged = merge_junctions(near)
    assert len(merged.junctions) == (2 if len(unknown) == 6 else 1)
    if unknown == [2]:  # of the two junctions that with the larger radius keeps its place
        assert merged.nodes[merged.junctions].tolist() == [[0.2, 0, 0]]


def test_a_limb_is_as_thick_as_its_radii_that_are_known():
    """Two thin limbs on each side of a thick trunk have room beside each other; most of their radii are not known."""
    ways = np.array([[-2, 1, 0], [-2, -1, 0], [2, 1, 0], [2, -1, 0]])
    nodes = [[0, 0, 0], [0.2, 0, 0], *np.concatenate([ways, 2 * ways, 3 * ways])]
    starts = [(0, 2), (0, 3), (1, 4), (1, 5)]
    skeleton = Skeleton(
        nodes, [(0, 1), *starts, *((k, k + 4) for k in range(2, 10))], [1] * 2 + [np.nan] * 8 + [0.05] * 4
    )
    assert merge_junctions(skeleton) is skeleton


def test_no_stub_is_left_beside_a_joining_edge():
    """A branch along x is left 1.2 radii before its tip, and another, which is joined at its own tip, is as short."""
    nodes = np.array([[x, 0, 0] for x in (0, 2, 4, 5.2)] + [[4, 3, 0], [4, 4.2, 0]], dtype=float)
    before = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [4, 5]], np.ones(6), np.arange(6))
    joined = replace(before, edges=np.concatenate([before.edges, [[2, 4]]]))
    after = without_stubs(before, joined)
    assert after.nodes.tolist() == nodes[[0, 1, 2, 4, 5]].tolist()
    assert after.node_of_vertex.tolist() == [0, 1, 2, 2, 3, 4]
    assert (
        without_stubs(replace(before, radii=np.full(6, 0.79)), replace(joined, radii=np.full(6, 0.79))).tips.size == 3
    )
    assert without_stubs(before, replace(joined, anchors=np.array([3]))).tips.size == 3


def test_a_short_piece_that_is_joined_stays():
    nodes = np.array([[x, 0, 0] for x in range(5)] + [[2, 1, 0], [2, 1.4, 0]], dtype=float)
    before = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [3, 4], [5, 6]], np.ones(7))
    joined = replace(before, edges=np.concatenate([before.edges, [[2, 5]]]))
    assert without_stubs(before, joined).edges.tolist() == joined.edges.tolist()


def test_short_branches_of_a_junction_stay_when_it_is_joined():
    nodes = np.array([[x, 0, 0] for x in range(5)] + [[2, 1.2, 0], [2, -4, 0], [2, -9, 0]], dtype=float)
    before = Skeleton(nodes, [[0, 1], [1, 2], [2, 3], [3, 4], [2, 5], [6, 7]], np.ones(8))
    joined = replace(before, edges=np.concatenate([before.edges, [[2, 6]]]))
    assert without_stubs(before, joined).edges.tolist() == joined.edges.tolist()
