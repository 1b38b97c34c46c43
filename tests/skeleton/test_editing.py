"""Edits of a skeleton's graph, on graphs small enough to be checked by hand."""

import numpy as np
import pytest

from lbskel import MeshError, Skeleton
from lbskel.skeleton.editing import (
    append_paths,
    concatenate,
    contract_branches,
    contract_new_tips,
    contract_nodes,
    replace_paths,
    reroot,
    split_edge,
)


def line(n_nodes, **more):
    """A path of nodes along x, one unit apart, with different radii."""
    nodes = np.arange(n_nodes)[:, None] * np.array([1.0, 0, 0])
    return Skeleton(nodes, [[k, k + 1] for k in range(n_nodes - 1)], 1.0 + np.arange(n_nodes), **more)


def test_contracted_nodes_take_position_radius_and_vertices_of_their_target():
    path = line(4, node_of_vertex=[0, 1, 2, 3, 2], mean_radii=[5.0, 6, 7, 8], anchors=[2])
    contracted = contract_nodes(path, np.array([0, 1, 1, 3]))
    assert contracted.nodes[:, 0].tolist() == [0, 1, 3]
    assert contracted.edges.tolist() == [[0, 1], [1, 2]]
    assert contracted.radii.tolist() == [1, 2, 4]
    assert contracted.mean_radii.tolist() == [5, 6, 8]
    assert contracted.node_of_vertex.tolist() == [0, 1, 1, 2, 1]
    assert contracted.anchors.tolist() == [1]


def test_branches_are_contracted_into_their_first_nodes():
    path = line(5, node_of_vertex=[0, 1, 2, 3, 4])
    contracted = contract_branches(path, [np.array([1, 0]), np.array([2, 3, 4])])
    assert contracted.nodes[:, 0].tolist() == [1, 2]
    assert contracted.node_of_vertex.tolist() == [0, 0, 1, 1, 1]
    assert contract_branches(path, []).nodes.tolist() == path.nodes.tolist()


def test_the_root_comes_first_and_the_others_keep_their_order():
    rooted = reroot(line(4, node_of_vertex=[0, 1, 2, 3], anchors=[0], mean_radii=[5.0, 6, 7, 8]), 2)
    assert rooted.nodes[:, 0].tolist() == [2, 0, 1, 3]
    assert rooted.edges.tolist() == [[0, 2], [0, 3], [1, 2]]
    assert rooted.radii.tolist() == [3, 1, 2, 4]
    assert rooted.mean_radii.tolist() == [7, 5, 6, 8]
    assert rooted.node_of_vertex.tolist() == [1, 2, 0, 3]
    assert rooted.anchors.tolist() == [1]


@pytest.mark.parametrize("node", [-1, 4])
def test_a_root_that_is_no_node_is_refused(node):
    with pytest.raises(MeshError, match=rf"there is no node {node} .* nodes 0\.\.3"):
        reroot(line(4), node)


def test_paths_are_appended_in_order_and_an_empty_one_adds_nothing():
    path = line(3, node_of_vertex=[0, 2], mean_radii=[5.0, 6, 7], anchors=[1])
    up = np.array([[1.0, 1, 0], [1, 2, 0]])
    ahead = np.array([[3.0, 0, 0]])
    longer = append_paths(path, [1, 0, 2], [up, np.empty((0, 3)), ahead], np.array([9.0, 8, 7]))
    assert np.array_equal(longer.nodes[3:], [*up, *ahead])
    assert longer.edges.tolist() == [[0, 1], [1, 2], [1, 3], [2, 5], [3, 4]]
    assert longer.radii.tolist() == [1, 2, 3, 9, 8, 7]
    assert longer.node_of_vertex.tolist() == [0, 2]
    assert longer.anchors.tolist() == [1]
    assert len(longer.mean_radii) == 0


def replaced_path(skeleton, nodes, positions, radii):
    """One path replaced."""
    return replace_paths(
        skeleton, np.array(nodes), np.array([0, len(nodes)]), positions, np.array([0, len(positions)]), radii
    )


