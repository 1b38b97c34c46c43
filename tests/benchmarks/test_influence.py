"""The benchmarks of influence and solvers: how cases are ranked and combined, shapes bent, systems made and watched."""

import numpy as np
import pytest

from benchmarks.influence_cases import OTHERS, WEIGHT_CASES, ranking
from benchmarks.influence_claims import BEND, bent
from benchmarks.influence_factorial import CROSSED, FACTORS, combinations, explained, measure, tables
from benchmarks.solvers import _is_useful, _system, trial
from benchmarks.solvers_trials import OutOfTimeError, Watch
from lbskel import ContractionSettings, skeletonize
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.weights import WEIGHTS
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
        *rows_of("curvature_flow"),
    ]
    lines = {line["case"]: (line["rank"], line["sound on"]) for line in ranking(rows)}
    assert list(lines) == ["once", "curvature_flow", "torn", "stopped", "broken", "without"]
    assert lines["curvature_flow"] == (1, "3/3")
    assert lines["once"] == (1, "2/3")
    assert lines["torn"] == lines["stopped"] == lines["broken"] == (2, "0/3")
    assert lines["without"] == (3, "0/3")


def test_every_operator_and_weight_is_measured():
    assert {name.split(";")[0] for name in OTHERS} < set(OPERATORS)
    assert len(WEIGHT_CASES) == 2 * 2 * len(WEIGHTS)
    assert ContractionSettings() in WEIGHT_CASES.values()


def test_combinations_are_all_that_mean_something():
    found = combinations()
    operators = {levels[0] for levels in found}
    assert operators == set(OPERATORS) - {"random_walk"}
    for (operator, energy, weights), settings in found.items():
        assert settings.energy == energy.split(",")[0].replace(" ", "_")
        assert settings.initial_weight_rule == WEIGHTS[weights]["initial_weight_rule"]
        assert (settings.degenerate_rows == "none") == ("," not in energy)
        assert "," not in energy or operator not in ("graph", "heat_kernel", "cotangent_identity")
    energies = {energy for operator, energy, _ in found if operator == "cotangent"}
    assert energies == {"curvature flow", "least squares", *(f"least squares, {rows}" for rows in ROW_TREATMENTS)} - {
        "least squares, none"
    }
    assert ("mean_value", "curvature flow", "local_radius") not in found
    assert len(found) == len(CROSSED) * (
        9 * len(ROW_TREATMENTS) + 8 + 2 * 3
    )  # 9 treated, 8 of them symmetric, 3 untreated


def test_variance_is_laid_to_the_factor_and_the_pair_that_cause_it():
    levels = [
        {"operator": o, "energy and rows": e, "weights": w, "mesh": m}
        for o in "abc"
        for e in "xy"
        for w in "pq"
        for m in "12"
    ]
    by_one = {
        line["what"]: line["share"] for line in explained([{**row, "sound": row["operator"] == "a"} for row in levels])
    }
    assert by_one["operator"] == pytest.approx(1)
    assert max(share for what, share in by_one.items() if what != "operator") < 1e-12  # rounding
    either = [{**row, "sound": (row["energy and rows"] == "x") == (row["weights"] == "p")} for row in levels]
    assert explained(either)[0]["what"] == "energy and rows with weights"
    assert explained(either)[0]["share"] == pytest.approx(1)
    assert explained([{**row, "sound": True} for row in levels]) == []


def test_combinations_are_measured_and_tabulated(monkeypatch, ring):
    monkeypatch.setattr("benchmarks.influence_factorial.CROSSED", {"local_radius": WEIGHTS["local_radius"]})
    truth = skeletonize(ring, preprocess=None)
    rows = measure({"ring": (ring, truth)}, ["intrinsic_delaunay", "mean_value_symmetric"])
    assert len(rows) == 10
    by_levels = {tuple(row[factor] for factor in FACTORS): row for row in rows}
    default = by_levels["intrinsic_delaunay", "curvature flow", "local_radius"]
    assert default["sound"]
    assert default["coverage"] < 1e-9  # it is its own truth
    text = tables(rows)
    assert all(f"| {row['operator']} | {row['energy and rows']} | local_radius |" in text for row in rows)


def test_a_watch_takes_no_time_for_looking_and_ends_at_the_cap():
    exact = np.ones((3, 1))
    watch = Watch(exact, 60.0, by_restarts=False)
    for number in range(1, 301):
        watch(number, exact * (1 + 1 / number))
    numbers, seconds, errors = map(np.array, zip(*watch.curve, strict=True))
    assert list(numbers) == [1, 2, 3, 4, 5, 6, 7, 8, 16, 32, 64, 100, 128, 200, 256, 300]
    assert errors == pytest.approx(1 / numbers)
    assert (np.diff(seconds) >= 0).all()
    watch.began -= 61
    with pytest.raises(OutOfTimeError):
        watch(301, 2 * exact)
    assert watch.curve[-1][0] == 301
    anew = Watch(exact, 60.0, by_restarts=True)
    anew.began -= 31  # another run, twice as long, would take over the cap
    with pytest.raises(OutOfTimeError):
        anew(64, exact)


def test_what_failed_is_not_tried_on_larger_systems():
    assert _is_useful({"error": 1e-9})
    assert _is_useful({"error": 1e-3, "ended": "2000 iterations"})
    assert not _is_useful({"error": 0.3, "ended": "2000 iterations"})
    assert not _is_useful({"error": 1e-3, "ended": "over 60 s"})
    assert not _is_useful({"ended": "refused: a dense matrix"})


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
    start = mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.diameter_bound)
    K, B = _system(start, start, 1)
    assert K.shape == (2 * len(mesh.vertices), len(mesh.vertices))
    exact = lstsq(K, B, "qr")
    save_npz(tmp_path / "1_early.npz", K)
    np.savez(tmp_path / "1_early_sides.npz", B=B, X=exact)
    direct = trial(1, "early", "cholmod", 60.0, tmp_path)
    assert direct["error"] < 1e-8
    assert not direct.keys() & {"curve", "iterations", "ended"}
    iterative = trial(1, "early", "cgls", 60.0, tmp_path)
    assert iterative["iterations"] == iterative["curve"][-1][0] > 1
    assert iterative["curve"][0][2] > iterative["error"]
    halted = trial(1, "early", "richardson", 0.0, tmp_path)
    assert (halted["ended"], halted["iterations"], len(halted["curve"])) == ("over 0 s", 1, 1)
    shown = trial(1, "early", "lsmr", 60.0, tmp_path)
    assert shown["error"] == shown["curve"][-1][2] < shown["curve"][0][2]
