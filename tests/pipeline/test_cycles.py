"""Cycles of a finished skeleton: kept where the format holds them; cut and noted else, or where a tree is asked for."""

import pytest

from lbskel import skeletonize
from lbskel.io import FORMATS
from lbskel.pipeline.cycles import cut_cycles


@pytest.fixture(scope="module")
def skeletons(two_rings, rod):
    return {2: skeletonize(two_rings), 0: skeletonize(rod)}


@pytest.mark.parametrize("name", FORMATS)
def test_a_note_tells_each_cycle_that_is_cut(skeletons, name):
    kept, note = cut_cycles(skeletons[2], tree=False, extension=name)
    assert kept.cycle_rank == 2
    assert bool(note) == FORMATS[name].only_trees
    assert kept.report["notes"] == [*skeletons[2].report["notes"], *([note] if note else [])]
    tree, note = cut_cycles(skeletons[2], tree=True, extension=name)
    assert tree.cycle_rank == 0
    assert tree.report["notes"][-1] == note
    assert note.startswith("2 cycles cut where the skeleton is thinnest (radius ")


@pytest.mark.parametrize("tree", [True, False])
def test_without_cycles_there_is_nothing_to_note(skeletons, tree):
    assert cut_cycles(skeletons[0], tree=tree, extension="swc") == (skeletons[0], "")
