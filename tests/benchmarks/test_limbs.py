"""The benchmark of limbs: which rows of refinement it measures, and that it writes them."""

import json

from benchmarks import limbs, refinement


def test_every_part_of_the_growth_of_limbs_is_measured():
    assert limbs.NAMES[0] == "none"
    assert {"grow limbs", "limbs at missed ends", "limbs out of the balls", "centerlines of limbs"} < {*limbs.NAMES}
    assert {"ball share of tubes 0.0", "ball share of tubes 0.9"} < {*limbs.NAMES}
    assert {"growth of rings 0.3", "growth of rings 0.7", "distance of rings 0.25"} < {*limbs.NAMES}
    assert {*limbs.NAMES} < {"none", *refinement.PASSES, *refinement.BOUNDS}


def test_the_rows_are_written(tmp_path, monkeypatch):
    """With one small mesh, and without shapes."""
    monkeypatch.setattr(refinement, "hard_shapes", lambda quick: {})
    monkeypatch.setattr(refinement, "creatures_of", lambda quick: {})
    asked = []

    def replace_each(names, quick, hard, creatures, real):
        asked.append((names, len(real)))
        return "What was measured", [{"replaced": name} for name in names]

    monkeypatch.setattr(refinement, "replace_each", replace_each)
    limbs.run(True, tmp_path)
    assert asked == [(limbs.NAMES[:2], 1)]
    rows = json.loads((tmp_path / "limbs.json").read_text())["ablation"]
    assert [row["replaced"] for row in rows] == [*limbs.NAMES[:2]]
    assert "## What was measured" in (tmp_path / "limbs.md").read_text()
