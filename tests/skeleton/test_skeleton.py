"""Skeletons as graphs: degrees, branches, cycles, and invalid input."""

import copy
import pickle
from dataclasses import fields
from itertools import pairwise

import networkx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbskel import MeshError, Skeleton


def skeleton_of(edges, n=None, **more):
    """A skeleton of that graph, nodes on a parabola so that no two edges are of equal length."""
    n = (max(map(max, edges)) + 1 if edges else 1) if n is None else n
    x = np.arange(n, dtype=float)
    return Skeleton(np.stack([x, x**2, 0 * x], axis=1), edges, 0.1 + x, **more)


# by hand: edges, then tips, junctions, components, cycle rank and branches
GRAPHS = {
    "single node": ([], [], [], 1, 0, []),
    "one edge": ([(0, 1)], [0, 1], [], 1, 0, [[0, 1]]),
    "path": ([(0, 1), (1, 2), (2, 3)], [0, 3], [], 1, 0, [[0, 1, 2, 3]]),
    "path out of order": ([(2, 0), (0, 3), (3, 1)], [1, 2], [], 1, 0, [[1, 3, 0, 2]]),
    "star": ([(0, 1), (0, 2), (0, 3)], [1, 2, 3], [0], 1, 0, [[0, 1], [0, 2], [0, 3]]),
    "loop": ([(0, 1), (1, 2), (2, 0)], [], [], 1, 1, [[0, 1, 2, 0]]),
    "loop with a tail": ([(0, 1), (1, 2), (2, 0), (2, 3)], [3], [2], 1, 1, [[2, 0, 1, 2], [2, 3]]),
    "theta": (
        [(0, 1), (0, 2), (2, 1), (0, 3), (3, 1)],
        [],
        [0, 1],
        1,
        2,
        [[0, 1], [0, 2, 1], [0, 3, 1]],
    ),
    "two loops that meet": (
        [(0, 1), (1, 2), (2, 0), (2, 3), (3, 4), (4, 2)],
        [],
        [2],
        1,
        2,
        [[2, 0, 1, 2], [2, 3, 4, 2]],
    ),
    "path beside a loop": ([(0, 1), (2, 3), (3, 4), (4, 2)], [0, 1], [], 2, 1, [[0, 1], [2, 3, 4, 2]]),
}


@pytest.mark.parametrize("name", GRAPHS)
def test_graphs_by_hand(name):
    edges, tips, junctions, n_components, cycle_rank, branches = GRAPHS[name]
    skeleton = skeleton_of(edges)
    assert skeleton.tips.tolist() == tips
    assert skeleton.junctions.tolist() == junctions
    assert skeleton.n_components == n_components
    assert skeleton.cycle_rank == cycle_rank
    assert [branch.tolist() for branch in skeleton.branches] == branches


def test_an_isolated_node_is_a_component_and_no_branch():
    skeleton = skeleton_of([(0, 1)], n=3)
    assert (skeleton.n_components, skeleton.cycle_rank) == (2, 0)
    assert skeleton.degrees.tolist() == [1, 1, 0]
    assert [branch.tolist() for branch in skeleton.branches] == [[0, 1]]
    assert [near.tolist() for near in skeleton.neighbors] == [[1], [0], []]


def test_branches_have_ends_of_their_own():
    nodes = np.eye(3)[[0, 1, 2, 0]] * [[1], [1], [1], [2]]
    ring_on_a_stalk = Skeleton(nodes, [[0, 1], [1, 2], [0, 2], [0, 3]], [1] * 4)
    assert sorted(ring_on_a_stalk.branch_ends.tolist()) == [[0, 0], [0, 3]]
    assert Skeleton(np.eye(3), [], [1] * 3).branch_ends.shape == (0, 2)


