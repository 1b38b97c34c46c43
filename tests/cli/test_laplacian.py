"""``lbskel laplacian``: the table of every operator, the JSON, the picture, and operators that are not defined."""

import argparse
import json

import numpy as np
import pytest

from lbskel import FormatError, Mesh, MeshError, UnknownChoice, laplacian, laplacian_diagnostics
from lbskel.cli import laplacian as command
from lbskel.io import write_mesh
from lbskel.operators import OPERATORS
from lbskel.shapes import schwarz_lantern


def run_command(*arguments):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    parsed = parser.parse_args(["laplacian", *map(str, arguments)])
    return parsed.run(parsed)


def test_the_command_prints_every_operator_and_writes_what_is_asked_for(tmp_path, capsys):
    path = tmp_path / "lantern.off"
    write_mesh(path, schwarz_lantern(8, 30))
    assert run_command(path, "-o", tmp_path / "health.json") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1 : 1 + len(OPERATORS)]] == list(OPERATORS)
    assert "!" in next(line for line in lines if line.startswith("cotangent "))
    assert "!" in next(line for line in lines if line.startswith("mean_value "))
    written = json.loads((tmp_path / "health.json").read_text())
    assert written["operators"]["cotangent"]["passed"]["positive"] is False
    assert written["operators"]["graph"]["n_components"] == 1
    assert run_command(path, "--operator", "robust", "--picture", tmp_path / "curvature.png") == 0
    assert (tmp_path / "curvature.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(FormatError, match="exists"):
        run_command(path, "-o", tmp_path / "health.json")


def test_the_picture_leaves_out_what_has_no_curvature(tmp_path, capsys, monkeypatch):
    path, drawn = tmp_path / "lantern.off", []
    write_mesh(path, schwarz_lantern(6, 8))
    monkeypatch.setattr("lbskel.visualization.render", lambda panels, *_, **__: drawn.extend(panels))
    assert run_command(path, "--picture", tmp_path / "curvature.png") == 0
    assert [panel.title for panel in drawn] == [name for name in OPERATORS if name != "random_walk"]
    capsys.readouterr()
    with pytest.raises(UnknownChoice, match=r"random_walk has no curvature to draw.*leave --picture out"):
        run_command(path, "--operator", "random_walk", "--picture", tmp_path / "no.png", "-o", tmp_path / "no.json")
    assert capsys.readouterr().out == ""
    assert not (tmp_path / "no.json").exists()


def test_the_command_goes_on_where_an_operator_is_not_defined(tmp_path, capsys):
    path = tmp_path / "fin.off"
    write_mesh(path, Mesh(np.eye(5, 3) + 1, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert run_command(path, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    refused = {"intrinsic_delaunay", "anisotropic"}
    assert set(document["refused"]) == refused
    assert set(document["operators"]) == set(OPERATORS) - refused
    with pytest.raises(MeshError, match="use the operator 'robust'"):
        run_command(path, "--operator", "intrinsic_delaunay")
    assert run_command(path, "--operator", "graph") == 0
    assert len(capsys.readouterr().out.splitlines()) == 2 + 1 + 5


def test_one_operator_prints_what_print_of_its_diagnostics_does(tmp_path, capsys):
    path = tmp_path / "lantern.off"
    mesh = schwarz_lantern(8, 30)
    write_mesh(path, mesh)
    assert run_command(path, "--operator", "graph") == 0
    printed = capsys.readouterr().out.rstrip("\n").splitlines()
    expected = str(laplacian_diagnostics(laplacian(mesh, operator="graph"), mesh)).splitlines()
    assert printed[1].split()[1:] == expected[1].split()[1:]
    assert printed[2:] == expected[2:]


def test_a_triangle_without_area_is_written_as_json(tmp_path, capsys):
    path = tmp_path / "flat.off"
    write_mesh(path, Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]], [[0, 1, 2]]))
    assert run_command(path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["operators"]
