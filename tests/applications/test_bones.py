"""Bones of skeletons made by hand: joints at bends, equal parts, limbs outside of balls, the largest number."""

import tracemalloc

import numpy as np
import pytest

from lbskel import MeshError, Skeleton
from lbskel.applications import bone_branches
from lbskel.applications.bones import bones_of


def path(points, radius, spacing=0.1):
    """A skeleton along a polyline, each node with one vertex."""
    points = np.asarray(points, dtype=float)
    s = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    at = np.linspace(0, s[-1], round(s[-1] / spacing) + 1)
    nodes = np.stack([np.interp(at, s, axis) for axis in points.T], axis=1)
    k = np.arange(len(nodes) - 1)
    return Skeleton(nodes, np.stack([k, k + 1], axis=1), np.full(len(nodes), radius), np.arange(len(nodes)))


def joints(bones):
    return np.unique(np.concatenate([bones.heads[1:], bones.tails[1:]]).round(6), axis=0)


def test_a_bend_is_a_joint_and_a_straight_path_is_divided_evenly():
    bent = bones_of(path([[0, 0, 0], [3, 0, 0], [3, 1, 0]], 0.25), max_bones=30)
    assert bent.tails[1] == pytest.approx([3, 0, 0], abs=0.11)  # a node beside it, since bones of one length cost less
    straight = bones_of(path([[0, 0, 0], [3, 0, 0]], 0.2), max_bones=30)
    assert joints(straight)[:, 0] == pytest.approx([0, 1.5, 3], abs=0.051)  # the nearest node


def test_a_limb_turns_where_it_leaves_the_ball_of_its_junction():
    nodes = [[0, 0, 0.1 * k] for k in range(-20, 21)] + [[0.1 * k, 0, 0] for k in range(1, 31)]
    edges = [[k, k + 1] for k in range(40)] + [[20, 41]] + [[k, k + 1] for k in range(41, 70)]
    radii = np.where(np.arange(71) <= 40, 0.5, 0.2)
    found = bones_of(Skeleton(nodes, edges, radii, np.arange(71)), max_bones=30)
    limb = [b for b in range(len(found.heads)) if found.heads[b][0] > 0.1]
    assert found.heads[limb[0]][0] == pytest.approx(0.6)  # the first node outside of radius 0.5
    assert found.parents[limb[0]] == 0
    assert found.bone_of_vertex[41:46].tolist() == [0] * 5  # of the ball
    assert (found.bone_of_vertex[46:] > 0).all()


def comb(n, length):
    """A spine with n teeth of different lengths."""
    nodes, edges = [[0.5 * k, 0, 0] for k in range(n)], [[k, k + 1] for k in range(n - 1)]
    for k in range(n):
        for step in range(1, 6):
            nodes.append([0.5 * k, step * length * (1 + 0.1 * k) / 5, 0])
            edges.append([len(nodes) - 2 if step > 1 else k, len(nodes) - 1])
    return Skeleton(nodes, edges, np.full(len(nodes), 0.1), np.arange(len(nodes)))


@pytest.mark.parametrize("most", [1, 3, 7, 30])
def test_there_are_at_most_so_many_bones_and_parents_come_first(most):
    found = bones_of(comb(12, 1.0), max_bones=most)
    assert 1 <= len(found.heads) <= most
    assert (found.parents < np.arange(len(found.heads))).all()
    assert set(np.unique(found.bone_of_vertex)) <= set(range(len(found.heads)))


def test_short_branches_between_junctions_are_contracted_many_at_a_time(monkeypatch):
    """Each of the 199 pieces of the spine is as short as the others: half of them go in each pass."""
    contract, passes = bone_branches.contract_nodes, []
    monkeypatch.setattr(bone_branches, "contract_nodes", lambda *args: passes.append(args) or contract(*args))
    found = bones_of(comb(200, 1.0), max_bones=30)
    assert 10 < len(found.heads) <= 30
    assert len(passes) < 50  # 14 measured; 177 if one branch is contracted at a time


def test_a_path_of_many_nodes_has_the_joints_of_one_of_few():
    corners = [[0, 0, 0], [3, 0, 0], [3, 1, 0]]
    few = bones_of(path(corners, 0.25), max_bones=30)
    tracemalloc.start()
    many = bones_of(path(corners, 0.25, spacing=0.004), max_bones=30)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert many.tails[1:] == pytest.approx(few.tails[1:], abs=0.1)  # the spacing of the few
    assert many.tails[-1].tolist() == few.tails[-1].tolist()  # the end of the path
    assert peak < 5e6  # bytes; a matrix of all pairs of the 1,001 nodes has 8e6


