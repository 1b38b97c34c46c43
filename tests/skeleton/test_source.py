"""Whether a skeleton was made from a mesh: counts, places, other units."""

import numpy as np
import pytest
from helpers import path_in

from lbskel import MeshError, Skeleton, branch_table, rig, segment
from lbskel.shapes import capsule
from lbskel.skeleton.source import require_map, require_near

ROD = capsule(4.0, 0.5, 16)
OWN = path_in(ROD, [[0, 0, z] for z in np.linspace(-2, 2, 9)])


@pytest.mark.parametrize("measure", [lambda m: branch_table(OWN, m), lambda m: segment(m, OWN), lambda m: rig(m, OWN)])
def test_a_mesh_in_other_units_is_an_error(measure):
    measure(ROD)
    far = ROD.with_vertices(ROD.vertices + [9.0, 0, 0])
    for other in (far, ROD.with_vertices(0.001 * ROD.vertices)):
        with pytest.raises(MeshError, match=r"not in the shape: .* in the same units"):
            measure(other)


def test_a_node_in_the_middle_of_a_box_is_in_it():
    """All eight vertices are half a diagonal away, up to rounding: as after a time limit."""
    for seed in range(30):
        size, place = np.random.default_rng(seed).uniform(1, 2, (2, 3))
        corners = np.indices((2, 2, 2)).reshape(3, -1).T * size + place
        require_map(Skeleton([corners.mean(axis=0)], [], [0.5], np.zeros(8, dtype=np.int64)), corners)


def test_larger_units_around_the_same_origin_are_an_error():
    with pytest.raises(MeshError, match="not in the shape"):
        require_map(OWN, 0.1 * ROD.vertices)


def test_a_map_of_another_mesh_is_an_error():
    with pytest.raises(MeshError, match="maps 0 vertices to its nodes, and the mesh has"):
        require_map(Skeleton([[0, 0, 0]], [], [1.0]), ROD.vertices)


def test_nodes_half_a_diagonal_from_the_box_are_near_and_no_nodes_are_anywhere():
    points = np.array([[0.0, 0, 0], [3, 4, 0]])
    require_near(Skeleton([[5.4, 4, 0]], [], [1.0]), points)
    with pytest.raises(MeshError):
        require_near(Skeleton([[5.6, 4, 0]], [], [1.0]), points)
    require_near(Skeleton([], [], []), points)
