"""The root of a tree: a soma by its thickness, else the thickest tip."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Skeleton, skeletonize
from lbskel.shapes import mesh_solid, solid_of, tube, vessel_tree
from lbskel.skeleton.root import find_roots, find_soma, is_in_soma, reroot_by_thickness, with_mean_radii


def neuron(ratio, *, length=30, at=7):
    """A line along x whose node ``at`` has radius 1, the others 1 / ratio, half a unit apart."""
    nodes = np.zeros((length, 3))
    nodes[:, 0] = 0.5 * np.arange(length)
    radii = np.full(length, 1 / ratio)
    radii[at] = 1.0
    return Skeleton(nodes, np.stack([np.arange(length - 1), np.arange(1, length)], axis=1), radii)


def test_a_soma_is_four_times_as_thick_as_every_branch_that_leaves_it():
    assert find_soma(neuron(4.1)) == 7
    assert find_soma(neuron(3.9)) is None
    lopsided = neuron(8.0)
    radii = lopsided.radii.copy()
    radii[20:] = 0.3  # far from the soma
    assert find_soma(Skeleton(lopsided.nodes, lopsided.edges, radii)) == 7
    radii[12:] = 0.3  # where one branch is two radii away
    assert find_soma(Skeleton(lopsided.nodes, lopsided.edges, radii)) is None


def test_a_soma_is_three_times_as_thick_by_mean_radii():
    """Tubes that are fitted widen farther from the soma than the surface does."""
    assert find_soma(replace(neuron(3.1), radius_kind="mean")) == 7
    assert find_soma(replace(neuron(2.9), radius_kind="mean")) is None


def test_a_node_is_in_the_soma_within_its_radius():
    cell = neuron(8.0)
    assert [node for node in range(30) if is_in_soma(cell, node)] == [5, 6, 7, 8, 9]
    assert not is_in_soma(neuron(2.0), 7)


def test_branches_of_unknown_radius_do_not_hide_a_soma():
    given = neuron(8.0)
    radii = given.radii.copy()
    radii[10:] = np.nan
    assert find_soma(Skeleton(given.nodes, given.edges, radii)) == 7


def test_what_is_within_two_and_a_half_radii_belongs_to_the_soma():
    given = neuron(8.0)
    radii = given.radii.copy()
    radii[2:13] = 0.9
    radii[7] = 1.0
    assert find_soma(Skeleton(given.nodes, given.edges, radii)) == 7
    assert find_soma(Skeleton(given.nodes[2:13], given.edges[:10], radii[2:13])) is None  # no branch leaves it


def test_a_limb_that_only_passes_by_is_no_branch_of_the_soma():
    given = neuron(8.0)
    nodes = np.concatenate([given.nodes, given.nodes + [0.0, 1.5, 0.0]])
    edges = np.concatenate([given.edges, given.edges + len(given.nodes)])
    assert find_soma(Skeleton(nodes, edges, np.append(given.radii, np.full(len(given.nodes), 0.9)))) == 7


@pytest.mark.parametrize("radii", [[np.nan, np.nan], [0, 0]])
def test_without_radii_there_is_no_soma_and_the_first_node_stays(radii):
    pair = Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], radii)
    assert find_soma(pair) is None
    assert reroot_by_thickness(pair).nodes.tolist() == pair.nodes.tolist()


def test_an_empty_skeleton_stays_empty():
    empty = Skeleton([], [], [])
    assert reroot_by_thickness(empty) is empty


def test_the_thickest_tip_of_each_component():
    nodes = np.random.default_rng(0).normal(size=(9, 3))
    edges = [[0, 1], [1, 2], [3, 4], [4, 5], [3, 5], [6, 7]]
    skeleton = Skeleton(nodes, edges, [1, 9, 2, 1, 2, 3, np.nan, 0.5, 1])
    assert find_roots(skeleton).tolist() == [2, 3, 7, 8]  # a ring begins at its first node, a node at itself
    assert reroot_by_thickness(skeleton).nodes[0].tolist() == nodes[2].tolist()


@pytest.fixture(scope="module")
def cell():
    """A ball of radius 1 at x = 5 on a limb of radius 0.2 along x, closed: 2354 vertices."""
    x = np.linspace(0, 14, 141)
    return tube(np.outer(x, [1, 0, 0]), np.sqrt(np.maximum(0.2**2, 1 - (x - 5) ** 2)), rounded=True)


def test_the_skeleton_of_a_cell_begins_at_its_soma_unless_a_root_is_given(cell):
    for options in ({}, {"n_nodes": 30}):
        skeleton = skeletonize(cell, **options)
        assert find_soma(skeleton) == 0
        assert skeleton.nodes[0, 0] == pytest.approx(5, abs=0.5)  # half a radius, the spacing of nodes
    end = skeletonize(cell, root=[14, 0, 0])
    assert end.nodes[0, 0] > 13
    assert find_soma(end) == 1


def test_the_root_of_a_cell_is_in_its_soma_by_mean_radii_too(cell):
    skeleton = skeletonize(cell, preset="neuron")
    assert skeleton.radius_kind == "mean"
    assert is_in_soma(skeleton, 0)


def test_the_root_is_that_of_the_radii_that_are_asked_for():
    """Half as thick as four times its branches by inscribed radii, which are smaller than the tubes."""
    nodes = [[-9, 0, 0], [-4, 0, 0], [0, 0, 0], [4, 0, 0], [9, 0, 0]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 4]]
    cell = Skeleton(nodes, edges, [1, 0.5, 1.5, 0.5, 0.9], mean_radii=[1, 0.5, 1.5, 0.5, 1.1])
    assert reroot_by_thickness(cell).nodes[0].tolist() == [-9, 0, 0]
    assert reroot_by_thickness(cell, "mean").nodes[0].tolist() == [0, 0, 0]
    assert find_soma(with_mean_radii(cell)) == 2


def test_the_root_is_chosen_before_a_skeleton_is_resampled(ring):
    """A ring that is opened has its root at an end, and no other node is held."""
    opened = skeletonize(ring, min_loop=60.0, n_nodes=5)
    steps = np.linalg.norm(np.diff(opened.nodes[opened.edges], axis=1), axis=2)
    assert (opened.degrees[0], len(opened.nodes)) == (1, 5)
    assert steps.max() < 1.01 * steps.min()


def test_the_root_is_chosen_after_branches_are_pruned():
    """The thick inlet is short."""
    arms = [
        (np.array([[0, 0, 0], end]), radius)
        for end, radius in (((0, 0, -5), 2.0), ((20, 0, 12), 1.6), ((-20, 0, 12), 1.2))
    ]
    vessel = mesh_solid(solid_of(arms), n_vertices=3000)
    whole, pruned = skeletonize(vessel), skeletonize(vessel, min_branch_ratio=4.5)
    assert (whole.nodes[0, 2] < 0, len(whole.tips)) == (True, 3)
    assert (pruned.nodes[0, 0] > 15, pruned.degrees[0], len(pruned.tips)) == (True, 1, 2)


@pytest.mark.parametrize("position", ["inside", "surface"])
def test_a_skeleton_without_a_soma_begins_at_its_thickest_tip(position):
    """The inlet of a vessel at the origin; at the center of its cut, a tip at the surface has a radius of zero."""
    for seed in (5, 6):
        skeleton = skeletonize(vessel_tree(4, seed=seed).mesh, tip_position=position)
        assert find_soma(skeleton) is None
        assert np.linalg.norm(skeleton.nodes[0]) <= 1.1  # radius 1


def test_a_twig_is_no_thicker_than_it_is_outside_of_the_trunk():
    """The trunk along x has radius 1 at a junction; a twig has 0.4 where it leaves the ball there."""
    nodes = [[x, 0, 0] for x in range(7)] + [[3, 0.5, 0], [3, 1.1, 0], [3, 1.5, 0]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [3, 7], [7, 8], [8, 9]]
    radii = [0.6, 0.6, 0.6, 1, 0.5, 0.5, 0.5, 0.7, 0.4, 0.2]
    assert find_roots(Skeleton(nodes, edges, radii)).tolist() == [0]
    assert find_roots(Skeleton(nodes, edges, [0.3, 0.3, 0.3, 1, 0.3, 0.3, 0.3, *radii[7:]])).tolist() == [9]