def test_a_replaced_path_keeps_its_ends_and_its_vertices_stay_at_their_share_of_the_length():
    path = line(6, node_of_vertex=[0, 1, 2, 3, 4, 5], anchors=[5])
    detour = np.array([[1.5, 1, 0], [2.5, 1, 0], [3.5, 1, 0]])
    replaced = replaced_path(path, [1, 2, 3, 4], detour, np.array([9.0, 8, 7]))
    assert replaced.nodes[:4, 0].tolist() == [0, 1, 4, 5]
    assert np.array_equal(replaced.nodes[4:], detour)
    assert replaced.edges.tolist() == [[0, 1], [1, 4], [2, 3], [2, 6], [4, 5], [5, 6]]
    assert replaced.radii.tolist() == [1, 2, 5, 6, 9, 8, 7]
    # shares of 1/3 and 2/3; the detour's nodes are at 0.29, 0.5 and 0.71, which are 4, 5 and 6
    assert replaced.node_of_vertex.tolist() == [0, 1, 4, 6, 2, 3]
    assert replaced.anchors.tolist() == [3]
    uneven = replaced_path(path, [1, 2, 3, 4], np.array([[3.5, 0, 0]]), np.array([9.0]))  # at a share of 0.83
    assert uneven.node_of_vertex.tolist() == [0, 1, 1, 4, 2, 3]


def test_a_path_is_replaced_by_an_edge_and_a_loop_by_another_loop():
    straight = replaced_path(line(4), [0, 1, 2, 3], np.empty((0, 3)), np.empty(0))
    assert straight.edges.tolist() == [[0, 1]]
    assert straight.nodes[:, 0].tolist() == [0, 3]
    square = Skeleton([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1], [1, 2], [2, 3], [0, 3]], np.ones(4))
    loop = replaced_path(square, [0, 1, 2, 3, 0], np.array([[2.0, 0, 0], [0, 2, 0]]), np.ones(2))
    assert (loop.cycle_rank, len(loop.nodes)) == (1, 3)


def test_an_edge_is_split_at_a_node():
    split = split_edge(line(3, node_of_vertex=[0, 1, 2]), 1, np.array([1.5, 1, 0]), 9.0)
    assert split.edges.tolist() == [[0, 1], [1, 3], [2, 3]]
    assert split.nodes[3].tolist() == [1.5, 1, 0]
    assert split.radii[3] == 9
    assert split.node_of_vertex.tolist() == [0, 1, 2]


def test_concatenated_skeletons_keep_their_own_nodes_edges_maps_and_anchors():
    one = line(2, node_of_vertex=[0, 1, 1], mean_radii=[5.0, 6], anchors=[1])
    other = line(3, node_of_vertex=[2, 0], mean_radii=[7.0, 8, 9], anchors=[0])
    both = concatenate([one, other])
    assert both.nodes[:, 0].tolist() == [0, 1, 0, 1, 2]
    assert both.edges.tolist() == [[0, 1], [2, 3], [3, 4]]
    assert both.radii.tolist() == [1, 2, 1, 2, 3]
    assert both.node_of_vertex.tolist() == [0, 1, 1, 4, 2]
    assert both.mean_radii.tolist() == [5, 6, 7, 8, 9]
    assert both.anchors.tolist() == [1, 2]
    assert both.n_components == 2


def test_maps_and_mean_radii_that_one_skeleton_lacks_are_dropped():
    both = concatenate([line(2, node_of_vertex=[0, 1], mean_radii=[5.0, 6]), line(3)])
    assert (len(both.node_of_vertex), len(both.mean_radii)) == (0, 0)


def test_skeletons_of_different_radii_or_none_at_all_are_not_concatenated():
    with pytest.raises(MeshError, match="radii of one kind can be concatenated, not of inscribed and mean"):
        concatenate([line(2), line(2, radius_kind="mean")])
    with pytest.raises(MeshError, match="not of none"):
        concatenate([])


def test_new_tips_are_contracted_as_far_as_they_go():
    """A path of five nodes with a twig of two at its second node; the twig's tip and that of its end are new."""
    twig = Skeleton(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [1, 1, 0], [1, 2, 0]],
        [[0, 1], [1, 2], [2, 3], [1, 4], [4, 5]],
        np.ones(6),
        np.arange(6),
    )
    kept = contract_new_tips(twig, np.isin(np.arange(6), [0, 3]))
    assert kept.nodes.tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]
    assert kept.node_of_vertex.tolist() == [0, 1, 2, 3, 1, 1]
    assert contract_new_tips(twig, np.isin(np.arange(6), [0, 3, 5])) is twig