def test_cycles_small_components_and_single_nodes():
    ring = path([[np.cos(a), np.sin(a), 0] for a in np.linspace(0, 6.1, 60)], 0.1)
    closed = Skeleton(ring.nodes, [*ring.edges.tolist(), [0, len(ring.nodes) - 1]], ring.radii, ring.node_of_vertex)
    assert len(bones_of(closed, max_bones=30).heads) > 3
    crumb = Skeleton([[0, 0, 0], [2, 0, 0], [9, 9, 9]], [[0, 1]], [0.1] * 3, [0, 1, 2])
    found = bones_of(crumb, max_bones=30)
    assert found.bone_of_vertex.tolist()[2] == 1  # as the node nearest to it
    assert found.parents.tolist() == [-1, 0]
    single = bones_of(Skeleton([[0, 0, 0]], [], [1.0], [0, 0]), max_bones=1)
    assert single.tails.tolist() == [[0, 1, 0]]
    two = Skeleton([[0, 0, 0], [2, 0, 0], [0, 5, 0], [2, 5, 0]], [[0, 1], [2, 3]], [0.1] * 4, [0, 1, 2, 3])
    assert (bones_of(two, max_bones=30).parents < 0).sum() == 2
    with pytest.raises(MeshError, match="max_bones must be at least 2, one for each component, not 1"):
        bones_of(two, max_bones=1)


@pytest.mark.parametrize(("radius", "root"), [(0.95, 1.0), (0.1, 4.0)])
def test_the_root_is_the_junction_fewest_of_its_radii_from_the_middle(radius, root):
    """Two junctions on a bar from x = -2 to 5, at 1 and 4; the latter has radius 1."""
    x = np.arange(-2.0, 6.0)
    nodes = np.concatenate([np.stack([x, 0 * x, 0 * x], axis=1), [[1, 1, 0], [4, 1, 0]]])
    edges = [*((k, k + 1) for k in range(7)), (3, 8), (6, 9)]
    radii = np.where(np.arange(10) == 6, 1.0, np.where(np.arange(10) == 3, radius, 0.3))
    assert bones_of(Skeleton(nodes, edges, radii, np.arange(10)), max_bones=30).heads[0][0] == root


def test_a_component_that_is_lost_leaves_no_edge_between_the_nodes_that_it_goes_to():
    arch = path([[-1, 3, 0], [-1, 0, 0], [1, 0, 0], [1, 3, 0]], 0.2)
    bead = path([[-0.3, 2, 0], [0.3, 2, 0]], 0.2)  # its left half goes to the left leg, its right half to the right one
    n = len(arch.nodes)
    both = Skeleton(
        np.concatenate([arch.nodes, bead.nodes]),
        np.concatenate([arch.edges, bead.edges + n]),
        np.full(n + len(bead.nodes), 0.2),
        np.arange(n + len(bead.nodes)),
    )
    alone, found = bones_of(arch, max_bones=30), bones_of(both, max_bones=30)
    assert np.array_equal(found.heads, alone.heads)
    assert np.array_equal(found.tails, alone.tails)
    assert np.array_equal(found.bone_of_vertex[:n], alone.bone_of_vertex)


@pytest.mark.parametrize("share", [1.0, 0.9, 0.3])
def test_stout_parts_of_about_one_length_have_bones_of_their_own(share):
    """Each is shorter than one bone; a third that is much shorter follows the nearest."""
    lengths = (2.0, 2.0, 2.0 * share)
    parts = [path([[6.0 * k, 0, 0], [6.0 * k, length, 0]], 1.0) for k, length in enumerate(lengths)]
    begins = np.cumsum([0, *(len(part.nodes) for part in parts)])
    nodes = np.concatenate([part.nodes for part in parts])
    edges = np.concatenate([part.edges + begin for part, begin in zip(parts, begins[:-1], strict=True)])
    found = bones_of(Skeleton(nodes, edges, np.ones(len(nodes)), np.arange(len(nodes))), max_bones=30)
    roots = np.flatnonzero(found.parents < 0)
    assert sorted(found.heads[roots, 0].tolist()) == [0.0, 6.0, 12.0][: 3 if share > 0.5 else 2]
    few = bones_of(Skeleton(nodes, edges, np.ones(len(nodes)), np.arange(len(nodes))), max_bones=2)
    assert len(few.heads) == 2  # the roots of two parts


def test_small_components_on_a_path_leave_no_cycle():
    nodes = [[0, -0.8, -1.3], [0, -0.8, 1.8], [0, 2, -0.7], [0.5, 0.7, -0.2], [0, 0, 0.2]]
    skeleton = Skeleton(nodes, [[0, 1], [1, 2], [3, 4]], [478.0, 426, 696, 152, 522], node_of_vertex=[0])
    assert len(bones_of(skeleton, max_bones=3).heads) <= 3
