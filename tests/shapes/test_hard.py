"""Hard shapes: the topology that their descriptions say, and the angle or gap that makes them hard."""

import numpy as np
import pytest

from lbskel.shapes.hard import HARD_SHAPES, acute_fork, lattice, prongs, zigzag

# tips and genus
EXPECTED = {
    "zigzag": (2, 0),
    "acute fork": (3, 0),
    "oblique cross": (4, 0),
    "prongs": (6, 0),
    "torso": (5, 0),
    "tee": (3, 0),
    "spring": (2, 0),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_the_mesh_has_the_topology_of_its_axis(name):
    shape = HARD_SHAPES[name](n_vertices=1500)
    assert shape.mesh.is_closed_manifold
    assert (shape.truth.n_tips, shape.truth.genus, shape.truth.n_components) == (*EXPECTED[name], 1)
    assert (shape.mesh.genus, shape.mesh.n_components) == (EXPECTED[name][1], 1)


def test_every_hard_shape_is_named_once():
    assert len({make.__name__ for make in HARD_SHAPES.values()}) == len(HARD_SHAPES) == 14


@pytest.mark.parametrize("degrees", [35.0, 60.0])
def test_a_zigzag_has_bends_of_that_angle(degrees):
    truth = zigzag(degrees=degrees, n_vertices=500).truth
    (path,) = truth.branches
    steps = np.diff(truth.nodes[path], axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = np.degrees(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1, 1)))
    assert turns[turns > 1] == pytest.approx(180 - degrees)
    assert np.count_nonzero(turns > 1) == 4


def test_limbs_leave_a_fork_at_that_angle():
    truth = acute_fork(degrees=20.0, n_vertices=500).truth
    ends = [end / np.linalg.norm(end) for end in truth.nodes[truth.tips] if end[2] > 0]
    assert np.degrees(np.arccos(ends[0] @ ends[1])) == pytest.approx(20)


def test_prongs_are_that_far_apart():
    x = np.unique(np.round(prongs(gap=0.25, n_vertices=500).truth.nodes[:, 0], 9))
    prong = x[np.isclose(x / 0.27, np.rint(x / 0.27))]  # 2.25 radii of 0.12
    assert len(prong) == 5


def test_a_lattice_has_an_edge_for_each_pair_of_neighbors():
    truth = lattice(n=2, n_vertices=500).truth
    assert len(truth.branches) == 12
    assert truth.genus == 12 - 8 + 1
