"""Cycles cut where they are thinnest, against every way to cut them and against networkx."""

import itertools

import networkx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbskel import Skeleton, score, skeletonize, to_tree
from lbskel.shapes import torus
from lbskel.skeleton.spanning_tree import cycle_edges

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
RING = [[0, 1], [1, 2], [2, 3], [0, 3]]


def removed(skeleton):
    return {tuple(edge) for edge in skeleton.edges[cycle_edges(skeleton)].tolist()}


def test_the_thinnest_place_is_cut_and_not_the_longest_edge():
    nodes = [[0, 0, 0], [9, 0, 0], [9, 1, 0], [0, 1, 0]]  # 0-1 and 2-3 are long
    assert removed(Skeleton(nodes, RING, [5, 4, 2, 3])) == {(2, 3)}  # both edges at node 2 are thin: the longer
    assert removed(Skeleton(nodes, RING, [2, 4, 5, 3])) == {(0, 1)}
    narrow = [[0, 0, 0], [9, 0, 0], [9, 1, 0], [9, 1.5, 0], [0, 1, 0]]
    ring = [[0, 1], [1, 2], [2, 3], [3, 4], [0, 4]]
    assert removed(Skeleton(narrow, ring, [5, 5, 1, 5, 5])) == {(1, 2)}  # 2-3 is shorter, 0-1 and 3-4 are thicker


def test_of_equally_thin_edges_the_longest_is_cut_and_of_equally_long_ones_the_last():
    assert removed(Skeleton([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.1, 0]], RING, np.ones(4))) == {(0, 3)}
    assert removed(Skeleton(SQUARE, RING, np.ones(4))) == {(2, 3)}  # sorted: 0-1, 0-3, 1-2, 2-3


@pytest.mark.parametrize(("radii", "cut"), [([np.nan] * 4, (2, 3)), ([1, np.nan, np.nan, np.nan], (0, 3))])
def test_unknown_radii_count_as_thick(radii, cut):
    assert removed(Skeleton(SQUARE, RING, radii)) == {cut}


def test_only_edges_change():
    skeleton = skeletonize(torus(1.0, 0.3))
    tree = to_tree(skeleton)
    assert (skeleton.cycle_rank, tree.cycle_rank, tree.n_components) == (1, 0, 1)
    assert len(tree.edges) == len(skeleton.edges) - 1
    for name in ("nodes", "radii", "node_of_vertex", "mean_radii", "anchors"):
        assert getattr(tree, name).tobytes() == getattr(skeleton, name).tobytes()
    assert to_tree(tree).edges.tolist() == tree.edges.tolist()
    assert (tree.report["loops_opened"], tree.report["cycles_cut"]) == (0, 1)
    assert score(tree, torus(1.0, 0.3)).extra_cycles == 0


@st.composite
def graphs(draw):
    k = draw(st.integers(2, 8))
    ends = st.integers(0, k - 1)
    edges = draw(st.lists(st.tuples(ends, ends), min_size=1, max_size=14))
    radii = draw(st.lists(st.integers(1, 4), min_size=k, max_size=k))
    return Skeleton(np.random.default_rng(k).normal(size=(k, 3)), np.reshape(edges, (-1, 2)), radii)


@given(skeleton=graphs())
def test_the_tree_keeps_the_components_and_the_most_thickness(skeleton):
    tree = to_tree(skeleton)
    assert (tree.cycle_rank, tree.n_components) == (0, skeleton.n_components)
    weighted = networkx.Graph()
    weighted.add_nodes_from(range(len(skeleton.nodes)))
    radius = skeleton.radii[skeleton.edges].min(axis=1)
    weighted.add_weighted_edges_from((a, b, r) for (a, b), r in zip(skeleton.edges.tolist(), radius, strict=True))
    best = networkx.maximum_spanning_tree(weighted).size("weight")
    assert tree.radii[tree.edges].min(axis=1).sum() == best


@given(skeleton=graphs())
def test_each_edge_that_is_cut_is_the_thinnest_of_the_cycle_that_it_closes(skeleton):
    tree = to_tree(skeleton).to_networkx()
    for a, b in removed(skeleton):
        path = networkx.shortest_path(tree, a, b)
        along = [min(skeleton.radii[[c, d]]) for c, d in itertools.pairwise(path)]
        assert min(skeleton.radii[[a, b]]) <= min(along)
