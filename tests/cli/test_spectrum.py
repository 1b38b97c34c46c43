"""``lbskel spectrum``: eigenvalues and distances as text and JSON, the picture, and what is refused."""

import argparse
import json

import numpy as np
import pytest

from lbskel import FormatError, shape_dna_distance, spectral_basis
from lbskel.cli import spectrum as command
from lbskel.io import write_mesh
from lbskel.shapes import sphere, torus


def run_command(*arguments):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    parsed = parser.parse_args(["spectrum", *map(str, arguments)])
    return parsed.run(parsed)


def test_eigenvalues_and_distances_are_printed_and_written(tmp_path, capsys):
    meshes = {tmp_path / "ball.off": sphere(3), tmp_path / "ring.off": torus(1.0, 0.3)}
    for path, mesh in meshes.items():
        write_mesh(path, mesh)
    json_path, picture = tmp_path / "values.json", tmp_path / "functions.png"
    assert run_command(*meshes, "-k", 12, "-o", json_path, "--picture", picture) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "12 eigenvalues, 1 of them zero, one for each component of the operator; " in lines[0]
    assert lines[0].endswith(f"area {sphere(3).area:.6g}")
    assert lines[1].split()[0] == "0"
    document = json.loads(json_path.read_text())
    bases = [spectral_basis(mesh, 12) for mesh in meshes.values()]
    assert np.allclose(document["values"][str(tmp_path / "ball.off")], bases[0].values, atol=1e-9)
    assert document["shape_dna_distances"] == pytest.approx([shape_dna_distance(*bases)])
    assert lines[-1].endswith(f"{shape_dna_distance(*bases):.4g}")
    assert picture.read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(FormatError, match="exists"):
        run_command(*meshes, "-o", json_path)
