"""Branches of skeletons made by hand that get bones where there are too many: the root, main limbs, ends of limbs."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.applications.bones import bones_of


def lines(*limbs):
    """A skeleton of straight lines that share ends, of radius 0.2."""
    nodes, edges = [], []
    for ends in limbs:
        line = np.linspace(*ends, round(10 * np.linalg.norm(np.subtract(*ends))) + 1)
        edges += [[len(nodes) + k, len(nodes) + k + 1] for k in range(len(line) - 1)]
        nodes += line.tolist()
    nodes, number = np.unique(np.round(nodes, 9), axis=0, return_inverse=True)
    return Skeleton(nodes, number.ravel()[edges], np.full(len(nodes), 0.2), np.arange(len(nodes)))


def quadruped():
    """A spine from hips to shoulders, four legs of two bones or three, a head shorter than a leg, and an ear on it."""
    legs = [([x, 0, 0], [x, y, -3 - x / 10]) for x in (0, 4) for y in (-2.0, 2.0)]
    head = ([4, 0, 0], [6, 0, 1]), ([6, 0, 1], [6.5, 0.5, 1]), ([6, 0, 1], [8, 0, 1.5])
    return lines(([0, 0, 0], [4, 0, 0]), *legs, *head)


@pytest.mark.parametrize("most", range(1, 31))
def test_the_root_stays_and_every_main_limb_has_a_bone_before_one_has_a_second(most):
    found, full = bones_of(quadruped(), max_bones=most), bones_of(quadruped(), max_bones=40)
    assert found.heads[0].tolist() == full.heads[0].tolist()
    assert len(found.heads) <= most
    counts = np.bincount(found.branches[1:]) if most > 1 else []
    if most >= 7:  # the root, spine, four legs, and the head; the ear is an end of a limb
        assert len(counts) >= 6
    else:
        assert len(found.heads) == most
    assert full.limb_ends.tolist() == found.limb_ends.tolist()
    assert len(full.limb_ends) == 6


def test_legs_have_two_bones_before_an_ear_has_one():
    found = bones_of(quadruped(), max_bones=12)
    assert np.bincount(found.branches[1:]).max() == 2
    assert np.linalg.norm(found.tails - [6.5, 0.5, 1], axis=1).min() > 0.1


def test_a_root_that_has_lost_its_limbs_is_no_limb():
    """The root has two short limbs, which go first, and a trunk with two long limbs at its other end."""
    trunk, short = ([0, 0, 0], [2, 0, 0]), [([0, 0, 0], [0, y, 0]) for y in (-1.0, 1.0)]
    tree = lines(trunk, *short, *(([2, 0, 0], [2, y, 0]) for y in (-3.0, 3.0)))
    tree = replace(tree, radii=np.where(np.linalg.norm(tree.nodes, axis=1) < 0.01, 1.0, 0.2))
    for most in (6, 4, 3, 2):
        assert bones_of(tree, max_bones=most).heads[0].tolist() == [0, 0, 0]


def test_a_limb_that_continues_another_through_the_root_has_a_bone_of_its_own():
    """Two of the four legs and the head are left: none hangs on another but by the root."""
    found = bones_of(quadruped(), max_bones=3)
    assert found.parents.tolist() == [-1, 0, 0]
    assert found.heads[1:].tolist() == [found.heads[0].tolist()] * 2
