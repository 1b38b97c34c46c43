"""The benchmark of bounds: its meshes, and a quick run."""

import lbskel
from benchmarks import bounds


def test_cropped_trees_and_tubes_with_gaps_are_in_pieces():
    assert lbskel.prepare(bounds._cropped(0)).mesh.n_components > 0
    gaps = bounds._with_gaps()
    assert len(gaps) == len(bounds.GAPS) * len(bounds.BENDS)
    assert {gap.n_components for gap in gaps} == {2}


def test_a_quick_run_has_all_tables(tmp_path):
    bounds.run(True, tmp_path)
    text = (tmp_path / "bounds.md").read_text()
    assert "MIN_OUTWARDS" in text
    assert "MAX_AROUND" in text
