"""Pipelines as text, as TOML and in Python; the presets; what every step has in common."""

import copy
import dataclasses
import json
import pickle

import numpy as np
import pytest
from helpers import joined, triangle_soup, without_faces
from scipy.spatial.transform import Rotation

from benchmarks.preprocessing import from_clean, scanned
from lbskel import FormatError, Mesh, Pipeline, UnknownChoice, skeletonize
from lbskel.cli.main import main
from lbskel.io import read_mesh, write_mesh
from lbskel.preprocess import PIPELINES, STEPS, preprocess_mesh
from lbskel.preprocess.result import hausdorff_distance
from lbskel.shapes import cylinder, flat_grid, make, torus, voxel_surface

TORUS = torus(1.0, 0.4, 40, 24)


def test_a_pipeline_and_its_text_are_equivalent():
    text = "merge_close:tolerance=0.001,remesh_isotropic:edge_length=0.3:relative_to=thickness,simplify:error=0.1"
    pipeline = Pipeline.parse(text)
    assert [name for name, _ in pipeline.steps] == ["merge_close", "remesh_isotropic", "simplify"]
    assert pipeline.steps[1][1] == {"edge_length": 0.3, "relative_to": "thickness"}
    assert str(pipeline) == text
    for preset in PIPELINES.values():
        assert str(Pipeline.parse(str(preset))) == str(preset)


@pytest.mark.parametrize(
    "step",
    [
        "close_holes:max_perimeter=0.5",
        "merge_close:tolerance=0.018",
        "remesh_isotropic:edge_length=0.1",
    ],
)
def test_a_step_does_the_same_to_a_cube_on_its_corner(step):
    """The diagonal of its box is 10.4, on its corner 15.4; the perimeter of its hole is 6.8, and a gap 0.23 wide."""
    if "remesh" in step:
        pytest.importorskip("pymeshlab")
    cube = voxel_surface(np.ones((6, 6, 6)))
    near = np.flatnonzero(np.linalg.norm(cube.vertices - cube.vertices.mean(axis=0), axis=1) < 3.2)[0]
    cube = without_faces(cube, np.flatnonzero((cube.faces == near).any(axis=1)))
    slit = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.23, 0, 0], [0, 0.23, 1]], [[0, 1, 2], [3, 4, 1]])
    mesh = joined(cube, slit.with_vertices(slit.vertices + cube.vertices.mean(axis=0)))
    turn, _ = Rotation.align_vectors([[0, 0, 1]], [[1, 1, 1]])
    turned = mesh.with_vertices(mesh.vertices @ turn.as_matrix().T)
    assert turned.diagonal > 1.4 * mesh.diagonal
    results = [Pipeline.parse(step)(each) for each in (mesh, turned)]
    n, n_turned = (len(result.mesh.faces) + len(result.mesh.vertices) for result in results)
    assert n_turned == pytest.approx(n, rel=0.05 if "remesh" in step else 0)
    distance, distance_turned = (result.report["distance"] for result in results)
    assert distance_turned == pytest.approx(distance, abs=0.001 if "remesh" in step else 1e-9)


@pytest.mark.parametrize("steps", [None, [("simplify",)], [("simplify", 5)], [3]])
def test_steps_are_names_or_pairs(steps):
    with pytest.raises(UnknownChoice, match="steps must be a list of names, or of pairs of a name and a mapping"):
        Pipeline(steps)


def test_numbers_of_numpy_and_whole_ones_are_numbers():
    options = {"target_faces": np.int64(500), "error": np.float32(0.5)}
    assert str(Pipeline([("simplify", options)])) == "simplify:target_faces=500:error=0.5"
    assert str(Pipeline.parse("simplify:target_faces=1e3")) == "simplify:target_faces=1000"


def test_who_changes_a_pipeline_changes_no_other():
    parsed = Pipeline.parse("cad")
    parsed.steps[-1][1]["edge_length"] = 9
    assert PIPELINES["cad"].steps[-1][1]["edge_length"] != 9
    assert str(pickle.loads(pickle.dumps(parsed))) == str(copy.deepcopy(parsed)) == str(parsed)


