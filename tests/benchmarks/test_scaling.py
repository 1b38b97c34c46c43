"""The benchmark of scaling: its inputs have the counts that it says, and its tables have exponents."""

import json

import pytest

from benchmarks import scaling


@pytest.mark.parametrize("kind", ["handles of a lattice", "holes of a plate"])
def test_the_count_is_the_genus(kind):
    make, sizes, count = scaling.KINDS[kind]
    assert make(sizes[1]).genus == count(sizes[1])


def test_shells_are_separate_and_a_double_cone_has_its_valence():
    assert scaling.shells(10).n_components == 10
    cone = scaling.double_cone(50)
    assert cone.is_closed_manifold
    assert (cone.edges == 51).sum() == 50


def test_exponents_are_slopes_over_the_largest_inputs():
    rows = [{"count": 10, "a": 1.0}, {"count": 100, "a": 2.0}, {"count": 1000, "a": 200.0}, {"count": 10_000}]
    assert scaling._exponent(rows, "count", "a", 2) == pytest.approx(2)
    assert scaling._exponent(rows, "count", "a", 4) == pytest.approx(1.1505, abs=1e-4)
    assert scaling._exponent(rows[:1], "count", "a", 2) is None


def test_the_command_writes_tables_and_a_plot(tmp_path, monkeypatch):
    monkeypatch.setattr(scaling, "run_in_subprocess", lambda function, *a, timeout: {"value": function(*a)})
    monkeypatch.setattr(scaling, "KINDS", {"handles of a lattice": scaling.KINDS["handles of a lattice"]})
    monkeypatch.setattr(scaling, "HARD", {"small": lambda: scaling.shells(1)})
    scaling.run(True, tmp_path)
    rows = json.loads((tmp_path / "scaling.json").read_text())["runs"]["handles of a lattice"]
    assert [row["cycle rank"] for row in rows] == [5, 28]
    [limited] = json.loads((tmp_path / "scaling.json").read_text())["limited"]
    assert (limited["input"], limited["time limit"]) == ("small", 1.0)
    assert limited["left out"] == "nothing"
    assert "| exponent of the last two |" in (tmp_path / "scaling.md").read_text()
    assert (tmp_path / "scaling.png").stat().st_size > 0
