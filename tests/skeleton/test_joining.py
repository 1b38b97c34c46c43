"""Components joined on request: as few edges and as short as may be, cycles and maps as they were."""

import numpy as np
import pytest
from helpers import joined, moved
from scipy.spatial.distance import cdist

from lbskel import Skeleton, UnknownChoice, join_components, skeletonize
from lbskel.shapes import torus


def dashes(n, seed=0, span=(1, 1, 1)):
    """Short sticks anywhere."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(size=(n, 3)) * span
    nodes = np.concatenate([start, start + 0.01 * rng.normal(size=(n, 3)) * span])
    return Skeleton(nodes, np.stack([np.arange(n), n + np.arange(n)], axis=1), np.full(2 * n, 0.01))


def shortest(skeleton):
    """The length of the shortest tree between the components, by Prim's rule on all pairs."""
    n = len(skeleton.nodes) // 2
    far = cdist(skeleton.nodes, skeleton.nodes).reshape(2, n, 2, n).min(axis=(0, 2))
    reached, total = np.zeros(n, dtype=bool), 0.0
    reached[0] = True
    while not reached.all():
        gaps = np.where(reached[:, None] & ~reached, far, np.inf)
        a, b = np.unravel_index(gaps.argmin(), gaps.shape)
        reached[b], total = True, total + gaps[a, b]
    return total


@pytest.mark.parametrize("span", [(1, 1, 1), (1, 1, 0), (1, 0, 0)])
@pytest.mark.parametrize("n", [2, 30, 90])
def test_the_edges_are_the_shortest_tree(n, span):
    given = dashes(n, span=span)
    whole = join_components(given)
    assert (whole.n_components, whole.cycle_rank) == (1, 0)
    assert whole.length - given.length == pytest.approx(shortest(given), rel=1e-6)


def test_what_is_too_far_stays_apart():
    given = dashes(30)
    near = join_components(given, reach=5.0)
    assert 1 < near.n_components < 30
    one, other = given.component_of_node[near.edges].T
    added = near.edge_lengths[one != other]
    assert len(added) == 30 - near.n_components
    assert added.max() <= 5.0 * 0.02
    with pytest.raises(UnknownChoice, match="reach must be positive"):
        join_components(given, reach=0.0)


def test_rings_keep_their_holes_and_the_map():
    ring = torus(1.0, 0.25, 16, 8)
    apart = skeletonize(joined(ring, moved(ring, 3.0), moved(ring, 6.0)))
    whole = join_components(apart)
    assert (whole.n_components, whole.cycle_rank) == (1, 3)
    assert np.array_equal(whole.node_of_vertex, apart.node_of_vertex)
    assert len(whole.edges) == len(apart.edges) + 2
    assert join_components(whole) is whole


def test_nodes_at_one_place_are_joined():
    whole = join_components(Skeleton(np.zeros((4, 3)), np.array([[0, 1], [2, 3]]), np.ones(4)))
    assert whole.n_components == 1
