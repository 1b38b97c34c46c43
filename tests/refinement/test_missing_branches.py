"""Regrowth: a limb without a branch has one grown along it, and a branch that strayed into another limb is led back."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.extrema import find_extrema
from lbskel.refinement.missing_branches import grow_missing_branches
from lbskel.shapes import make, sphere
from lbskel.skeleton.editing import contract_nodes


@pytest.fixture(scope="module")
def whole(tripod):
    return skeletonize(tripod)


def without(skeleton, way):
    """The skeleton without one end branch, whose vertices are the junction's."""
    target = np.arange(len(skeleton.nodes))
    target[way[1:]] = way[0]
    return contract_nodes(skeleton, target)


@pytest.mark.parametrize("number", range(3))
def test_a_branch_that_was_lost_grows_again(whole, tripod, number):
    way = whole.end_branches[number]
    grown = grow_missing_branches(without(whole, way), Surface(tripod))
    assert (len(grown.tips), len(grown.junctions), grown.cycle_rank, grown.n_components) == (3, 1, 0, 1)
    apart = np.linalg.norm(grown.nodes[grown.tips] - whole.nodes[way[-1]], axis=1)
    tip = grown.tips[apart.argmin()]
    assert apart.min() < whole.radii[way[-1]]  # within the last inscribed ball
    [again] = [w for w in grown.end_branches if w[-1] == tip]
    axis = np.linalg.norm(grown.nodes[again[1:], None] - whole.nodes[way], axis=2).min(axis=1)
    assert axis.max() < 0.5 * np.median(whole.radii[way])  # nodes are half a radius apart
    outer = np.isin(whole.node_of_vertex, way[len(way) // 2 :])
    assert np.isin(grown.node_of_vertex[outer], again[1:]).all()


def test_limbs_grow_on_a_bare_loop_too():
    """Of the branches of a ring with spikes none is left, and so no tip that an end could be near."""
    shape = make("spiked_ring", n_vertices=2500)
    skeleton = skeletonize(shape.mesh)
    target = np.arange(len(skeleton.nodes))
    for way in skeleton.end_branches:
        target[way[1:]] = way[0]
    loop = contract_nodes(skeleton, target)
    assert (len(loop.tips), loop.cycle_rank) == (0, 1)
    grown = grow_missing_branches(loop, Surface(shape.mesh))
    assert (len(grown.tips), grown.cycle_rank, grown.n_components) == (len(shape.truth.tips), 1, 1)


def test_what_is_complete_or_has_no_limbs_stays_as_it_is(whole, tripod):
    assert grow_missing_branches(whole, Surface(tripod)) is whole
    ball = sphere(3)
    skeleton = skeletonize(ball)
    assert grow_missing_branches(skeleton, Surface(ball)) is skeleton


def test_what_was_to_be_pruned_does_not_grow_again(whole, tripod):
    lost = without(whole, whole.end_branches[0])
    assert len(grow_missing_branches(lost, Surface(tripod), min_branch_ratio=100.0).nodes) == len(lost.nodes)


def test_a_branch_that_ends_in_another_limb_is_led_back_to_its_own(whole, tripod):
    """The branch of the first leg is laid beside the one of the second, and ends halfway down."""
    first, second, _ = whole.end_branches
    nodes = np.array(whole.nodes)
    share = np.linspace(0, 0.5, len(first))
    walk = np.linspace(0, 1, len(second))
    nodes[first] = np.stack([np.interp(share, walk, whole.nodes[second, axis]) for axis in range(3)], axis=1)
    led = grow_missing_branches(replace(whole, nodes=nodes), Surface(tripod))
    assert (len(led.tips), led.cycle_rank, led.n_components) == (3, 0, 1)
    apart = np.linalg.norm(led.nodes[led.tips][:, None] - whole.nodes[whole.tips], axis=2)
    assert sorted(apart.argmin(axis=1)) == [0, 1, 2]
    assert (apart.min(axis=1) < whole.radii[whole.tips[apart.argmin(axis=1)]]).all()


def test_the_vertices_of_a_limb_lie_about_its_end(tripod):
    found = find_extrema(tripod)
    assert len(found.vertices) == 3
    assert found.limb_of_vertex[found.vertices].tolist() == [0, 1, 2]
    apart = np.linalg.norm(tripod.vertices[:, None] - tripod.vertices[found.vertices], axis=2)
    is_outer = apart.min(axis=1) < found.lengths.min() / 2
    assert (apart.argmin(axis=1) == found.limb_of_vertex)[is_outer].all()
    assert 0.5 < (found.limb_of_vertex >= 0).mean() < 1
