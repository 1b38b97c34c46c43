"""The benchmark of the verdict: true errors in their classes, and limbs that are cut off true axes."""

import json

import numpy as np
import pytest

from benchmarks import judge
from benchmarks.thin_tools import Answer
from lbskel import Skeleton
from lbskel.evaluation.skeleton_shape import MIN_KNOWN, MIN_KNOWN_SHARE
from lbskel.shapes import make


@pytest.fixture(scope="module")
def tripod():
    return make("tripod", n_vertices=800)


def axis(shape, aside=0.0):
    """The true axis, moved by a share of its radii."""
    truth = shape.truth
    return Skeleton(truth.nodes + aside * truth.radii[:, None] * np.array([0, 0, 1.0]), truth.edges, truth.radii)


def test_errors_and_verdicts_are_told_by_class(tmp_path, monkeypatch, tripod):
    answers = {"true": Answer(axis(tripod), 0.0), "aside": Answer(axis(tripod, 0.6), 0.0), "late": "over 200 s"}
    monkeypatch.setattr(judge, "TOOLS", dict.fromkeys(answers))
    monkeypatch.setattr(judge, "OURS", ("true",))
    monkeypatch.setattr(judge, "ask", lambda tool, mesh: answers[tool])
    monkeypatch.setattr(judge, "_shapes", lambda quick: [(("set", "tripod"), tripod)])
    monkeypatch.setattr(judge, "hemibrain_neurons", lambda n: [("tripod", tripod.mesh, tripod.truth)])
    judge.run(True, tmp_path, peers=True)
    found = json.loads((tmp_path / "judge.json").read_text())
    true, aside, late = found["rows"]
    assert true["true error"] < 1e-6
    assert true["verdict"] == "pass"
    assert 0.5 < aside["true error"] < 0.6  # from the points of two limbs, which lean, the axis is nearer
    assert aside["verdict"] != "pass"
    assert late["error"] == "over 200 s"
    every = found["verdicts"][-1]
    assert (every["tool"], every["below 0.15"], every["over 0.3"]) == ("all", 1, 1)
    assert (every["below 0.15, pass"], every["over 0.3, pass"]) == (1, 0)
    assert every["over 0.3, pass without extrema"] == 0
    loosest = found["thresholds"][-1]
    assert loosest["below 0.15, pass"] == 1
    assert loosest["over 0.3, pass"] == 0
    told = next(each for each in found["ends"] if (each["farther than"], each["flux"]) == (1.0, 0.5))
    assert (told["recall"], told["precision"], told["told of whole axes"]) == (1, 1, 0)
    used = (MIN_KNOWN, MIN_KNOWN_SHARE)
    told = next(each for each in found["aside"] if (each["known at least"], each["share at least"]) == used)
    assert told["by 0 radii, warn"] == told["by 0 radii, fail"] == told["by 0.3 radii, fail"] == 0
    assert told["by 0.3 radii, warn"] == told["by 0.6 radii, fail"] == 1
    assert told["neurons that fail"] == "0/1"
