"""The benchmark of damage: what each command is given and how its outcome is told."""

import numpy as np
import pytest

import lbskel
from benchmarks.applications_damage import VERBS, attempt, write_broken
from benchmarks.damage import DAMAGE, Broken, damaged
from lbskel.shapes import torus


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "outputs").mkdir()
    return tmp_path


def test_arrays_are_written_without_loss(folder):
    broken = damaged("noise", torus(1.0, 0.3, 8, 6))
    mesh = lbskel.read_mesh(write_broken(broken, folder / "mesh"))
    assert np.array_equal(mesh.vertices, broken.vertices)
    assert np.array_equal(mesh.faces, broken.faces)
    assert write_broken(Broken(data=b"x", extension="stl"), folder / "mesh").read_bytes() == b"x"


@pytest.mark.parametrize("verb", ["edit", "geodesic", "segment"])
def test_a_sound_mesh_gives_a_result_and_a_broken_one_a_reason(verb, folder):
    path = write_broken(Broken(*torus_arrays()), folder / "mesh")
    assert attempt((verb, path, folder / "outputs")) == ("result", "")
    path = write_broken(damaged("NaN coordinate", torus(1.0, 0.3, 16, 8)), folder / "mesh")
    outcome, said = attempt((verb, path, folder / "outputs"))
    assert outcome == "refused"
    assert "NaN" in said
    assert list((folder / "outputs").iterdir()) == []


def torus_arrays():
    mesh = torus(1.0, 0.3, 16, 8)
    return mesh.vertices, mesh.faces


def test_errors_from_the_inside_and_numbers_that_are_not_finite_are_told(folder, monkeypatch):
    path = write_broken(Broken(*torus_arrays()), folder / "mesh")

    def broken_main(arguments):
        output = folder / "outputs" / "OUT.csv"
        output.write_text("vertex,distance\n0,nan\n")
        return 0

    monkeypatch.setattr("benchmarks.applications_damage.main", broken_main)
    assert attempt(("geodesic", path, folder / "outputs"))[0] == "wrong"
    monkeypatch.undo()
    monkeypatch.setattr("lbskel.cli.geodesic.HeatMethod", lambda *_: 1 / 0)
    outcome, said = attempt(("geodesic", path, folder / "outputs"))
    assert outcome == "unexplained"
    assert "ZeroDivisionError" in said


def test_every_kind_and_command_of_an_application_has_a_row():
    assert len(DAMAGE) == 52
    assert set(VERBS) == {
        "smooth",
        "edit",
        "quantize",
        "compress",
        "spectrum",
        "geodesic",
        "branches",
        "segment",
        "rig",
    }
