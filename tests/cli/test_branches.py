"""``lbskel branches``: a table as csv and json."""

import json

import pytest


def test_branches(here, folder):
    code, out, err = here("branches", "ring.obj", "-o", "ring.csv")
    assert (code, out, err) == (0, ["ring.csv: 1 branch"], [])
    assert (folder / "ring.csv").read_text().splitlines() == here("branches", "ring.obj")[1]
    assert pytest.importorskip("pandas").read_csv(folder / "ring.csv")["tortuosity"].isna().tolist() == [True]
    assert here("branches", "ring.obj", "-o", "ring.json")[0] == 0
    assert json.loads((folder / "ring.json").read_text())["branches"][0]["tortuosity"] is None


def test_names_and_existing_files_are_checked_before_work(here):
    assert here("branches", "none.off", "-o", "a.txt")[2] == ["lbskel: a.txt: the name must end in one of: .csv, .json"]
    here("branches", "rod.off", "-o", "rod.csv")
    assert "exists already; give --force" in here("branches", "none.off", "-o", "rod.csv")[2][0]
    assert here("branches", "rod.off", "-o", "rod.csv", "--force")[0] == 0


def test_a_scale_and_units_are_those_of_the_table(here, folder):
    options = ("--scale", "1000", "--units", "um")
    assert here("branches", "rod.off", "-o", "a.json", *options)[:2] == (0, ["a.json: 1 branch, lengths in um"])
    assert here("branches", "rod.off", "-o", "b.json")[0] == 0
    a, b = (json.loads((folder / name).read_text()) for name in ("a.json", "b.json"))
    assert (a["units"], b["units"]) == ("um", None)
    for name, power in (("length", 1), ("max_radius", 1), ("section_area", 2), ("volume", 3)):
        assert a["branches"][0][name] == pytest.approx(1000**power * b["branches"][0][name], rel=1e-12)
    code, out, err = here("branches", "none.off", "--scale", "0")  # before the mesh is read
    assert (code, out) == (2, [])
    assert "scale must be a positive number" in err[0]


def test_the_branches_of_a_tree_do_not_close(here):
    ring, tree = (json.loads("".join(here("branches", "ring.obj", "--json", *more)[1])) for more in ((), ("--tree",)))
    ring, tree = ring["branches"][0], tree["branches"][0]
    assert ring["start_point"] == ring["end_point"]
    assert tree["start_point"] != tree["end_point"]
    assert tree["length"] == pytest.approx(ring["length"], rel=0.1)  # without one edge
