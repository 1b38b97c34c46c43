"""Parents, Strahler orders and angles: by hand on small graphs, and as NeuroM computes them."""

import numpy as np
import pytest

from lbskel import Skeleton, write_skeleton
from lbskel.applications.branch_tree import branch_order


def fork():
    """A trunk, two limbs, and two twigs on the first: nodes 0 to 5."""
    nodes = [[0, 0, 0], [0, 0, 4], [3, 0, 7], [-2, 0, 6], [3, 0, 9], [5, 0, 9]]
    return Skeleton(nodes, [[0, 1], [1, 2], [1, 3], [2, 4], [2, 5]], np.ones(6))


def test_a_tree_by_hand():
    order = branch_order(fork())
    assert [path.tolist() for path in order.paths] == [[0, 1], [1, 2], [1, 3], [2, 4], [2, 5]]
    assert order.parents.tolist() == [-1, 0, 0, 1, 1]
    assert order.centrifugal.tolist() == [0, 1, 1, 2, 2]
    assert order.strahler.tolist() == [2, 2, 1, 1, 1]  # the trunk has children of orders 2 and 1
    assert order.local_angles[:2] == pytest.approx([90, 45])
    assert np.isnan(order.local_angles[2:]).all()


def test_a_tree_from_a_root_in_the_middle_of_a_branch_and_from_a_junction():
    nodes = [[2.0, 0, 0], [0, 0, 0], [4, 0, 0], [-1, 1, 0], [-1, -1, 0], [5, 1, 0], [5, -1, 0]]
    edges = [[0, 1], [0, 2], [1, 3], [1, 4], [2, 5], [2, 6]]
    middle = branch_order(Skeleton(nodes, edges, np.ones(7)))
    assert [tuple(sorted(path[[0, -1]].tolist())) for path in middle.paths] == [(1, 2), (1, 3), (1, 4), (2, 5), (2, 6)]
    assert middle.parents.tolist() == [-1, 0, 0, 0, 0]
    assert middle.centrifugal.tolist() == [0, 1, 1, 1, 1]
    assert middle.strahler.tolist() == [2, 1, 1, 1, 1]
    junction = branch_order(Skeleton(nodes, [[0, 1], [0, 2], [0, 3], [1, 4]], np.ones(7)))
    assert junction.parents.tolist() == [-1, -1, -1]
    assert junction.centrifugal.tolist() == [0, 0, 0]


def test_children_at_both_ends_of_a_branch_have_no_angle():
    """The root is inside a branch, between two loops, each of which is one child."""
    nodes = [[0, 0, 0], [1, 0, 0], [-1, 0, 0], [2, 1, 0], [2, -1, 0], [-2, 1, 0], [-2, -1, 0]]
    edges = [[0, 1], [0, 2], [1, 3], [3, 4], [4, 1], [2, 5], [5, 6], [6, 2]]
    order = branch_order(Skeleton(nodes, edges, np.ones(7)))
    assert order.parents.tolist() == [-1, 0, 0]
    assert np.isnan(order.local_angles).all()
    assert np.isnan(order.remote_angles).all()


def test_cycles_components_and_single_nodes():
    """A ring on a stick: the ring hangs on the stick; a ring alone has no parent; a node alone is no branch."""
    ring = [[0, 1], [1, 2], [2, 3], [1, 3], [4, 5], [5, 6], [4, 6]]
    points = np.random.default_rng(0).random((8, 3))
    order = branch_order(Skeleton(points, ring, np.ones(8)))
    assert [len(path) for path in order.paths] == [2, 4, 4]
    assert order.parents.tolist() == [-1, 0, -1]
    assert order.centrifugal.tolist() == [0, 1, 0]
    assert order.strahler.tolist() == [1, 1, 1]
    assert branch_order(Skeleton(points, [], np.ones(8))).paths == ()
    assert branch_order(Skeleton([], [], [])).paths == ()


def test_two_junctions_joined_by_three_paths_and_nodes_at_one_place():
    """The two longer paths close cycles: they hang on the shortest, or on the root."""
    theta = Skeleton(np.zeros((5, 3)), [[0, 1], [0, 2], [2, 1], [0, 3], [3, 1], [1, 4]], np.ones(5))
    order = branch_order(theta)
    assert sorted(order.parents.tolist()) == [-1, -1, -1, int(np.flatnonzero([len(p) == 2 for p in order.paths])[0])]
    assert np.isnan(order.remote_angles).all()


def test_orders_and_angles_are_those_of_neurom(tmp_path):
    neurom = pytest.importorskip("neurom")
    rng = np.random.default_rng(1)
    nodes, edges, open_ends = [np.zeros(3)], [], [0]
    for _ in range(40):  # a random tree whose branches have three edges each
        node = open_ends.pop(int(rng.integers(len(open_ends))))
        for _ in range(1 if node == 0 else 2):
            last = node
            for _ in range(3):
                nodes.append(nodes[last] + rng.normal(size=3) + [0, 0, 1])
                edges.append([last, len(nodes) - 1])
                last = len(nodes) - 1
            open_ends.append(last)
    tree = Skeleton(np.array(nodes), edges, np.ones(len(nodes)))
    write_skeleton(tmp_path / "tree.swc", tree)
    neuron = neurom.load_morphology(tmp_path / "tree.swc")
    order = branch_order(tree)
    ours = {tuple(np.round(tree.nodes[path[-1]], 3)): row for row, path in enumerate(order.paths)}
    sections = list(neurom.iter_sections(neuron))
    rows = [ours[tuple(np.round(np.asarray(section.points[-1][:3], float), 3))] for section in sections]
    assert len(sections) == len(order.paths) == len(set(rows))
    from neurom.features import bifurcation, section

    assert order.centrifugal[rows].tolist() == [section.branch_order(each) for each in sections]
    assert order.strahler[rows].tolist() == [section.strahler_order(each) for each in sections]
    for row, each in zip(rows, sections, strict=True):
        if len(each.children) == 2:  # NeuroM stores positions in single precision
            local, remote = bifurcation.local_bifurcation_angle(each), bifurcation.remote_bifurcation_angle(each)
            assert order.local_angles[row] == pytest.approx(np.degrees(local), abs=1e-3)
            assert order.remote_angles[row] == pytest.approx(np.degrees(remote), abs=1e-3)
