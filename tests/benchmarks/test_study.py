"""The study: each figure is of the results that it is written from, and each count of breaks names its stop."""

import json

from benchmarks.influence_cases import WEIGHT_CASES, box_before, breaks
from benchmarks.study import DEFAULT, PLAIN, STRATEGIES, run

MACHINE = {"machine": {"commit": "abc", "date": "today"}}


def row_of(case, mesh="one", **changes):
    row = {
        "case": case,
        "mesh": mesh,
        "broke at": None,
        "contracted": True,
        "coverage": 0.1,
        "accuracy": 0.1,
        "steps": 8,
    }
    free = {"free steps": 3, "volumes": [0.5, 2e-5, 1e-7], "areas": [0.8, 0.2, 0.01], "boxes": [1.0, 0.9, 0.8]}
    moved = {"largest box": 1.0, "treated": [0, 1, 2], "max_displacement": [0.0, 0.2, 0.3]}
    return {**row, **free, **moved, "topology right": True, "tips right": True, **changes}


def test_a_break_counts_only_above_its_stop():
    late = row_of("late", **{"broke at": 3, "boxes": [1.0, 0.9, 50.0]})
    assert breaks(late, 1e-6)
    assert not breaks(late, 1e-4)  # the volume was below that a step earlier
    assert box_before(late) == 1.0
    early = row_of("early", **{"broke at": 2})
    assert breaks(early, 1e-4)
    opened = row_of("open", **{"broke at": 3, "volumes": [None] * 3})
    assert breaks(opened, 1e-4)
    assert not breaks({**opened, "areas": [0.8, 0.09, 0.01]}, 1e-4)
    assert not breaks(row_of("sound"), 1e-6)


def test_the_page_has_the_figures_of_the_results(tmp_path):
    shapes = [row_of(case, mesh) for mesh in ("one", "two") for case in STRATEGIES]
    for row in shapes:
        if row["case"] == PLAIN and row["mesh"] == "two":
            row |= {"broke at": 3, "boxes": [1.0, 0.9, 700.0], "largest box": 700.0}
        if row["case"] == DEFAULT:
            row["accuracy"] = 0.0625
    claim = {
        "shape": "one",
        "preset": "au2008",
        "steps": 24,
        "accuracy": 0.1,
        "accuracy, noisy": 0.2,
        "homotopic": True,
    }
    claim |= {"turned, apart": 1e-9, "accuracy, bent": 0.3, "bent, tips alike": False, "thin first": 0.75}
    combinations = [
        {"mesh": "one", "operator": operator, "energy and rows": "curvature flow", "weights": "au2008", "sound": sound}
        | {"coverage": 0.1, "accuracy": 0.1, "steps": 9, "seconds": 1.0}
        for operator, sound in (("cotangent", False), ("robust", True))
    ]
    solved = {"mesh": "torus", "vertices": 9, "energy": "least squares", "step": 1, "seconds": 0.5, "error": 1e-9}
    influence = {
        **MACHINE,
        "parts": {"weights": "abc", "all combinations": "an older one"},
        "strategies": shapes,
        "strategies, real meshes": [row_of(case, "dino.off") for case in STRATEGIES],
        "weights": [row_of(case) for case in WEIGHT_CASES],
        "claims of Au et al. 2008": [claim],
        "all combinations": combinations,
    }
    (tmp_path / "influence.json").write_text(json.dumps(influence))
    (tmp_path / "solvers.json").write_text(json.dumps({**MACHINE, "ordinary": [{**solved, "method": "cholmod"}]}))
    run(False, tmp_path)
    page = (tmp_path / "study.md").read_text()
    assert "(commit abc, today)" in page
    assert "Measured at another commit: *all combinations* at commit an older one." in page
    assert "**Plain cotangents** break on 1/2 shapes above 1e-06 of the volume and on 0/2 above 0.0001" in page
    assert "on 0/1 and 0/1 meshes, first at step 3; with roll-back they reach their target on 2 of 2 shapes" in page
    assert "boxes grew to up to 7e+02 times" in page
    assert f"| {PLAIN} | 1/2 | 1/2, 0/1 | 0/2, 0/1 | 3 | 1 | 2 of 2 | 8 | 0.1 | 0.1 |" in page
    assert "| 0.0625 |" in page
    assert "2 combinations that mean something, on one" in page
    assert "| torus | 9 | least squares | 1 | 0.5 s, 1e-09 |" in page
    assert "| to pose: mean accuracy, straight and bent | 0.100 and 0.300 |" in page
