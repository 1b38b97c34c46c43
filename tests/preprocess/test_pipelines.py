"""Pipelines as text, TOML and presets; what is done unasked; remeshing in a process that may end; the check."""

import json
import os
import signal

import numpy as np
import pytest
from helpers import joined, moved

from benchmarks.preprocessing import from_clean, scanned
from lbskel import FormatError, Mesh, MeshError, Pipeline, UnknownChoice, check, skeletonize
from lbskel.cli.main import main
from lbskel.io import read_mesh, write_mesh
from lbskel.preprocess import PIPELINES, preprocess_mesh, simplify
from lbskel.preprocess import subprocess_filter as children_module
from lbskel.preprocess.remeshing import remesh_isotropic
from lbskel.preprocess.result import distance_between
from lbskel.preprocess.subprocess_filter import run_in_subprocess
from lbskel.preprocess.transfer import transfer_map
from lbskel.shapes import capsule, chain_of_tori, cylinder, flat_grid, make, sphere, torus

FINE = torus(1.0, 0.4, 40, 24)


def holed(mesh):
    return Mesh(mesh.vertices, mesh.faces[7:])


def soup(mesh):
    """Every triangle with three vertices of its own."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def hangs_together(mesh, target):
    """Whether the vertices that go to one vertex are joined through edges of the mesh."""
    same = mesh.edges[target[mesh.edges[:, 0]] == target[mesh.edges[:, 1]]]
    faces = np.concatenate([np.column_stack([same, same[:, 0]]), np.arange(len(target))[:, None].repeat(3, 1)])
    return len(np.unique(Mesh(mesh.vertices, faces).component_of_vertex)) == len(np.unique(target))


# --- text, TOML, Python


def test_text_gives_the_pipeline_and_back():
    text = "merge_close:tolerance=0.001,remesh_isotropic:edge=0.3:of=thickness,simplify:target_faces=100"
    pipeline = Pipeline.parse(text)
    assert [name for name, _ in pipeline.steps] == ["merge_close", "remesh_isotropic", "simplify"]
    assert pipeline.steps[1][1] == {"edge": 0.3, "of": "thickness"}
    assert str(pipeline) == text
    for preset in PIPELINES.values():
        assert str(Pipeline.parse(str(preset))) == str(preset)


def test_toml(tmp_path):
    path = tmp_path / "clean.toml"
    path.write_text('[[step]]\nname = "merge_close"\n[[step]]\nname = "simplify"\ntarget_faces = 300\n')
    assert str(Pipeline.read(path)) == "merge_close,simplify:target_faces=300"
    assert preprocess_mesh(FINE, str(path)).report["pipeline"] == "merge_close,simplify:target_faces=300"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("polish", "unknown pipeline or step 'polish'; choose one of: scan"),
        ("merge_close,polish", "unknown step 'polish'"),
        ("merge_close:radius=1", "merge_close has no option 'radius'; it has: tolerance"),
        ("fix_orientation:radius=1", "it has: none"),
        ("refine:edge=long", "option edge of refine must be of type float, not 'long'"),
        ("smooth_noise:iterations=2.5", "must be of type int"),
        ("", "unknown pipeline or step ''"),
    ],
)
def test_wrong_steps_are_named(text, message):
    with pytest.raises(UnknownChoice) as error:
        Pipeline.parse(text)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[[step]", "no TOML"),
        (b"\xff\xfe", "no TOML"),
        (b"step = 3", "must hold a table"),
        (b'other = 1\n[[step]]\nname = "refine"', "must hold a table"),
        (b"[[step]]\nedge = 1.0", "has no name"),
    ],
)
def test_wrong_toml_is_named(tmp_path, content, message):
    path = tmp_path / "clean.toml"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message):
        Pipeline.read(path)
    with pytest.raises(FormatError, match="cannot be read"):
        Pipeline.read(tmp_path / "none.toml")


def test_a_truth_value_is_no_number():
    with pytest.raises(UnknownChoice, match="type float"):
        Pipeline([("refine", {"edge": True})])


def test_the_map_goes_through_all_steps():
    """A soup merged, a crumb dropped, simplified: each vertex of the soup comes near where it was."""
    given = joined(soup(FINE), Mesh([[5, 0, 0], [5.1, 0, 0], [5, 0.1, 0]], [[0, 1, 2]]))
    result = Pipeline.parse("merge_close,keep_components,simplify:target_faces=400")(given)
    assert (result.vertex_map.indices[-3:] == -1).all()
    assert result.mesh.genus == 1
    there = result.mesh.vertices[result.vertex_map.indices[:-3]]
    start, end = result.mesh.vertices[result.mesh.edges].transpose(1, 0, 2)
    # taken in by a corner of a triangle over it
    assert np.linalg.norm(there - given.vertices[:-3], axis=1).max() < 1.5 * np.linalg.norm(end - start, axis=1).max()
    report = result.report
    assert report["pipeline"] == "merge_close,keep_components,simplify:target_faces=400"
    assert [step["step"] for step in report["steps"]] == ["merge_close", "keep_components", "simplify"]
    assert report["steps"][2]["options"] == {"target_faces": 400}
    assert json.loads(json.dumps(report)) == report


@pytest.mark.parametrize("name", sorted(set(PIPELINES) - {"cad"}))
def test_presets_keep_a_sound_shape(name):
    result = PIPELINES[name](FINE)
    assert result.mesh.genus == 1
    assert distance_between(FINE, result.mesh) < 0.01
    assert (result.vertex_map.indices >= 0).all()


def test_a_scan_of_few_faces_is_not_smoothed_away():
    """Rounds of smoothing count in edges: of long ones they would take off the shape itself."""
    given = torus(1.0, 0.4, 9, 5)
    start, end = given.vertices[given.edges].transpose(1, 0, 2)
    assert np.linalg.norm(end - start, axis=1).max() > 0.2 * given.diagonal
    assert distance_between(given, PIPELINES["scan"](given).mesh) < 0.02


@pytest.mark.parametrize("name", ["tripod", "spiked_ring"])
def test_a_scan_has_the_skeleton_of_the_shape_within_the_limits(name):
    mesh = make(name, n_vertices=3000).mesh
    skeleton = skeletonize(scanned(mesh), preprocess="scan")
    found = from_clean(skeleton, skeletonize(mesh), mesh.diagonal)
    assert found["the same within the limits"], found


def test_simplifying_by_error_keeps_to_it():
    mesh = sphere(4)
    result = simplify(mesh, error=0.01)
    assert len(result.mesh.faces) < 0.3 * len(mesh.faces)
    assert distance_between(mesh, result.mesh) <= 0.01


def test_what_one_program_cannot_simplify_another_does(monkeypatch):
    monkeypatch.setattr("lbskel.preprocess.simplification.AGGRESSIVENESS", ())
    result = simplify(FINE, target_faces=600)
    assert "by libigl" in result.notes[0]
    assert result.mesh.genus == 1
    assert len(result.mesh.faces) <= 660
    assert hangs_together(FINE, result.vertex_map.indices)


# --- a surface meshed anew


def test_the_nearest_point_must_face_the_same_way():
    """Two walls nearer to each other than to the vertices of either."""
    slab = sphere(4)
    slab = slab.with_vertices(slab.vertices * [1, 1, 0.01])
    other = sphere(3)
    other = other.with_vertices(other.vertices * [1, 1, 0.01])
    result = transfer_map(slab, other)
    height = slab.vertices[:, 2]
    is_clear = np.abs(height) > 0.002
    assert (np.sign(other.vertices[result.vertex_map.indices, 2]) == np.sign(height))[is_clear].mean() > 0.99
    assert hangs_together(slab, result.vertex_map.indices)
    assert np.asarray(result.weights.sum(axis=1)).ravel() == pytest.approx(np.ones(len(slab.vertices)))


def test_remeshing_in_a_child():
    pytest.importorskip("pymeshlab")
    result = remesh_isotropic(FINE, edge=0.05, feature_angle=180.0)
    start, end = result.mesh.vertices[result.mesh.edges].transpose(1, 0, 2)
    assert np.linalg.norm(end - start, axis=1).mean() == pytest.approx(0.05 * FINE.diagonal, rel=0.1)
    assert result.mesh.genus == 1
    back = result.pull_back(np.array(result.mesh.vertices))
    # chords of 0.15 on a tube of radius 0.4 lie 0.15^2 / 3.2 below it
    assert np.linalg.norm(back - FINE.vertices, axis=1).max() < 3 * 0.15**2 / 3.2
    assert hangs_together(FINE, result.vertex_map.indices)


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (f"import os, signal; os.kill(os.getpid(), {int(signal.SIGSEGV)})", f"signal {int(signal.SIGSEGV)}"),
        ("import time; time.sleep(60)", "took more than 1 s"),
        ("raise ValueError('odd mesh')", "ValueError: odd mesh"),
        ("import os; os._exit(3)", "code 3"),
        ("import sys; sys.stdout.write('noise')", "answered nothing"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_whatever_becomes_of_the_child_the_caller_lives(tmp_path, monkeypatch, script, message):
    pytest.importorskip("pymeshlab")
    path = tmp_path / "child.py"
    path.write_text(f"import sys; sys.stdin.buffer.read()\n{script}\n")
    monkeypatch.setattr(children_module, "SCRIPT", path)
    with pytest.raises(MeshError, match=message):
        run_in_subprocess("remesh_isotropic", FINE, seconds=1.0 if "sleep" in script else 20.0, target_length=0.1)
    if "odd" in script:
        result = remesh_isotropic(FINE)
        assert result.mesh is FINE
        assert "the mesh was not remeshed" in result.notes[0]


# --- what is done unasked


def test_a_sound_mesh_is_prepared_by_nothing():
    for mesh in (FINE, chain_of_tori(2, step=0.1)):
        result = preprocess_mesh(mesh)
        assert result.mesh is mesh
        assert result.report == {"pipeline": "auto", "steps": []}


@pytest.mark.parametrize("how", [None, "none"])
def test_nothing_is_done_where_nothing_is_wanted(how):
    given = holed(FINE)
    assert preprocess_mesh(given, how).mesh is given


def test_holes_are_closed_and_a_coarse_mesh_refined():
    closed = preprocess_mesh(holed(FINE))
    assert closed.mesh.genus == 1
    assert [step["step"] for step in closed.report["steps"]] == ["close_holes"]
    fine = preprocess_mesh(torus(1.0, 0.1, 20, 5))
    assert [step["step"] for step in fine.report["steps"]] == ["refine"]


def test_vertices_in_the_middle_of_edges_are_joined_to_them():
    V, F = FINE.vertices.tolist(), FINE.faces.tolist()
    for face in range(0, 200, 20):
        a, b, c = F[face]
        V.append(((FINE.vertices[a] + FINE.vertices[b]) / 2).tolist())
        F[face] = [len(V) - 1, b, c]
        F.append([a, len(V) - 1, c])
    result = preprocess_mesh(Mesh(V, F))
    assert result.mesh.genus == 1
    assert result.mesh.area == pytest.approx(FINE.area)
    assert result.mesh.face_areas.min() > 0.1 * FINE.face_areas.min()


def test_a_sheet_stays_open_and_crumbs_around_holes_go(rod):
    assert preprocess_mesh(flat_grid()).mesh.is_closed is False
    given = joined(holed(FINE), Mesh([[5, 0, 0], [5.1, 0, 0], [5, 0.1, 0]], [[0, 1, 2]]))
    result = preprocess_mesh(given)
    assert (result.mesh.n_components, result.mesh.genus) == (1, 1)
    assert (result.vertex_map.indices[-3:] == -1).all()


def test_coordinates_that_overflow_are_named():
    for scale in (1e76, 1e300):
        with pytest.raises(MeshError, match=r"vertex \d+ are as large as .* scale the mesh down"):
            skeletonize(FINE.with_vertices(scale * FINE.vertices))
    assert skeletonize(Mesh(1e70 * torus(1.0, 0.4, 16, 10).vertices, torus(1.0, 0.4, 16, 10).faces)).cycle_rank == 1


def test_a_skeleton_through_a_pipeline_is_mapped_from_the_given_mesh(tmp_path):
    mesh = capsule(3.0, 0.4, 20)
    skeleton = skeletonize(mesh, preprocess="simplify:target_faces=600")
    assert len(skeleton.node_of_vertex) == len(mesh.vertices)
    near = np.linalg.norm(skeleton.nodes[skeleton.node_of_vertex] - mesh.vertices, axis=1)
    assert near.max() < 1.5 * 0.4
    assert skeleton.report["preprocess"]["pipeline"] == "simplify:target_faces=600"
    again = skeletonize(mesh, preprocess=Pipeline.parse(skeleton.report["preprocess"]["pipeline"]))
    assert np.array_equal(again.nodes, skeleton.nodes)
    with pytest.raises(UnknownChoice, match="a Pipeline, a name or None"):
        skeletonize(mesh, preprocess=3)


# --- the check


def test_a_sound_mesh_has_no_findings():
    report = check(FINE)
    assert report.findings == ()
    assert report.is_advised
    assert report.genera == (1,)
    assert report.volume == pytest.approx(FINE.volume)
    assert json.loads(json.dumps(report.as_dict()))["faces"] == len(FINE.faces)


FAULTS = {
    "duplicate_vertices": (
        lambda m: Mesh(m.vertices[m.faces].reshape(-1, 3), np.arange(3 * len(m.faces)).reshape(-1, 3)),
        4800,
    ),
    "duplicate_faces": (lambda m: Mesh(m.vertices, [*m.faces, *m.faces[:4, ::-1]]), 4),
    "repeated_corners": (lambda m: Mesh(m.vertices, [*m.faces, [0, 0, 1]]), 1),
    "unreferenced_vertices": (lambda m: Mesh([*m.vertices, [9, 9, 9], [8, 8, 8]], m.faces), 2),
    "boundary_loops": (lambda m: Mesh(m.vertices, np.delete(m.faces, [0, 500], axis=0)), 2),
    "nonmanifold_edges": (lambda m: Mesh([*m.vertices, [0, 0, 1]], [*m.faces, [*m.faces[0, :2], len(m.vertices)]]), 1),
    "misoriented_edges": (lambda m: Mesh(m.vertices, [m.faces[0, ::-1], *m.faces[1:]]), 3),
    "is_inside_out": (lambda m: Mesh(m.vertices, m.faces[:, ::-1]), True),
    "zero_area_faces": (lambda m: Mesh([*m.vertices, m.vertices[0]], [*m.faces, [0, 1, len(m.vertices)]]), 1),
    "sheets": (lambda m: flat_grid(), 1),
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_counted_and_told(name):
    spoil, count = FAULTS[name]
    report = check(spoil(FINE))
    assert getattr(report, name) == count
    assert report.findings
    assert report.is_advised is (name != "sheets")


def test_faces_that_cut_through_others_are_found():
    apart = joined(FINE, moved(FINE, 3.0))
    assert check(apart).crossing_faces == 0
    crossing = check(joined(FINE, moved(FINE, 1.5)))
    assert 50 < crossing.crossing_faces < 800
    assert crossing.crossings_tested == 1.0


def test_what_is_not_advised():
    V = np.random.default_rng(0).normal(size=(300, 3))
    assert check(Mesh(V, np.arange(300).reshape(-1, 3))).is_advised is False
    assert check(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])).is_advised is False


# --- on the command line


def test_check_and_preprocess_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_mesh("ring.ply", holed(FINE))
    write_mesh("sheet.ply", flat_grid())
    assert main(["check", "ring.ply"]) == 0
    assert "1 hole: it is closed" in capsys.readouterr().out
    assert main(["check", "sheet.ply"]) == 1
    assert "not advised" in capsys.readouterr().out
    assert main(["check", "ring.ply", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["boundary_loops"] == 1

    (tmp_path / "clean.toml").write_text('[[step]]\nname = "close_holes"\n')
    arguments = ["preprocess", "ring.ply", "-o", "out.obj", "--map", "map.npy", "--report", "report.json"]
    assert main([*arguments, "--pipeline", "clean.toml"]) == 0
    assert read_mesh("out.obj").genus == 1
    assert np.load("map.npy").tolist() == list(range(len(FINE.vertices)))
    assert json.loads((tmp_path / "report.json").read_text())["pipeline"] == "close_holes"
    assert main(arguments) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*arguments, "--force", "--steps", "close_holes,simplify:target_faces=200"]) == 0
    assert len(read_mesh("out.obj").faces) <= 220
    capsys.readouterr()
    assert main([*arguments, "--force", "--steps", "polish"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_preparing_is_chosen_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_mesh("pipe.ply", cylinder(0.3, 3.0, 12, 16))
    assert main(["skeletonize", "pipe.ply", "-o", "a.json", "--preprocess", "none", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["preprocess"] == {}
    assert main(["skeletonize", "pipe.ply", "-o", "b.json", "--json"]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["preprocess"]["steps"][0]["step"] == "close_holes"