def test_end_branches_lead_from_a_junction_to_a_tip():
    forward = skeleton_of([(0, 1), (1, 2), (2, 0), (2, 3), (3, 4)])  # a loop with a tail
    assert [branch.tolist() for branch in forward.end_branches] == [[2, 3, 4]]
    backward = skeleton_of([(0, 1), (1, 2), (2, 3), (2, 4), (3, 4)])
    assert [branch.tolist() for branch in backward.end_branches] == [[2, 1, 0]]
    for without in ([], [(0, 1), (1, 2)], [(0, 1), (1, 2), (2, 0)]):  # no junction: a path has two tips, a loop none
        assert skeleton_of(without).end_branches == []


def test_an_empty_skeleton():
    skeleton = Skeleton([], [], [])
    assert skeleton.nodes.shape == (0, 3)
    assert skeleton.edges.shape == (0, 2)
    assert (skeleton.n_components, skeleton.cycle_rank, skeleton.length) == (0, 0, 0.0)
    assert (skeleton.neighbors, skeleton.branches) == ((), ())


def test_edges_come_sorted_once_each_and_without_loops():
    skeleton = skeleton_of([(3, 1), (1, 3), (2, 2), (1, 0)])
    assert skeleton.edges.tolist() == [[0, 1], [1, 3]]


def test_length_is_that_of_the_polyline():
    skeleton = Skeleton([[0, 0, 0], [3, 4, 0], [3, 4, 12]], [[0, 1], [1, 2]], [1, 1, 1])
    assert skeleton.edge_lengths.tolist() == [5, 12]
    assert skeleton.length == 17


def test_repr():
    skeleton = skeleton_of(GRAPHS["loop with a tail"][0])
    assert repr(skeleton) == "Skeleton(4 nodes, 4 edges, 1 tip, 1 junction, 1 cycle)"


@st.composite
def graphs(draw):
    n = draw(st.integers(1, 12))
    pairs = st.tuples(st.integers(0, n - 1), st.integers(0, n - 1))
    return skeleton_of(draw(st.lists(pairs, max_size=25)), n=n)


@given(graphs())
def test_branches_use_every_edge_once_and_end_where_it_is_not_two(skeleton):
    walked = [tuple(sorted(pair)) for branch in skeleton.branches for pair in pairwise(branch.tolist())]
    assert sorted(walked) == [tuple(edge) for edge in skeleton.edges.tolist()]
    for branch in skeleton.branches:
        assert (skeleton.degrees[branch[1:-1]] == 2).all()
        is_bare_loop = branch[0] == branch[-1] and skeleton.degrees[branch[0]] == 2
        assert is_bare_loop or (skeleton.degrees[branch[[0, -1]]] != 2).all()
    first = [branch[0] for branch in skeleton.branches if skeleton.degrees[branch[0]] != 2]
    assert first == sorted(first)


