"""The benchmark of rigs: what is measured of cylinders, characters and constants."""

import numpy as np
import pytest

import lbskel
from benchmarks import rig
from benchmarks.application_constants import swept
from benchmarks.characters import CHARACTERS
from lbskel.applications import bones
from lbskel.geometry.surface_queries import Surface


def test_a_bent_cylinder_keeps_what_the_closed_form_says():
    """Sections of weight w shrink by 1 - 2 w (1 - w), heights grow by (2 w - 1)^2 / 2: a sixth of the width is lost."""
    row = rig._cylinders((3.0,))[0]
    for width in rig.WIDTHS:
        assert row[f"over {width:g} radii"] == pytest.approx(1 - width / 6 / 6, abs=1e-3)


def test_constants_are_moved_one_by_one_and_put_back():
    before = bones.BONE_LENGTH, bones.GROWTH
    rows = swept(("applications/bones.py",), lambda: {"found": (bones.BONE_LENGTH, bones.GROWTH)}, (0.5, 2.0))
    assert before == (bones.BONE_LENGTH, bones.GROWTH)
    found = {(row["constant"], row["factor"]): row["found"] for row in rows}
    assert found["`bones.BONE_LENGTH`", 0.5] == (before[0] / 2, before[1])
    assert found["`bones.GROWTH`", 2.0] == (before[0], 2 * before[1])
    assert len(rows) == 2 * 4


@pytest.mark.parametrize("name", CHARACTERS)
def test_joints_of_characters_are_inside(name):
    character = CHARACTERS[name](600)
    assert len(character.joints) == len(character.radii)
    assert Surface(character.mesh).contains(character.joints).all()
    assert np.isfinite(character.radii).all()


def test_fingers_do_not_count_as_arms_and_legs():
    character = CHARACTERS["hand"](800)
    skeleton = lbskel.skeletonize(character.mesh, preset="character")
    made = lbskel.rig(character.mesh, skeleton)
    lengths = np.linalg.norm(made.tails - made.heads, axis=1)
    kept = rig._kept(made, skeleton)
    assert len(kept) > 1
    assert rig._kept(made, skeleton, 2 * lengths.max() / character.mesh.diagonal) == []
    assert set(rig._kept(made, skeleton, rig.LONG_LIMB)) <= set(kept)