def test_the_steps_of_a_pipeline_can_be_written():
    pipeline = Pipeline([("refine", {"max_edge_length": 0.5})])
    assert dataclasses.asdict(pipeline) == {"steps": (("refine", {"max_edge_length": 0.5}),)}
    assert json.loads(json.dumps(pipeline.steps)) == [["refine", {"max_edge_length": 0.5}]]


def test_a_pipeline_is_read_from_toml(tmp_path):
    path = tmp_path / "clean.toml"
    path.write_text('[[step]]\nname = "merge_close"\n[[step]]\nname = "simplify"\ntarget_faces = 300\n')
    assert str(Pipeline.read(path)) == "merge_close,simplify:target_faces=300"
    assert preprocess_mesh(TORUS, str(path)).report["pipeline"] == "merge_close,simplify:target_faces=300"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("polish", "unknown pipeline or step 'polish'; choose one of: scan"),
        ("merge_close,polish", "unknown step 'polish'"),
        ("merge_close:radius=1", "merge_close has no option 'radius'; it has: tolerance"),
        ("fix_orientation:radius=1", "it has: none"),
        ("refine:max_edge_length=long", "option max_edge_length of refine must have type float, not 'long'"),
        ("smooth_noise:iterations=2.5", "must have type int"),
        ("remesh_isotropic:relative_to=height", "unknown reference length 'height'; choose one of: diameter_bound"),
        ("remesh_isotropic:relative_to=diagonal", "use diameter_bound with 1.1 times the number"),
        ("", "unknown pipeline or step ''"),
    ],
)
def test_invalid_steps_are_rejected(text, message):
    with pytest.raises(UnknownChoice) as error:
        Pipeline.parse(text)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[[step]", "not TOML"),
        (b"\xff\xfe", "not TOML"),
        (b"step = 3", "must hold a table"),
        (b'other = 1\n[[step]]\nname = "refine"', "must hold a table"),
        (b"[[step]]\nedge = 1.0", "has no name"),
    ],
)
def test_invalid_toml_is_rejected(tmp_path, content, message):
    path = tmp_path / "clean.toml"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message):
        Pipeline.read(path)
    with pytest.raises(FormatError, match="cannot be read"):
        Pipeline.read(tmp_path / "none.toml")


def test_a_boolean_is_not_a_number():
    with pytest.raises(UnknownChoice, match="type float"):
        Pipeline([("refine", {"max_edge_length": True})])


def test_the_vertex_map_is_composed_over_all_steps():
    """Merging, removal of debris and simplification: each vertex of the soup is mapped to a vertex near it."""
    given = joined(triangle_soup(TORUS), Mesh([[5, 0, 0], [5.1, 0, 0], [5, 0.1, 0]], [[0, 1, 2]]))
    result = Pipeline.parse("merge_close,keep_components,simplify:target_faces=400")(given)
    assert (result.vertex_map.indices[-3:] == -1).all()
    assert result.mesh.genus == 1
    there = result.mesh.vertices[result.vertex_map.indices[:-3]]
    start, end = result.mesh.vertices[result.mesh.edges].transpose(1, 0, 2)
    # merged into a corner of the triangle that covers it
    assert np.linalg.norm(there - given.vertices[:-3], axis=1).max() < 1.5 * np.linalg.norm(end - start, axis=1).max()
    report = result.report
    assert report["pipeline"] == "merge_close,keep_components,simplify:target_faces=400"
    assert [step["step"] for step in report["steps"]] == ["merge_close", "keep_components", "simplify"]
    assert report["steps"][2]["options"] == {"target_faces": 400}
    assert json.loads(json.dumps(report)) == report


@pytest.mark.parametrize("name", sorted(set(PIPELINES) - {"cad"}))
def test_presets_keep_a_valid_shape(name):
    result = PIPELINES[name](TORUS)
    assert result.mesh.genus == 1
    assert hausdorff_distance(TORUS, result.mesh) < 0.01
    assert (result.vertex_map.indices >= 0).all()


