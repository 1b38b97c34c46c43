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