@given(graphs())
def test_counts_agree_with_networkx(skeleton):
    graph = skeleton.to_networkx()
    assert networkx.number_connected_components(graph) == skeleton.n_components
    assert len(networkx.cycle_basis(graph)) == skeleton.cycle_rank
    assert [degree for _, degree in sorted(graph.degree)] == skeleton.degrees.tolist()
    assert [sorted(graph[node]) for node in sorted(graph)] == [near.tolist() for near in skeleton.neighbors]
    labels = skeleton.component_of_node
    assert all(len(set(labels[list(part)])) == 1 for part in networkx.connected_components(graph))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 0, 0]], [], [1, 2]), "a skeleton of 1 nodes needs as many radii, not 2"),
        (([[0, 0, 0]] * 3, [[0, 3]], [1, 1, 1]), r"edges of the skeleton name a node outside 0\.\.2"),
        (([[0, 0, 0]] * 3, [[0, -1]], [1, 1, 1]), r"edges of the skeleton name a node outside 0\.\.2"),
        (([[0, 0, 0]] * 3, [], [1, 1, 1], [0, 3]), r"node_of_vertex of the skeleton name a node outside 0\.\.2"),
        (([[0, 0, 0]] * 3, [], [1, 1, 1], [-1]), r"node_of_vertex of the skeleton name a node outside 0\.\.2"),
        (([[0, 0], [1, 1], [2, 2]], [], [1, 1]), r"nodes of a skeleton must have shape \(k, 3\), not \(3, 2\)"),
        (([[0, 0, 0], [0, np.inf, 0]], [], [1, 1]), "nodes 1 of the skeleton have NaN or infinite coordinates"),
        (([0, 0, 0], [], [1]), r"nodes of a skeleton must have shape \(k, 3\), not \(3,\)"),
        (([[0, 0, 0]] * 3, [[0, 1, 2]], [1, 1, 1]), r"edges of a skeleton must have shape \(k, 2\), not \(1, 3\)"),
        (([[0, 0, 0]] * 3, [[0, 0.5]], [1, 1, 1]), "edges of a skeleton must be whole numbers"),
        (([[0, 0, 0]] * 3, [[0, np.nan]], [1, 1, 1]), "edges of a skeleton must be whole numbers"),
        (([[0, 0, 0], [1, 1]], [], [1, 1]), "nodes of a skeleton must be an array of numbers"),
        ((["abc"], [], [1]), "nodes of a skeleton must be an array of numbers"),
        (([[0, 0, 0]], [], ["thick"]), "radii of a skeleton must be an array of numbers"),
        (([[0, 0, 0]], [], [1], [0.5]), "node_of_vertex of a skeleton must be whole numbers"),
        (([[0, 0, 0]], [], [1], [], "inscribed", [1, 2]), "needs as many mean radii, or none, not 2"),
        (([[0, 0, 0]], [], [1], [], "inscribed", [], [1]), r"anchors of the skeleton name a node outside 0\.\.0"),
    ],
)
def test_invalid_input_is_refused(arguments, message):
    with pytest.raises(MeshError, match=message):
        Skeleton(*arguments)


def test_arrays_are_read_only_copies_of_the_documented_types():
    nodes = np.zeros((3, 3), dtype=np.float32)
    skeleton = Skeleton(nodes, np.array([[0, 1]], dtype=np.uint8), [1, 2, 3], [0, 1, 2, 2])
    nodes[:] = 7
    assert not skeleton.nodes.any()
    kinds = {"nodes": np.float64, "edges": np.int64, "radii": np.float64, "node_of_vertex": np.int64}
    assert {name: getattr(skeleton, name).dtype for name in kinds} == kinds
    derived = [skeleton.degrees, skeleton.edge_lengths, skeleton.component_of_node]
    for array in (*(getattr(skeleton, name) for name in kinds), *derived, *skeleton.neighbors, *skeleton.branches):
        assert not array.flags.writeable
    with pytest.raises(AttributeError):
        skeleton.nodes = nodes


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda skeleton: pickle.loads(pickle.dumps(skeleton))])
def test_copies_are_constant_and_measure_anew(copied):
    whole = Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 2], [0, 1, 1], "mean", [3, 4], [1], {"verdict": "pass"})
    assert whole.length == 1  # computed once
    again = copied(whole)
    for each in fields(Skeleton):
        before, after = getattr(whole, each.name), getattr(again, each.name)
        assert np.array_equal(before, after) if isinstance(before, np.ndarray) else before == after
        assert not isinstance(after, np.ndarray) or not after.flags.writeable
    assert "edge_lengths" not in vars(again)


@pytest.mark.parametrize(
    ("nodes", "edges", "message"),
    [
        (np.ma.masked_equal([[0.0, 0, 0], [1, 0, -9]], -9), [[0, 1]], "nodes of a skeleton have masked entries"),
        ([[0, 0, 0], [1, 0, 1j]], [[0, 1]], "nodes of a skeleton must be an array of numbers: not of complex ones"),
        ([[0, 0, 0], [1, 0, 0]], [[0, 2**70]], "edges of a skeleton must be an array of numbers"),
    ],
)
def test_what_are_no_numbers_is_refused(nodes, edges, message):
    with pytest.raises(MeshError, match=message):
        Skeleton(nodes, edges, [1, 1])
