"""Joining: the shortest edges between components, with cycles and the map unchanged."""

import numpy as np
import pytest
from helpers import joined, moved
from scipy.spatial.distance import cdist

from lbskel import Skeleton, UnknownChoice, join_components, skeletonize
from lbskel.shapes import torus


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
