"""Sharp bends: spurs in corners are contracted, limbs are kept."""

import numpy as np
import pytest

from lbskel import Skeleton, skeletonize
from lbskel.refinement.bends import contract_corner_spurs
from lbskel.refinement.centerlines import SectionCenters
from lbskel.shapes.hard import HARD_SHAPES

RADIUS = 0.5  # of the rod, whose axis is that of the bends: of the ball at a tip


def graph_of_bend(tip_at=(0.0, 0.0, 0.0)):
    """A spur to a tip, and two limbs at 40 degrees whose axes meet in the origin, above the junction of the three.

    The limbs part where their axes are a diameter apart; from the second of the six nodes of each on, nodes are known.
    """
    sine, cosine = np.sin(np.radians(20)), np.cos(np.radians(20))
    along = RADIUS / sine + np.arange(1, 7)[:, None]
    limbs = [along * [side * sine, 0, -cosine] for side in (-1, 1)]
    junction = np.array([0, 0, -RADIUS / sine * cosine])
    nodes = np.concatenate([[junction, (junction + tip_at) / 2, tip_at], *limbs])
    edges = [[0, 1], [1, 2], [0, 3], *([k, k + 1] for k in range(3, 8)), [0, 9], *([k, k + 1] for k in range(9, 14))]
    graph = Skeleton(nodes, edges, np.full(len(nodes), RADIUS), node_of_vertex=np.arange(len(nodes)))
    return graph, SectionCenters(~np.isin(np.arange(len(nodes)), [0, 1, 2, 3, 9]), nodes)


def test_the_spur_in_the_corner_of_a_bend_is_contracted(rod_along_z):
    graph, centers = graph_of_bend()
    bent = contract_corner_spurs(graph, graph, centers, rod_along_z)
    assert (len(bent.tips), len(bent.junctions)) == (2, 0)
    corner = bent.node_of_vertex[0]
    assert np.allclose(bent.nodes[corner], 0, atol=1e-12)
    assert (bent.node_of_vertex[[1, 2]] == corner).all()
    # the nodes before the last own section go to the straight line to the corner, the others stay
    assert np.allclose(bent.nodes[bent.node_of_vertex[[3, 9]]], graph.nodes[[4, 10]] / 2, atol=1e-12)
    assert np.array_equal(bent.nodes[bent.node_of_vertex[centers.is_known]], graph.nodes[centers.is_known])


@pytest.mark.parametrize(("height", "is_kept"), [(0.99 * RADIUS, False), (1.01 * RADIUS, True), (5.0, True)])
def test_a_limb_whose_tip_is_not_where_the_others_meet_is_kept(height, is_kept, rod_along_z):
    graph, centers = graph_of_bend((0.0, 0.0, height))
    assert (contract_corner_spurs(graph, graph, centers, rod_along_z) is graph) == is_kept


def test_a_branch_between_two_junctions_is_no_spur(rod_along_z):
    """Two branches leave from where the tip of a spur would be, a hair beside each other."""
    graph, centers = graph_of_bend()
    n = len(graph.nodes)
    forked = Skeleton(
        np.concatenate([graph.nodes, [[0.1, 0, 0.1], [-0.1, 0, 0.1]]]),
        [*graph.edges.tolist(), [2, n], [2, n + 1]],
        np.full(n + 2, RADIUS),
    )
    known = SectionCenters(np.append(centers.is_known, [False, False]), forked.nodes)
    assert contract_corner_spurs(forked, forked, known, rod_along_z) is forked


def test_limbs_that_pass_each_other_have_no_corner(rod_along_z):
    graph, centers = graph_of_bend()
    shifted = centers.positions + np.where(np.arange(len(graph.nodes)) >= 9, 1.01 * RADIUS, 0.0)[:, None] * [0, 1, 0]
    assert contract_corner_spurs(graph, graph, SectionCenters(centers.is_known, shifted), rod_along_z) is graph


def test_parallel_limbs_have_no_corner(rod_along_z):
    limbs = [[[x, 0, -z] for z in (1, 2, 3)] for x in (-0.1, 0.1)]
    nodes = np.array([[0, 0, 0], [0, 0, 0.1], [0, 0, 0.2], *limbs[0], *limbs[1]], dtype=float)
    edges = [[0, 1], [1, 2], [0, 3], [3, 4], [4, 5], [0, 6], [6, 7], [7, 8]]
    graph = Skeleton(nodes, edges, np.full(9, RADIUS))
    assert contract_corner_spurs(graph, graph, SectionCenters(np.arange(9) >= 3, nodes), rod_along_z) is graph


def test_an_anchor_in_a_corner_is_kept(rod_along_z):
    graph, centers = graph_of_bend()
    anchored = Skeleton(graph.nodes, graph.edges, graph.radii, anchors=[2])
    assert contract_corner_spurs(anchored, anchored, centers, rod_along_z) is anchored


def test_a_zigzag_is_one_line():
    shape = HARD_SHAPES["zigzag"](degrees=35.0, n_bends=1)
    skeleton = skeletonize(shape.mesh)
    assert (len(skeleton.tips), len(skeleton.junctions)) == (2, 0)
