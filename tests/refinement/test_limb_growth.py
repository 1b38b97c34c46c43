"""Growth of limbs: a limb without a branch gets one, and nothing else does."""

import numpy as np
import pytest
from helpers import reversed_proxy

from lbskel import skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.limb_growth import _centered, _not_covered, grow_uncovered_limbs
from lbskel.shapes import make, sphere
from lbskel.skeleton.editing import contract_nodes


@pytest.fixture(scope="module")
def whole(tripod):
    return skeletonize(tripod)


def without(skeleton, branch):
    """The skeleton without one end branch, whose vertices are the junction's."""
    target = np.arange(len(skeleton.nodes))
    target[branch[1:]] = branch[0]
    return contract_nodes(skeleton, target)


@pytest.mark.parametrize("surface_of", [Surface, reversed_proxy])
@pytest.mark.parametrize("number", range(3))
def test_a_removed_branch_grows_again(whole, tripod, number, surface_of):
    branch = whole.end_branches[number]
    grown = grow_uncovered_limbs(without(whole, branch), surface_of(tripod))
    assert (len(grown.tips), len(grown.junctions), grown.cycle_rank, grown.n_components) == (3, 1, 0, 1)
    distances = np.linalg.norm(grown.nodes[grown.tips] - whole.nodes[branch[-1]], axis=1)
    tip = grown.tips[distances.argmin()]
    assert distances.min() < whole.radii[branch[-1]]  # within the last inscribed ball
    [again] = [b for b in grown.end_branches if b[-1] == tip]
    axis = np.linalg.norm(grown.nodes[again[1:], None] - whole.nodes[branch], axis=2).min(axis=1)
    assert axis.max() < 0.5 * np.median(whole.radii[branch])  # nodes are half a radius distances
    outer = np.isin(whole.node_of_vertex, branch[len(branch) // 2 :])
    assert np.isin(grown.node_of_vertex[outer], again[1:]).all()
    for other in whole.end_branches:  # the vertices at the other ends keep their nodes
        if other[-1] != branch[-1]:
            at_end = np.isin(whole.node_of_vertex, other[len(other) // 2 :])
            assert np.array_equal(grown.nodes[grown.node_of_vertex[at_end]], whole.nodes[whole.node_of_vertex[at_end]])


def test_branches_grow_on_a_bare_loop_too():
    """All branches of a ring with spikes are removed, so there is no tip near any end."""
    shape = make("spiked_ring", n_vertices=2500)
    skeleton = skeletonize(shape.mesh)
    target = np.arange(len(skeleton.nodes))
    for branch in skeleton.end_branches:
        target[branch[1:]] = branch[0]
    loop = contract_nodes(skeleton, target)
    assert (len(loop.tips), loop.cycle_rank) == (0, 1)
    grown = grow_uncovered_limbs(loop, Surface(shape.mesh))
    assert (len(grown.tips), grown.cycle_rank, grown.n_components) == (len(shape.truth.tips), 1, 1)


def test_a_complete_skeleton_is_returned_unchanged(whole, tripod):
    assert grow_uncovered_limbs(whole, Surface(tripod)) is whole
    ball = sphere(3)
    skeleton = skeletonize(ball)
    assert grow_uncovered_limbs(skeleton, Surface(ball)) is skeleton


def test_of_two_limbs_whose_ends_lie_on_one_axis_the_first_gets_a_branch():
    ends = np.array([[0.0, 0, 5], [0.3, 0, 3], [9, 0, 0]])
    axes = [np.array([[0.0, 0, z] for z in range(1, 5)]), np.array([[0.1, 0, 2.0]]), np.array([[8.0, 0, 0]])]
    assert _not_covered(ends, axes, [np.full(len(axis), 0.5) for axis in axes]) == [0, 2]
    assert _not_covered(ends, axes, [np.full(len(axis), 0.2) for axis in axes]) == [0, 1, 2]


def test_points_of_an_axis_inside_the_body_are_dropped():
    ball = sphere(3)
    drawn = ball.with_vertices(ball.vertices * np.where(ball.vertices[:, 2:] > 0.9, [1, 1, 4], 1))
    axis = np.array([[0.05, 0, z] for z in (0.0, 0.3, 1.5, 2.5, 3.5)])
    [points], [widths] = _centered([axis], np.array([0.4]), Surface(drawn))
    assert points == pytest.approx(np.array([[0, 0, z] for z in (1.5, 2.5, 3.5)]), abs=0.02)  # the triangles are coarse
    assert (widths < 0.5).all()
