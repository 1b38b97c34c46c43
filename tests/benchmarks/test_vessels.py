"""The benchmark of vessels: rows of coils and trees, tips found, and tools that run out of time."""

import json

import numpy as np
import pytest

from benchmarks import thin_tools, vessels
from benchmarks.thin_tools import Answer, ask
from benchmarks.vessels import tips_found
from lbskel import Skeleton
from lbskel.shapes import coil


def perfect(tool, mesh):
    """The axis of the coil of two turns, without radii; another tool is late."""
    truth = coil(2).truth
    return (
        "over 200 s"
        if tool == "late"
        else Answer(Skeleton(truth.nodes, truth.edges, np.full(len(truth.nodes), np.nan)), 3)
    )


def test_rows_compare_with_the_truth_and_late_tools_are_not_asked_again(tmp_path, monkeypatch):
    asked = []

    def answer(tool, mesh):
        asked.append(tool)
        return perfect(tool, mesh)

    monkeypatch.setattr(vessels, "ask", answer)
    monkeypatch.setattr(vessels, "TOOLS", {"lbskel": None, "late": None})
    monkeypatch.setattr(vessels, "QUICK", ((2, 3), ()))
    vessels.run(True, tmp_path, peers=True)
    rows = json.loads((tmp_path / "vessels.json").read_text())["rows"]
    assert asked == ["lbskel", "late", "lbskel"]
    assert [row.get("error") for row in rows] == [None, "over 200 s", None, "out of time on a smaller shape"]
    assert rows[0]["accuracy"] < 1e-12
    assert (rows[0]["tips"], rows[0]["tips found"], rows[0]["topology right"]) == ("2/2", 1, True)
    assert (rows[0]["radius_error"], rows[0]["cpu seconds"]) == (None, 3)
    assert rows[0]["thinnest / diagonal"] == pytest.approx(0.0344, rel=0.01)
    assert "coil of 2 turns" in (tmp_path / "vessels.md").read_text()


def test_a_tip_is_found_within_two_of_its_radii():
    truth = Skeleton([[0, 0, 0], [9, 0, 0]], [[0, 1]], [1.0, 0.5])
    near, far = (Skeleton([[x, 0, 0], [9 - x, 0, 0]], [[0, 1]], [1.0, 1.0]) for x in (0.9, 1.1))
    assert (tips_found(near, truth), tips_found(far, truth)) == (1, 0.5)
    assert tips_found(far, truth, 1.2) == 1
    loop = Skeleton([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1], [1, 2], [0, 2]], np.ones(3))
    assert tips_found(loop, truth) == 0


def test_our_tool_answers_with_radii_and_a_verdict():
    answer = ask("lbskel", coil(1, sides=6).mesh)
    assert isinstance(answer, Answer)
    assert answer.verdict in ("pass", "warn", "fail")
    assert np.isfinite(answer.skeleton.radii).all()
    assert answer.seconds > 0


def test_the_fastest_call_is_timed_after_one_on_a_small_mesh(monkeypatch):
    seconds = iter([9.0, 3.0, 1.0, 2.0])
    skeleton = Skeleton([[0, 0, 0], [9, 0, 0]], [[0, 1]], [1.0, 0.5])
    monkeypatch.setitem(thin_tools.TOOLS, "timed", lambda *mesh: Answer(skeleton, next(seconds)))
    assert thin_tools._call("timed", np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), 3).seconds == 1


def test_nodes_at_no_place_are_dropped():
    nodes = [[0, 0, 0], [np.nan] * 3, [1, 0, 0], [2, 0, 0]]
    skeleton = thin_tools._bare((np.array(nodes), np.array([[0, 1], [0, 2], [2, 3]])))
    assert (len(skeleton.nodes), skeleton.edges.tolist()) == (3, [[0, 1], [1, 2]])
    assert np.isnan(skeleton.radii).all()
