"""Spurious loops: edges are removed from cycles around no tunnel, and from no other."""

import numpy as np
import pytest

from lbskel.contraction import spurious_loops
from lbskel.contraction.spurious_loops import PRIME, null_loop_edges, spurious_loop_edges
from lbskel.geometry.deadline import Deadline, OutOfTime

# two quadrangles with a common side, the shortest edge, so that each is closed by an edge of its own
NODES = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0.75, 0], [1, 0.25, 0], [3, 1, 0], [3, 0, 0]])
EDGES = np.array([[0, 1], [1, 2], [2, 3], [0, 3], [2, 4], [4, 5], [3, 5]])


def cochain_around(*values):
    """A cochain whose sums along the left and the right quadrangle are the values."""
    cochain = np.zeros((len(EDGES), 1), dtype=np.int64)
    cochain[0], cochain[5] = values
    return cochain


def removed_edges(*values):
    return [tuple(EDGES[row].tolist()) for row in spurious_loop_edges(NODES, EDGES, cochain_around(*values))]


def test_a_loop_around_a_tunnel_stays_and_one_around_none_is_opened():
    [edge] = removed_edges(1, 0)
    assert edge in {(2, 4), (4, 5), (3, 5)}
    [edge] = removed_edges(0, 1)
    assert edge in {(0, 1), (1, 2), (2, 3), (0, 3)}


def test_without_tunnels_a_tree_is_left():
    assert len(removed_edges(0, 0)) == 2


def test_of_two_loops_around_one_tunnel_the_one_with_the_longer_edge_stays():
    [edge] = removed_edges(1, 1)
    assert edge in {(0, 1), (1, 2), (2, 3), (0, 3)}


def test_loops_around_independent_tunnels_all_stay():
    cochain = np.zeros((len(EDGES), 2), dtype=np.int64)
    cochain[0, 0] = cochain[5, 1] = 1
    assert spurious_loop_edges(NODES, EDGES, cochain) == []


def test_sums_take_the_direction_of_each_edge_into_account():
    """A coboundary, the difference of a potential at the ends of each edge, sums to zero along every loop."""
    potential = np.array([3, -1, 4, 1, -5, 9])
    coboundary = (potential[EDGES[:, 1]] - potential[EDGES[:, 0]])[:, None]
    assert len(spurious_loop_edges(NODES, EDGES, coboundary)) == 2
    assert spurious_loop_edges(NODES, EDGES, coboundary + cochain_around(1, 0)) == spurious_loop_edges(
        NODES, EDGES, cochain_around(1, 0)
    )


@pytest.mark.parametrize("rank", [0, 1, 31, 33, 64, 90])
def test_as_many_of_hundreds_of_loops_stay_as_are_independent(rank):
    """A complete graph of 26 nodes, with 300 loops, and a cochain of that rank, up to coboundaries, in 90 columns."""
    rng = np.random.default_rng(0)
    nodes, edges = rng.random((26, 3)), np.stack(np.triu_indices(26, 1), axis=1)
    cochain = rng.integers(-3, 4, (len(edges), rank)) @ rng.integers(-3, 4, (rank, 90))
    spurious = spurious_loop_edges(nodes, edges, cochain)
    assert len(spurious) == 300 - rank
    assert spurious_loop_edges(nodes, np.delete(edges, spurious, axis=0), np.delete(cochain, spurious, axis=0)) == []


def test_loops_with_the_sum_zero_are_told_by_one_column():
    [row] = null_loop_edges(NODES, EDGES, cochain_around(5, 0))
    assert tuple(EDGES[row].tolist()) in {(2, 4), (4, 5), (3, 5)}
    assert null_loop_edges(NODES, EDGES, cochain_around(5, 7)) == []
    assert len(null_loop_edges(NODES, EDGES, cochain_around(0, 0))) == 2


def test_after_a_deadline_no_loops_are_compared():
    with pytest.raises(OutOfTime):
        spurious_loop_edges(NODES, EDGES, cochain_around(1, 1), deadline=Deadline(0.0))


def test_products_of_many_terms_are_exact():
    row = np.full((1, 20_000), float(PRIME - 1))
    assert spurious_loops._product(row, row.T) == 20_000
