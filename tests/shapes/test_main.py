"""The command that writes the example meshes, and the files that it wrote."""

from pathlib import Path

import numpy as np
import pytest

from lbskel.io import read_mesh
from lbskel.shapes import SHAPES
from lbskel.shapes.__main__ import EXAMPLES, main

MESHES = Path(__file__).parents[2] / "meshes"


def test_the_folder_of_meshes_holds_the_files_that_the_command_writes():
    assert {path.name for path in MESHES.iterdir()} == {*EXAMPLES, "README.md"}
    assert sum(path.stat().st_size for path in MESHES.iterdir()) < 2_000_000
    assert (MESHES / "dinosaur.ply").stat().st_size < 400_000


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_mesh_is_the_shape_of_its_file_name(name):
    mesh, solid = read_mesh(MESHES / name), SHAPES[Path(name).stem]()
    genus, n_tips = solid.truth.genus, solid.truth.n_tips
    assert mesh.is_closed_manifold
    assert mesh.genus == genus
    row = next(line for line in (MESHES / "README.md").read_text(encoding="utf-8").splitlines() if f"`{name}`" in line)
    assert row.endswith(f" | {len(mesh.vertices):,} | {genus} | {n_tips} |")
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    noise = EXAMPLES[name].get("noise", 0.0) * np.linalg.norm(end - start, axis=1).mean()
    value = solid.distance(mesh.vertices, cutoff=5 * noise + 0.01)
    assert np.abs(value).max() < 5 * noise + 1e-6  # STL has single precision; noise exceeds 5 deviations once in 1e6


def test_the_command_prints_what_it_writes(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("lbskel.shapes.__main__.EXAMPLES", {"tripod.off": {"n_vertices": 600}})
    main(tmp_path / "new")
    mesh = read_mesh(tmp_path / "new" / "tripod.off")
    assert f"{mesh}, genus 0, 3 tips" in capsys.readouterr().out
