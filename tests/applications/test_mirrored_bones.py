"""Twins of bones: found, made where a side has fewer, and left out where the plane hangs on a side."""

import numpy as np
import pytest

from lbskel.applications.bones import Bones
from lbskel.applications.mirror import MirrorPlane
from lbskel.applications.mirrored_bones import paired_bones, twin_bones

PLANE = MirrorPlane(np.zeros(3), np.array([1.0, 0, 0]), np.array([1, 0, 3, 2, -1]))
VERTICES = np.array([[2.0, 0, 0], [-2, 0, 0], [4, 0, 0], [-4, 0, 0], [0, 5, 0]])


def bones(*rows, of_vertex=(0, 0, 0, 0, 0)):
    """Bones of rows (head, tail, parent, branch)."""
    heads, tails, parents, branches = zip(*rows, strict=True)
    arrays = (np.array(each, dtype=float) for each in (heads, tails))
    return Bones(*arrays, np.array(parents), np.array(branches), np.array(of_vertex))


ROOT = ([0, 0, 0], [0, 1, 0], -1, -1)
LEFT = ([1, 0, 0], [3, 0, 0], 0, 0)
RIGHT = ([-1, 0, 0], [-3, 0.1, 0], 0, 1)


def test_bones_find_their_twins_within_the_limit():
    both = bones(ROOT, LEFT, RIGHT)
    assert twin_bones(both, PLANE, VERTICES, 0.2).tolist() == [0, 2, 1]
    assert twin_bones(both, PLANE, VERTICES, 0.01).tolist() == [0, -1, -1]
    found, twins = paired_bones(both, PLANE, VERTICES, 0.2, 30)
    assert found is both
    assert twins.tolist() == [0, 2, 1]


def test_the_side_with_more_bones_is_mirrored():
    longer = ([3, 0, 0], [5, 0, 0], 1, 0)
    given = bones(ROOT, LEFT, longer, RIGHT, of_vertex=(1, 3, 2, 3, 0))
    found, twins = paired_bones(given, PLANE, VERTICES, 0.2, 30)
    assert twins.tolist() == [0, 3, 4, 1, 2]
    assert found.parents.tolist() == [-1, 0, 1, 0, 3]
    assert found.heads[3:].tolist() == [[-1, 0, 0], [-3, 0, 0]]
    assert found.tails[3:].tolist() == [[-3, 0, 0], [-5, 0, 0]]
    assert found.bone_of_vertex.tolist() == [1, 3, 2, 4, 0]
    assert len(set(found.branches[found.branches >= 0].tolist())) == 2
    fewer, twins = paired_bones(given, PLANE, VERTICES, 0.2, 4)  # too many bones: the other side
    assert twins.tolist() == [0, 2, 1]
    assert fewer.bone_of_vertex.tolist() == [2, 1, 2, 1, 0]


def test_bones_in_the_plane_that_hang_on_others_are_left_as_they_are():
    given = bones(ROOT, ([1, 0, 0], [0.1, 2, 0], 0, 0), ([0.1, 2, 0], [0, 4, 0], 1, 0))
    found, twins = paired_bones(given, PLANE, VERTICES, 0.2, 30)
    assert found is given
    assert twins[1] == -1


def test_bones_whose_root_is_beside_the_plane_stay():
    """Mirrored, there would be two roots."""
    given = bones(([2, 0, 0], [2, 1, 0], -1, -1), ([2, 0, 0], [0, 0, 0], 0, 0), ([0, 0, 0], [-2, 0, 0], 1, 0))
    found, twins = paired_bones(given, PLANE, VERTICES, 0.2, 30)
    assert found is given
    assert (twins < 0).any()


def test_the_bones_of_a_body_beside_the_plane_are_mirrored_with_their_root():
    """The body on the other side has its root at another place."""
    here = ([2, 0, 0], [2, 1, 0], -1, -1), ([2, 0, 0], [3, 2, 0], 0, 0), ([2, 0, 0], [3, -2, 0], 0, 1)
    there = ([-3, 2, 0], [-3, 3, 0], -1, -1), ([-3, 2, 0], [-3, -2, 0], 3, 2)
    found, twins = paired_bones(bones(*here, *there), PLANE, VERTICES, 0.2, 30)
    assert twins.tolist() == [3, 4, 5, 0, 1, 2]
    assert found.heads[3:] == pytest.approx(found.heads[:3] * [-1, 1, 1])
    assert found.parents.tolist() == [-1, 0, 0, -1, 3, 3]
    assert ((found.branches < 0) == (found.parents < 0)).all()
    assert found.branches[1] != found.branches[4]


def test_a_branch_whose_surface_is_mirrored_onto_itself_is_not_made_two():
    """The head's bone ends in an ear on the left; an eyebrow on it, on the right alone, is mirrored."""
    head, brow = ([0, 0, 0], [1.5, 2, 0], 0, 0), ([1.5, 2, 0], [-3, 3, 0], 1, 1)
    found, twins = paired_bones(bones(ROOT, head, of_vertex=(1, 1, 1, 1, 1)), PLANE, VERTICES, 0.2, 30)
    assert (len(found.heads), twins.tolist()) == (2, [0, 1])
    found, twins = paired_bones(bones(ROOT, head, brow, of_vertex=(1, 1, 1, 2, 1)), PLANE, VERTICES, 0.2, 30)
    assert twins.tolist() == [0, 1, 3, 2]
    found, twins = paired_bones(bones(ROOT, head, of_vertex=(1, 0, 1, 0, 0)), PLANE, VERTICES, 0.2, 30)
    assert twins.tolist() == [0, 2, 1]  # a limb that has its surface on one side