def test_the_scan_preset_keeps_the_shape_of_a_coarse_mesh():
    """Smoothing acts on wavelengths of a few edges, which on a coarse mesh are the shape itself."""
    given = torus(1.0, 0.4, 9, 5)
    start, end = given.vertices[given.edges].transpose(1, 0, 2)
    assert np.linalg.norm(end - start, axis=1).max() > 0.2 * given.diagonal
    assert hausdorff_distance(given, PIPELINES["scan"](given).mesh) < 0.03


@pytest.mark.parametrize("name", ["tripod", "spiked_ring"])
def test_a_simulated_scan_has_the_skeleton_of_the_shape(name):
    mesh = make(name, n_vertices=3000).mesh
    skeleton = skeletonize(scanned(mesh), preprocess="scan")
    found = from_clean(skeleton, skeletonize(mesh), mesh.diagonal)
    assert found["the same within the limits"], found


@pytest.mark.parametrize("name", sorted(set(STEPS) - {"smooth_noise", "simplify", "remesh_isotropic"}))
def test_steps_return_a_valid_mesh_unchanged(name, ring, rod):
    fine = torus(1.0, 0.4, 40, 24)
    result = STEPS[name](fine)
    assert result.mesh is fine
    assert result.vertex_map.indices.tolist() == list(range(len(fine.vertices)))
    assert result.notes == ()
    [record] = result.report["steps"]
    assert record["step"] == name
    assert record["before"] == record["after"]


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("close_holes", {"max_perimeter": 0.0}),
        ("keep_components", {"min_area": 2.0}),
        ("remove_degenerate", {"angle": 90.0}),
        ("refine", {"max_edge_length": -1.0}),
        ("smooth_noise", {"iterations": -1}),
        ("smooth_noise", {"iterations": 10**12}),
        ("simplify", {}),
        ("simplify", {"target_faces": 9, "error": 0.1}),
        ("simplify", {"error": 0.0}),
        ("remesh_isotropic", {"edge_length": 0.0}),
        ("remesh_isotropic", {"edge_length": 1e-6}),
        ("remesh_isotropic", {"relative_to": "height"}),
    ],
)
def test_options_out_of_range_are_rejected(name, options, ring):
    with pytest.raises(UnknownChoice):
        STEPS[name](ring, **options)


def test_check_and_preprocess_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_mesh("ring.ply", without_faces(TORUS, range(4)))
    write_mesh("sheet.ply", flat_grid())
    assert main(["check", "ring.ply"]) == 0
    assert "1 hole in the surface" in capsys.readouterr().out
    assert main(["check", "sheet.ply"]) == 1
    assert "not advised" in capsys.readouterr().out
    assert main(["check", "ring.ply", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["boundary_loops"] == 1

    (tmp_path / "clean.toml").write_text('[[step]]\nname = "close_holes"\n')
    arguments = ["preprocess", "ring.ply", "-o", "out.obj", "--map", "map.npy", "--report", "report.json"]
    assert main([*arguments, "--pipeline", "clean.toml"]) == 0
    assert read_mesh("out.obj").genus == 1
    assert np.load("map.npy").tolist() == list(range(len(TORUS.vertices)))
    assert json.loads((tmp_path / "report.json").read_text())["pipeline"] == "close_holes"
    assert main(arguments) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*arguments, "--force", "--preprocess", "close_holes,simplify:target_faces=200"]) == 0
    assert len(read_mesh("out.obj").faces) <= 220
    capsys.readouterr()
    assert main([*arguments, "--force", "--preprocess", "polish"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_skeletonize_on_the_command_line_takes_a_pipeline(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_mesh("pipe.ply", cylinder(0.3, 3.0, 12, 16))
    assert main(["skeletonize", "pipe.ply", "-o", "a.json", "--preprocess", "none", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["preprocess"] == {}
    assert main(["skeletonize", "pipe.ply", "-o", "b.json", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["preprocess"]["steps"][0]["step"] == "close_holes"
