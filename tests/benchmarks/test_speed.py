"""The speed benchmark: its tools answer, failures become rows, and its tables are of what was measured."""

import json
import shutil

import pytest

import lbskel
from benchmarks import cgal, speed, speed_tools
from benchmarks.provenance import ROOT
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import inside_fraction


@pytest.fixture
def mesh(tmp_path, tripod):
    lbskel.write_mesh(tmp_path / "tripod.ply", tripod)
    lbskel.write_skeleton(tmp_path / "tripod.npz", lbskel.skeletonize(tripod))
    return tmp_path / "tripod.ply"


@pytest.mark.parametrize("tool", ["lbskel", "reading", "and simplifying", "factorisations"])
def test_each_of_our_own_answers(tool, mesh):
    row = {**speed_tools.TOOLS, **speed_tools.LIMITS}[tool](mesh)
    assert 0 <= row["read"] <= row["seconds"]
    if tool == "lbskel":
        assert row["cycles"] == 0
        assert row["accuracy"] < 1e-12  # compared with itself, so rounding only
        assert row["inside_fraction"] == 1


def fails(path):
    raise RuntimeError("is not there")


def test_a_failure_is_a_row_and_a_late_tool_is_not_asked_again(mesh, monkeypatch):
    monkeypatch.setattr(speed, "TOOLS", {"broken": fails, "late": fails})
    monkeypatch.setattr(speed, "LIMITS", {"reading": speed_tools.LIMITS["reading"]})
    broken, late, reading = speed._rows(mesh, "tripod.ply", 1508, 1, {"late"})
    assert broken == {"mesh": "tripod.ply", "faces": 1508, "tool": "broken", "error": "RuntimeError: is not there"}
    assert late == {
        "mesh": "tripod.ply",
        "faces": 1508,
        "tool": "late",
        "error": f"over {speed.ALLOWED:g} s at a smaller size",
    }
    assert reading["seconds"] > 0
    assert reading["megabytes"] > 10


def test_exponents_and_ratios_are_of_the_rows(tmp_path):
    faces = [50_000, 100_000, 400_000]
    rows = [
        {"mesh": "dinosaur", "faces": n, "tool": "lbskel", "seconds": 1e-6 * n**1.5, "megabytes": 1.0} for n in faces
    ]
    rows += [
        {"mesh": "dinosaur", "faces": n, "tool": "CGAL medial", "seconds": 4e-6 * n**1.5, "megabytes": 1.0}
        for n in faces[:2]
    ]
    rows += [{"mesh": "dinosaur", "faces": faces[2], "tool": "CGAL medial", "error": "over 300 s"}]
    exponents = {row["tool"]: row["exponent"] for row in speed._exponents(rows)}
    assert exponents == pytest.approx({"lbskel": 1.5, "CGAL medial": 1.5})  # exact powers: only rounding
    ratios = [row["CGAL medial"] for row in speed._ratios(rows) if row["reference"] == "lbskel"]
    assert ratios == [pytest.approx(4), pytest.approx(4), None]
    speed._write(rows, tmp_path, [])
    assert json.loads((tmp_path / "speed.json").read_text())["rows"][-1]["error"] == "over 300 s"
    assert "over 300 s" in (tmp_path / "speed.md").read_text()
    assert (tmp_path / "speed.png").stat().st_size > 1000


def test_larger_meshes_are_the_same_shape(tmp_path, monkeypatch):
    monkeypatch.setattr(speed, "DIRECT", 2_000)
    speed._write_shape(tmp_path / "shape.ply", 5_000)
    mesh = lbskel.read_mesh(tmp_path / "shape.ply")
    assert len(mesh.faces) == pytest.approx(5_000, rel=0.25)
    assert mesh.is_closed_manifold
    axis = lbskel.read_skeleton(tmp_path / "shape.npz")
    assert inside_fraction(axis, Surface(mesh)) == 1


def test_without_a_compiler_cgal_is_told_to_be_missing(monkeypatch):
    cgal.driver.cache_clear()
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(RuntimeError, match="CGAL is not built: there is no C\\+\\+ compiler"):
        cgal.driver()


def test_imports_are_not_timed(mesh, python):
    """In a new process, where packages are imported when they are first used: they are, when the clock starts."""
    script = f"""
import sys, time
from pathlib import Path
from benchmarks import speed_tools

clock, loaded = time.process_time, []
speed_tools.time.process_time = lambda: loaded.append(set(sys.modules)) or clock()
speed_tools.TOOLS["lbskel"](Path({str(mesh)!r}))
print(sorted(name for name in loaded[2] - loaded[0] if name.startswith("lbskel.")))
"""
    done = python("-c", script, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr
