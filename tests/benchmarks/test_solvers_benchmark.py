"""The tables of solvers on ordinary meshes: what counts as solved, and what the sentences say of it."""

import numpy as np
import pytest

from benchmarks.solvers_ordinary import QUICK, _write, sentences, table, trial
from benchmarks.solvers_trials import how_ended


def rows():
    common = {"mesh": "torus", "vertices": 9, "energy": "least squares", "step": 1}
    return [
        {**common, "method": "cholmod", "seconds": 0.5, "error": 1e-9},
        {**common, "method": "superlu", "seconds": 1.0, "error": 1e-9},
        {**common, "method": "cg_amg", "seconds": 4.0, "error": 1e-10, "iterations": 7},
        {**common, "method": "cg_jacobi", "seconds": 0.2, "error": 0.03, "iterations": 2000},
        {**common, "method": "cgls", "ended": "over 20 s"},
    ]


def test_a_method_that_is_fast_and_wrong_has_not_solved_the_system():
    (line,) = table(rows())
    assert line["cholmod"] == "0.5 s, 1e-09"
    assert line["cg_amg"] == "8 x, 1e-10"
    assert line["cg_jacobi"] == "fails: 3e-02 after 0.4 x"
    assert line["cgls"] == "over 20 s"
    said = sentences(rows())
    assert "first of the methods that solve a system on 1 of 1 systems" in said
    assert "`cg_amg`, least squares, step 1: solves 1 of 1, in 8 to 8 times" in said
    assert "`cg_jacobi`, least squares, step 1: solves 0 of 1." in said


@pytest.mark.parametrize(
    ("energy", "methods"), [("least_squares", ("cholmod", "cgls")), ("curvature_flow", ("cg_jacobi",))]
)
def test_methods_agree_with_the_reference_at_the_first_step(energy, methods, tmp_path, monkeypatch):
    monkeypatch.setattr("resource.setrlimit", lambda *_: None)  # which would end the tests
    monkeypatch.setattr("benchmarks.solvers_ordinary.STEPS", (1,))
    _write(QUICK["torus"](), energy, tmp_path)
    for method in methods:
        assert trial(energy, 1, method, 60.0, tmp_path)["error"] < 1e-8
    assert np.isfinite(np.load(tmp_path / "1_sides.npz")["X"]).all()


def test_an_end_by_the_system_is_an_end_of_time():
    assert how_ended("the process ended with code -24", 20.0) == "over 20 s"
    assert how_ended("ValueError: so it is", 20.0) == "ValueError: so it is"
