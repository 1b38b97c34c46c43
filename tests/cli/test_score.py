"""``lbskel score``: a line for each measure, and the verdict as the exit code."""

import json

import pytest

from lbskel import skeletonize, write_mesh, write_skeleton
from lbskel.cli.main import main
from lbskel.evaluation.measures import MEASURES


@pytest.fixture(scope="module")
def files(tmp_path_factory, ring):
    """A ring and its skeleton, with its map and without."""
    folder = tmp_path_factory.mktemp("score")
    skeleton = skeletonize(ring)
    write_mesh(folder / "mesh.ply", ring)
    write_skeleton(folder / "good.json", skeleton)
    write_skeleton(folder / "tree.swc", skeleton)
    return folder


def test_a_good_skeleton_passes(files, capsys):
    assert main(["score", str(files / "good.json"), str(files / "mesh.ply")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["measure", "value", "verdict", "passes", "fails"]
    assert len(lines) == len(MEASURES) + 2
    assert all(" pass " in line for line in lines[1:-1])
    assert lines[-1] == "verdict: pass; the shape has 0 extremities"


def test_a_file_without_a_map_is_measured_without_it(files, capsys):
    # reading closes the cycles that writing as a tree had cut
    assert main(["score", str(files / "tree.swc"), str(files / "mesh.ply")]) == 0
    out = capsys.readouterr().out
    assert out.count("  not measured") == 2
    assert "not measured, since the skeleton has no vertex map: connected regions, adjacent regions" in out


def test_a_cycle_that_was_cut_fails(files, capsys):
    document = json.loads((files / "good.json").read_text())
    document["edges"] = document["edges"][1:]
    (files / "cut.json").write_text(json.dumps(document))
    assert main(["score", str(files / "cut.json"), str(files / "mesh.ply"), "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["verdict"] == report["verdicts"]["extra_cycles"] == "fail"
    assert report["measures"]["extra_cycles"] == -1


@pytest.mark.parametrize(
    ("skeleton", "mesh", "named"),
    [
        ("none.json", "mesh.ply", "none.json"),
        ("good.json", "none.ply", "none.ply"),
        ("mesh.ply", "good.json", "mesh.ply"),
    ],
)
def test_what_cannot_be_read_is_told_in_a_line(files, capsys, skeleton, mesh, named):
    assert main(["score", str(files / skeleton), str(files / mesh)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert named in captured.err


def test_the_map_of_another_mesh_is_told(files, capsys, two_rings):
    write_mesh(files / "other.off", two_rings)
    assert main(["score", str(files / "good.json"), str(files / "other.off")]) == 2
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert "map is for 128 vertices, but the mesh has 576" in error
