"""The benchmarks of influence and solvers: how cases are ranked, shapes bent, systems made."""

import numpy as np
import pytest

from benchmarks.__main__ import main, names
from benchmarks.influence_cases import OTHERS, WEIGHT_CASES, ranking
from benchmarks.influence_claims import BEND, bent
from benchmarks.solvers import _system, trial
from lbskel.operators import OPERATORS
from lbskel.shapes import capsule, torus
from lbskel.solvers.least_squares import lstsq


def rows_of(case, **changes):
    row = {"case": case, "broke at": None, "contracted": True, "coverage": 0.1, "accuracy": 0.1, "steps": 8}
    return [{"mesh": mesh, **row, **changes} for mesh in ("one", "two", "three")]


def test_cases_are_ranked_by_where_they_are_sound():
    once = rows_of("once")
    once[1]["broke at"] = 7
    rows = [
        *rows_of("without", coverage=None),
        *rows_of("torn", coverage=0.21),
        *rows_of("stopped", contracted=False),
        *rows_of("broken", **{"broke at": 7}),
        *once,
        *rows_of("flow"),
    ]
    lines = {line["case"]: (line["rank"], line["sound on"]) for line in ranking(rows)}
    assert list(lines) == ["once", "flow", "torn", "stopped", "broken", "without"]
    assert lines["flow"] == (1, "3/3")
    assert lines["once"] == (1, "2/3")
    assert lines["torn"] == lines["stopped"] == lines["broken"] == (2, "0/3")
    assert lines["without"] == (3, "0/3")


def test_every_operator_and_weight_is_measured():
    assert {name.split(";")[0] for name in OTHERS} < set(OPERATORS)
    assert len(WEIGHT_CASES) == 20


def test_bending_keeps_lengths_along_the_middle_and_turns_by_the_angle():
    mesh = capsule(3.0, 0.4, 12)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    along = np.argmax(high - low)
    across = np.argsort(high - low)[1]
    line = np.zeros((50, 3))
    line[:, along] = np.linspace(low[along], high[along], 50)
    line[:, across] = high[across]
    arc = bent(line, mesh)
    pieces = np.linalg.norm(np.diff(arc, axis=0), axis=1)
    assert pieces.sum() == pytest.approx((high - low)[along], rel=1e-3)  # chords of an arc
    first, last = np.diff(arc, axis=0)[[0, -1]]
    turned = np.arccos(first @ last / pieces[0] / pieces[-1])
    assert turned == pytest.approx(BEND * 48 / 49)


def test_a_trial_measures_a_system_of_the_contraction(tmp_path):
    from scipy.sparse import save_npz

    mesh = torus(1.0, 0.3, 24, 10)
    start = mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.extent)
    K, B = _system(start, start, 1)
    assert K.shape == (2 * len(mesh.vertices), len(mesh.vertices))
    exact = lstsq(K, B, "qr")
    save_npz(tmp_path / "1_early.npz", K)
    np.savez(tmp_path / "1_early_sides.npz", B=B, X=exact)
    direct = trial(1, "early", "cholmod", 60.0, tmp_path)
    assert direct["error"] < 1e-8
    assert direct["curve"] == []
    iterative = trial(1, "early", "cgls", 60.0, tmp_path)
    assert iterative["iterations"] == iterative["curve"][-1][0] > 1
    assert iterative["curve"][0][2] > iterative["error"]
    assert trial(1, "early", "richardson", 0.0, tmp_path)["ended"] == "cap of 0 s"


def test_further_meshes_go_to_benchmarks_that_take_them(tmp_path, monkeypatch):
    assert {"influence", "solvers"} <= set(names())
    (tmp_path / "b.off").touch()
    (tmp_path / "a.off").touch()
    told = []
    monkeypatch.setattr("benchmarks.influence.run", lambda quick, results, meshes=(): told.append(meshes))
    monkeypatch.setattr("benchmarks.solvers.run", lambda quick, results: told.append(None))
    assert main(["influence", "solvers", "--results", str(tmp_path / "results"), "--meshes", str(tmp_path)]) == 0
    assert [path.name for path in told[0]][:2] == ["a.off", "b.off"]
    assert told[1] is None
