"""The table of constants: which numbers are found, that one is really changed, and what the table says of it."""

import sys

import pytest

import lbskel
from benchmarks import constants
from benchmarks.constants import Constant, changed, difference, find_constants, measure, shifted, tables, text_of
from lbskel.shapes import torus
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO

FORMULAS = '''"""Areas."""
SIDES, SEED = 4, 0
WIDTH: float = 2.0
HALF = WIDTH / 2
NAME = "square"
IS_CLOSED = True
lower = 3.0


def area(width=WIDTH):
    SCALE = 1.0
    return SCALE * width * HALF
'''


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of two modules, one of which takes a constant and a function from the other."""
    folder = tmp_path / "shapes_of_constants"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "formulas.py").write_text(FORMULAS)
    (folder / "table.py").write_text("from shapes_of_constants.formulas import WIDTH, area\n\nROW = (WIDTH, area())\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for name in [name for name in sys.modules if name.startswith(folder.name)]:
        del sys.modules[name]


def test_constants_are_the_numbers_with_upper_case_names(package):
    found = find_constants(package, ["formulas.py", "table.py"])
    assert [(constant.name, constant.value) for constant in found] == [("SIDES", 4), ("WIDTH", 2.0), ("HALF", 1.0)]


def test_integers_move_by_one_at_least():
    assert shifted(2.0, 0.7) == 1.4
    assert shifted(10, 1.4) == 14
    assert (shifted(1, 0.7), shifted(1, 1.4)) == (0, 2)
    assert isinstance(shifted(12, 0.7), int)


def test_a_changed_constant_changes_defaults_other_constants_and_importers(package):
    from shapes_of_constants import table

    constant = Constant("shapes_of_constants.formulas", "WIDTH", 2.0)
    with changed(constant, 6.0):
        from shapes_of_constants import table as changed_table

        assert changed_table.ROW == (6.0, 18.0)
        assert changed_table is not table
    from shapes_of_constants import table as restored

    assert restored is table
    assert restored.ROW == (2.0, 2.0)


def test_lbskel_is_as_before_after_a_change():
    before = {name: module for name, module in sys.modules.items() if name.split(".")[0] == "lbskel"}
    constant = Constant("lbskel.skeleton.pruning", "MIN_BRANCH_RATIO", MIN_BRANCH_RATIO)
    with changed(constant, 3.0):
        import lbskel as changed_lbskel

        assert changed_lbskel.prune.__kwdefaults__["min_branch_ratio"] == 3.0
    assert {name: module for name, module in sys.modules.items() if name.split(".")[0] == "lbskel"} == before
    assert lbskel.prune.__kwdefaults__["min_branch_ratio"] == MIN_BRANCH_RATIO


def test_only_changes_are_reported():
    mesh = torus(1.0, 0.25, 16, 8)
    inputs = {"ring": constants.Input((mesh.vertices, mesh.faces), None)}
    before = measure(inputs)
    assert before["ring"]["cycles"] == 1
    same = difference(before, measure(inputs))
    assert text_of(same) == "no effect"
    with changed(Constant("lbskel.evaluation.scoring", "MAX_COVERED_DISTANCE", 2.0), 0.01):
        scored = difference(before, measure(inputs))
    assert text_of(scored).startswith("scores of 1, verdicts: ring: pass -> fail")
    with changed(Constant("lbskel.pipeline.passes", "SPACING", 0.5), 0.7):
        moved = difference(before, measure(inputs))
    assert text_of(moved).startswith("skeletons of 1")
    rows = [
        {
            "module": "lbskel.evaluation.scoring",
            "constant": "MAX_COVERED_DISTANCE",
            "value": 2.0,
            "-30 %": scored,
            "+40 %": same,
        },
        {"module": "lbskel.pipeline.passes", "constant": "IDLE", "value": 0.5, "-30 %": same, "+40 %": same},
    ]
    found = tables({"ring": {**before["ring"], "accuracy": 0.1}}, rows)
    assert list(found) == ["2 constants", "1 without effect on these meshes"]
    assert "| pipeline.passes | IDLE | 0.5 | no effect | no effect |" in found["2 constants"]
    assert "MAX_COVERED_DISTANCE" not in found["1 without effect on these meshes"]


def test_an_error_is_an_effect():
    before = {"ring": {"digest": "a"}}
    change = difference(before, {"ring": {"error": "MeshError: nothing is left"}})
    assert text_of(change) == "errors on 1"
