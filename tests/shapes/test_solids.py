"""The solids of the catalog against closed forms: topology and total length of their axes, extreme radii."""

import numpy as np
import pytest

from lbskel.shapes import solids

# name: genus, tips, total length of the axes
EXPECTED = {
    "tripod": (0, 3, np.sqrt(1.25) * (0.8 + 1.0 + 1.2)),
    "dumbbell": (0, 2, 2.0),
    "ladder": (4, 4, 2 * 3.0 + 5 * 0.9),
    "cube_frame": (5, 0, 12 * 1.6),
    "tree": (0, 13, 0.85 * sum(n * 0.72**level for level, n in enumerate((1, 3, 6, 12)))),
    "limbs": (
        0,
        6,
        0.9
        + sum(
            np.linalg.norm(end)
            for end in (
                [0.65, 0.75, 0.35],
                [0.65, 0.75, 0.35],
                [0.85, 0, 0.75],
                [0.75, 0.7, 0.3],
                [0.65, 0.8, 0.2],
                [0.9, 0.05, 0.7],
            )
        ),
    ),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_polygonal_solids_have_the_length_and_topology_of_their_description(name):
    truth = getattr(solids, name)().truth
    assert (truth.genus, truth.n_tips, truth.n_components) == (*EXPECTED[name][:2], 1)
    assert truth.length == pytest.approx(EXPECTED[name][2], rel=1e-12)


def test_the_helix_has_the_arc_length_of_its_formula():
    truth = solids.helix().truth
    step = 5 * np.pi / 180
    assert (truth.genus, truth.n_tips) == (0, 2)
    # a polyline inscribed in a circle of 72 points per turn is shorter by step^2 / 24
    assert truth.length == pytest.approx(5 * np.pi * np.hypot(0.6, 0.09), rel=step**2 / 24)
    assert np.ptp(truth.nodes[:, 2]) == pytest.approx(0.09 * 5 * np.pi)


def test_the_knot_is_one_loop_with_the_symmetry_of_the_trefoil():
    nodes = solids.knot().truth.nodes
    angle = 2 * np.pi / 3
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    distances = np.linalg.norm((nodes @ turn.T)[:, None] - nodes, axis=2).min(axis=1)
    assert distances.max() < 1e-9
    assert (solids.knot().truth.genus, solids.knot().truth.n_tips) == (1, 0)


@pytest.mark.parametrize("genus", [1, 2, 4])
def test_rings_touch_their_neighbors_in_one_point(genus):
    truth = solids.rings(genus).truth
    assert (truth.genus, truth.n_tips, truth.n_components) == (genus, 0, 1)
    assert truth.length == pytest.approx(genus * 96 * 2 * np.sin(np.pi / 96))
    assert len(truth.junctions) == genus - 1


def test_no_ring_is_a_rod():
    truth = solids.rings(0).truth
    assert (truth.genus, truth.n_tips) == (0, 2)
    assert truth.length == pytest.approx(1.6)


def test_the_spiked_ring_has_its_spikes_outside_the_ring():
    truth = solids.spiked_ring().truth
    assert (truth.genus, truth.n_tips, len(truth.junctions)) == (1, 5, 5)
    assert sorted(np.hypot(*truth.nodes[truth.tips].T[:2]).round(9)) == [1.5, 1.6, 1.75, 1.9, 2.05]


def test_the_octopus_has_eight_equal_arms_and_a_head():
    truth = solids.octopus().truth
    assert (truth.genus, truth.n_tips, len(truth.junctions)) == (0, 9, 1)
    tips = truth.nodes[truth.tips]
    arms = tips[tips[:, 2] < 0.5]
    assert len(arms) == 8
    assert np.hypot(*arms.T[:2]) == pytest.approx([1.5] * 8)
    assert arms[:, 2] == pytest.approx([-0.3] * 8)  # 0.25 - 0.55, the sine ends at 0
    assert truth.radii[truth.tips][tips[:, 2] < 0.5] == pytest.approx([0.09] * 8)


def test_the_hand_has_five_fingers_of_the_given_lengths():
    truth = solids.hand().truth
    assert (truth.genus, truth.n_tips, len(truth.junctions)) == (0, 6, 1)
    tips = truth.nodes[truth.tips]
    lengths = np.linalg.norm(tips[tips[:, 2] > 0] + [0, 0.12, 0], axis=1)  # the bend forwards taken back
    assert sorted(lengths.round(9)) == [
        0.95,
        1.05,
        1.25,
        1.28,
        1.38,
    ]


def test_the_tree_becomes_thinner_by_a_fifth_at_each_fork():
    radii = solids.tree().radii
    assert radii.max() == pytest.approx(0.14)
    assert radii.min() == pytest.approx(0.12 * 0.8**3)
