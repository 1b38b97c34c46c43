"""Rigs in other programs, where they are installed: bones and vertices by three.js and Blender, and weights."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lbskel
from benchmarks.rig_peers import (
    biharmonic_weights,
    blender_weights,
    issues_of_validator,
    posed_by_blender,
    posed_by_three,
)
from lbskel.shapes import capsule

TURN = Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix()


@pytest.fixture(scope="module")
def rod():
    mesh = capsule(6.0, 0.5, 16)
    return lbskel.rig(mesh, lbskel.skeletonize(mesh))


@pytest.fixture(scope="module")
def path(rod, tmp_path_factory):
    path = tmp_path_factory.mktemp("rig") / "rod.glb"
    lbskel.write_rig(path, rod)
    return path


@pytest.mark.parametrize("program", [posed_by_three, posed_by_blender], ids=["three.js", "Blender"])
def test_a_turned_bone_moves_the_vertices_as_linear_blend_skinning_says(program, rod, path):
    found = program(path, rod.names[-1], TURN)
    if found is None:
        pytest.skip("not installed")
    assert set(found.bones) == set(rod.names)
    expected = rod.posed({rod.names[-1]: TURN}).vertices
    assert np.abs(expected - rod.mesh.vertices).max() > 1
    assert found.vertices == pytest.approx(expected, abs=1e-5)  # the file has single precision


def test_the_khronos_validator_finds_no_fault(path):
    issues = issues_of_validator(path)
    if issues is None:
        pytest.skip("not installed")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0)


def test_automatic_weights_of_blender_are_shares_and_close_to_ours(rod):
    weights = blender_weights(rod)
    if weights is None:
        pytest.skip("not installed")
    assert weights.sum(axis=1) == pytest.approx(1, abs=1e-5)
    assert np.abs(weights[:, 1:] - rod.weights[:, 1:]).mean() < 0.15


def test_bounded_biharmonic_weights_are_shares_and_one_at_the_ends(rod):
    weights = biharmonic_weights(rod)
    assert weights.sum(axis=1) == pytest.approx(1)
    assert (weights >= 0).all()
    ends = rod.mesh.vertices[:, 2].argmin(), rod.mesh.vertices[:, 2].argmax()
    assert sorted(weights[list(ends)].argmax(axis=1)) == [1, 2]
    assert weights[list(ends)].max(axis=1).min() > 0.95
