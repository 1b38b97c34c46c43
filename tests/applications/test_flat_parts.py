"""Patches of a capsule are merged into the part beside them; its ends, a ring around it, and parts with an end stay."""

import numpy as np
import pytest
from helpers import without_faces

from lbskel.applications.face_graph import face_graph
from lbskel.applications.flat_parts import merge_flat_parts
from lbskel.shapes import capsule


@pytest.fixture(scope="module")
def rod():
    return capsule(6.0, 1.0, 24)


def merged(mesh, labels, has_end):
    return merge_flat_parts(labels, np.array(has_end), face_graph(mesh), mesh)


def along(mesh):
    """(m,) z of the centers of the faces, from the middle of the rod."""
    z = mesh.vertices[mesh.faces].mean(axis=1)[:, 2]
    return z - (z.max() + z.min()) / 2


def test_a_patch_without_an_end_goes_to_the_part_beside_it(rod):
    lower, is_side = along(rod) < 0, rod.face_normals[:, 0] > 0.5
    labels = np.where(is_side & (np.abs(along(rod) - 0.5) < 0.7), 2, np.where(lower, 0, 1))
    found = merged(rod, labels, [True, True, False])
    assert found.tolist() == np.where(labels == 2, 1, labels).tolist()  # the longer boundary
    assert merged(rod, labels, [True, True, True]) is labels


def test_two_patches_beside_each_other_both_go_to_the_rest(rod):
    labels = np.where(rod.face_normals[:, 0] > 0.9, np.where(np.abs(along(rod)) < 0.4, 1, 2), 0)
    assert merged(rod, labels, [True, False, False]).tolist() == [0] * len(labels)


def test_a_ring_and_ends_longer_than_wide_stay_and_a_flat_end_does_not(rod):
    z = along(rod)
    ring = np.where(np.abs(z) < 0.3, 1, np.where(z > 0, 2, 0))
    assert merged(rod, ring, [False, False, False]) is ring
    cap = np.where(z > z.max() - 0.5, 1, 0)
    assert not merged(rod, cap, [False, False]).any()


def test_a_surface_of_one_patch_has_no_part_to_go_to(rod):
    half = without_faces(rod, np.flatnonzero(rod.face_normals[:, 0] <= 0))
    labels = np.zeros(len(half.faces), dtype=np.int64)
    assert merged(half, labels, [False]) is labels
