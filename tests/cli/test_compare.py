"""``lbskel compare``: the page and its pictures are written whole or not at all."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from lbskel import write_mesh
from lbskel.cli.main import main
from lbskel.pipeline.comparison import CASES
from lbskel.shapes import make

SOME = ("curvature_flow", "clamped cotangents; least squares", "mean value; curvature flow")


@pytest.fixture
def few_cases(monkeypatch):
    chosen = {case: CASES[case] for case in SOME}
    monkeypatch.setattr("lbskel.cli.compare.CASES", chosen)
    return chosen


def test_the_page_and_what_it_shows_are_written(few_cases, rod, tmp_path, capsys):
    path = tmp_path / "<b>x&y.off"
    write_mesh(path, rod)
    assert main(["compare", str(path), "-o", str(tmp_path / "report")]) == 0
    names = {path.name for path in (tmp_path / "report").iterdir()}
    assert names == {"index.html", "comparison.json"}
    page = (tmp_path / "report" / "index.html").read_text()
    assert "&lt;b&gt;x&amp;y.off" in page
    assert "<b>x" not in page
    assert "<p>No skeleton by mean value; curvature flow: the operator &#x27;mean_value&#x27; is not symmetric" in page
    for case in few_cases:
        assert f'<th scope="row">{case}</th>' in page
    pictures = re.findall(r'<img src="data:image/png;base64,([^"]+)" alt="([^"]+)">', page)
    assert [alt.split(",")[0] for _, alt in pictures] == [
        "Area and bounding box by step",
        "Contracted meshes",
        "Skeletons",
    ]
    assert all(base64.b64decode(data)[1:4] == b"PNG" for data, _ in pictures)
    assert "script-src 'none'" in page
    document = json.loads((tmp_path / "report" / "comparison.json").read_text())
    assert list(document["cases"]) == list(few_cases)
    ended = {case: row["ended"] for case, row in document["cases"].items()}
    assert ended["curvature_flow"] == "volume"
    assert ended["mean value; curvature flow"] == "no skeleton"
    out, err = capsys.readouterr()
    assert all(case in out for case in few_cases)
    assert "\nno skeleton by mean value; curvature flow: the operator 'mean_value' is not symmetric" in out
    assert err == ""


def test_what_explodes_is_drawn_and_told_and_replaces_only_what_it_may(tmp_path, monkeypatch, capsys):
    exploding = replace(CASES["mean value, symmetric; least squares"], max_steps=12, volume_ratio=1e-12)
    monkeypatch.setattr("lbskel.cli.compare.CASES", {"curvature_flow": CASES["curvature_flow"], "exploding": exploding})
    write_mesh(tmp_path / "hand.off", make("hand", n_vertices=600).mesh)
    report = tmp_path / "report"
    report.mkdir()
    (report / "index.html").write_text("mine")
    arguments = ["compare", str(tmp_path / "hand.off"), "-o", str(report)]
    assert main(arguments) == 2
    assert "index.html exists already; give --force" in capsys.readouterr().err
    assert [path.name for path in report.iterdir()] == ["index.html"]
    assert (report / "index.html").read_text() == "mine"
    assert main([*arguments, "--force", "--quiet"]) == 0
    assert "hand.off" in (report / "index.html").read_text()
    assert capsys.readouterr().out == ""
    rows = json.loads((report / "comparison.json").read_text())["cases"]
    assert rows["exploding"]["broke at"]
    assert (np.diff(rows["curvature_flow"]["areas"]) < 0).all()
    assert (np.diff(rows["exploding"]["areas"]) > 0).any()


@pytest.mark.parametrize("output", ["rod.off", "rod.off/report", "no/such/place"])
def test_an_output_that_is_no_folder_is_one_line(few_cases, rod, tmp_path, capsys, output):
    write_mesh(tmp_path / "rod.off", rod)
    assert main(["compare", str(tmp_path / "rod.off"), "-o", str(tmp_path / output)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("lbskel: ")
    assert err.count("\n") == 1
