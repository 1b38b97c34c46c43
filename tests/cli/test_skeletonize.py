"""``lbskel skeletonize``: files, report, picture, options and exit codes."""

import json
import os
import re
import shlex
import struct
import subprocess
import sys

import numpy as np
import pytest
from helpers import file_names, joined, moved

import lbskel
from lbskel import read_skeleton, write_mesh
from lbskel.cli.skeletonize import _edits
from lbskel.io import FORMATS
from lbskel.shapes import capsule, torus, with_local_noise

GIVEN = ["pipe.ply", "ring.obj", "rod.off"]


# --- in a process of its own


def test_a_skeleton_with_picture_and_report(apart, folder):
    code, out, err = apart("skeletonize", "rod.off", "-o", "rod.swc", "--picture", "rod.png", "--report", "rod.json")
    assert (code, err) == (0, [])
    assert out[0] == "rod.off: 152 vertices, 300 faces, 1 component"
    assert re.fullmatch(r"  skeleton  \d+ nodes, 2 tips, 0 junctions, 0 cycles, inscribed radii", out[1])
    assert re.fullmatch(r"  component 300 faces, genus 0: 0 cycles; \d+ steps, the volume .*", out[2])
    assert re.fullmatch(r"  wrote     rod\.swc in \d+\.\d s", out[-1])
    assert len(read_skeleton(folder / "rod.swc").tips) == 2
    assert (folder / "rod.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((folder / "rod.json").read_text())["passed"] is True
    assert file_names(folder) == sorted([*GIVEN, "rod.swc", "rod.png", "rod.json"])


def test_json_is_one_line_per_input_on_a_closed_and_an_open_mesh(here, folder):
    code, out, err = here("skeletonize", "ring.obj", "pipe.ply", "-o", ".", "--json")
    assert (code, err) == (0, [])
    reports = [json.loads(line, parse_constant=pytest.fail) for line in out]
    assert [report["mesh"] for report in reports] == ["ring.obj", "pipe.ply"]
    assert [report["components"][0]["genus"] for report in reports] == [1, 0]  # the ends of the pipe were closed
    assert file_names(folder) == sorted([*GIVEN, "ring.swc", "pipe.swc"])


def test_one_bad_input_does_not_stop_the_others(here, folder):
    (folder / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n")
    code, out, err = here("skeletonize", "bad.off", "nosuch.ply", "rod.off", "-o", ".", "--quiet")
    assert (code, out) == (2, [])
    assert [line.split(":")[:2] for line in err] == [["lbskel", " bad.off"], ["lbskel", " nosuch.ply"]]
    assert file_names(folder) == sorted([*GIVEN, "bad.off", "rod.swc"])


@pytest.mark.parametrize("error", [MemoryError(), RuntimeError("a bug"), OSError(28, "No space left on device")])
def test_an_error_that_is_not_of_lbskel_does_not_stop_the_others(error, here, folder, monkeypatch):
    results = iter([error, lbskel.skeletonize(folder / "rod.off")])

    def next_result(*_, **__):
        if isinstance(result := next(results), Exception):
            raise result
        return result

    monkeypatch.setattr("lbskel.cli.skeletonize.skeletonize", next_result)
    (folder / "first.off").write_bytes((folder / "rod.off").read_bytes())
    code, out, err = here("skeletonize", "first.off", "rod.off", "-o", ".", "--quiet")
    assert (code, out, len(err)) == (2, [], 1)
    assert err[0].startswith("lbskel: first.off: ")
    assert file_names(folder) == sorted([*GIVEN, "first.off", "rod.swc"])


def test_a_result_that_fails_its_score_exits_with_one(folder, python):
    options = ("skeletonize", "rod.off", "-o", "rod.json", "--time-limit", "1e-9")
    result = python("-m", "lbskel", *options, cwd=folder)
    assert (result.returncode, result.stderr) == (1, "")
    assert "  score     fail: " in result.stdout
    view = "  next      lbskel view rod.off --skeleton rod.json -o rod.html shows where; lbskel check rod.off tells"
    assert f"{view} whether the mesh is why\n" in result.stdout
    assert read_skeleton(folder / "rod.json").report["passed"] is False


def test_commands_that_are_named_can_be_copied_whatever_the_names_of_files(here, folder):
    (folder / "rod.off").rename(folder / "a rod.off")
    code, out, _ = here("skeletonize", "a rod.off", "-o", "it's.json", "--time-limit", "1e-9")
    [line] = [line for line in out if line.startswith("  next      lbskel view")]
    view = shlex.split(line.split(" shows where")[0])[2:]
    assert (code, view) == (1, ["view", "a rod.off", "--skeleton", "it's.json", "-o", "it's.html"])
    assert here(*view)[0] == 0
    assert "; lbskel check 'a rod.off' tells" in line


def test_a_rough_surface_whose_skeleton_warns_names_the_pipeline_of_scans(here, folder):
    line = "  next      the surface is rough: --preprocess scan refines and smooths it in another way"
    rod = capsule(6.0, 0.5, 40)
    for noise, verdict in ((1.0, "pass"), (2.0, "warn")):  # in edges; both are smoothed
        write_mesh(folder / "rough.off", with_local_noise(rod, noise), force=True)
        _, out, _ = here("skeletonize", "rough.off", "-o", "rough.json", "--force")
        assert "  note      noise was smoothed by 60 iterations" in out
        assert [text[12:16] for text in out if text.startswith("  score")] == [verdict]
        assert (line in out) == (verdict == "warn")
    _, out, _ = here("skeletonize", "rough.off", "-o", "rough.json", "--force", "--preprocess", "none")
    assert line not in out


def test_all_is_refused_before_any_work(here, folder):
    """One of three outputs is there already: not one of the inputs is begun."""
    (folder / "ring.json").touch()
    code, out, err = here("skeletonize", "rod.off", "ring.obj", "-o", ".", "--report", ".")
    assert (code, out, err) == (2, [], ["lbskel: ring.json exists already; give --force to replace it"])
    assert file_names(folder) == sorted([*GIVEN, "ring.json"])


def test_a_file_of_edges_that_exists_is_refused_before_any_work(here, folder):
    """csv has two files; the picture must not be missing after minutes because the second could not be written."""
    (folder / "rod_edges.csv").touch()
    code, out, err = here("skeletonize", "nosuch.off", "-o", "rod.csv")
    assert (code, out, err) == (2, [], ["lbskel: rod_edges.csv exists already; give --force to replace it"])


def test_no_output_takes_the_place_of_an_input(here, folder):
    inputs = {"skeletonize": "pipe.ply", "segment": "pipe.ply", "rig": "pipe.glb", "branches": "pipe.json"}
    for command, name in inputs.items():
        (folder / name).touch()
        before = (folder / name).read_bytes()
        given = ["pipe.ply", "--skeleton", name] if command == "branches" else [name]
        expected = f"lbskel: {name}: is an input, and would be lost; give the output another name"
        assert here(command, *given, "-o", name, "--force") == (2, [], [expected])
        assert (folder / name).read_bytes() == before


def test_a_folder_named_with_a_slash_is_made(here, folder):
    arguments = ["skeletonize", "rod.off", "ring.obj", "-o", "new/", "--report", "told/", "--quiet"]
    assert here(*arguments) == (0, [], [])
    assert file_names(folder / "new") == ["ring.swc", "rod.swc"]
    assert file_names(folder / "told") == ["ring.json", "rod.json"]
    assert here("skeletonize", "rod.off", "-o", "one/", "--quiet") == (0, [], [])
    assert file_names(folder / "one") == ["rod.swc"]
    code, _, err = here("skeletonize", "rod.off", "-o", "no/where/")
    assert (code, err) == (2, ["lbskel: no/where/: the folder cannot be made: No such file or directory; name another"])


def test_nothing_is_overwritten_unasked(here, folder):
    (folder / "rod.swc").write_text("mine")
    code, out, err = here("skeletonize", "rod.off", "-o", "rod.swc")
    assert (code, out, err) == (2, [], ["lbskel: rod.swc exists already; give --force to replace it"])
    assert (folder / "rod.swc").read_text() == "mine"


def test_force_replaces(here, folder):
    for name in ("rod.swc", "rod.png", "rod.json"):
        (folder / name).write_text("mine")
    arguments = ["skeletonize", "rod.off", "-o", "rod.swc", "--picture", "rod.png", "--report", "rod.json", "--quiet"]
    assert here(*arguments)[0] == 2
    assert here(*arguments, "--force") == (0, [], [])
    assert all((folder / name).read_bytes()[:4] != b"mine" for name in ("rod.swc", "rod.png", "rod.json"))


def test_nothing_is_lost_of_cycles_in_swc_and_the_cut_is_told(here, folder):
    options = ("--picture", "ring.png", "--report", "ring-report.json")
    code, out, err = here("skeletonize", "ring.obj", "-o", "ring.swc", *options)
    assert (code, err) == (0, [])
    [note] = [line for line in out if "1 cycle cut" in line]
    assert re.match(
        r"  note      1 cycle cut where the skeleton is thinnest \(radius 0\.\d+, in the units of the mesh\), since",
        note,
    )
    assert read_skeleton(folder / "ring.swc").cycle_rank == 1
    assert json.loads((folder / "ring-report.json").read_text())["notes"][-1] in note
    assert (folder / "ring.png").exists()


def test_loops_that_are_opened_and_gaps_that_are_closed_are_told(here, rod):
    """A ring whose loop is shorter than 60 radii, and two rods, one behind the other."""
    write_mesh("rods.off", joined(rod, rod.with_vertices(rod.vertices + [0, 0, np.ptp(rod.vertices[:, 2]) + 0.6])))
    gap = "by edges of at most {} in the units of the mesh; --join none keeps them"
    for name, note in (
        ("ring.obj", "1 short loop was opened; --min-loop 0 keeps them"),
        ("rods.off", rf"1 gap was closed between components, {gap.format('[0-9.]+')}"),
    ):
        out = here("skeletonize", name, "-o", "a.json", "--preset", "neuron", "--force")[1]
        [told] = [line for line in out if line.startswith("  note      1")]
        assert re.fullmatch(f"  note      {note}", told)
        more = ("--min-loop", "0", "--join", "none", "--force")
        out = here("skeletonize", name, "-o", "a.json", "--preset", "neuron", *more)[1]
        assert not any(line.startswith("  note      1") for line in out)


def test_the_longest_gap_is_told_only_if_all_are_known():
    """Those that were closed where the points of a cloud go on are not listed."""
    edge = [[0, 0, 0], [0, 0, 2]]
    for n_joined, told in ((1, "1 gap was closed between components, by edges of at most 2 in"), (2, "components; --")):
        [note] = _edits({"loops_opened": 0, "pieces_joined": n_joined, "joining_edges": [edge]})
        assert told in note


def test_a_scale_and_units_are_those_of_the_file_and_not_of_the_skeleton(here, folder):
    assert here("skeletonize", "rod.off", "-o", "a.swc", "--scale", "1000", "--units", "um", "--quiet") == (0, [], [])
    assert here("skeletonize", "rod.off", "-o", "b.swc", "--quiet") == (0, [], [])
    rows = [np.loadtxt(folder / name)[:, 2:6] for name in ("a.swc", "b.swc")]
    np.testing.assert_allclose(rows[0], 1000 * rows[1], rtol=1e-15)  # one rounding
    assert '"units": "um"' in (folder / "a.swc").read_text()
    for options, message in (
        (("-o", "c.json", "--units", "um"), "write swc, in a batch by --format swc"),
        (("-o", "c.swc", "--scale", "0"), "positive number"),
    ):
        for command in ("skeletonize", "batch"):
            given = ("-o", "out", "--format", options[1][2:], *options[2:]) if command == "batch" else options
            code, out, err = here(command, "rod.off", *given)
            assert (code, out, len(err)) == (2, [], 1)
            assert message in err[0]
    assert file_names(folder) == sorted([*GIVEN, "a.swc", "b.swc"])


@pytest.mark.parametrize("name", FORMATS)
def test_a_tree_is_one_in_every_format(name, here, folder):
    code, out, err = here("skeletonize", "ring.obj", "-o", f"tree.{name}", "--tree")
    assert (code, err) == (0, [])
    assert [line for line in out if "1 cycle cut" in line and "a tree is asked for" in line]
    skeleton = read_skeleton(folder / f"tree.{name}")
    assert (skeleton.cycle_rank, skeleton.n_components, len(skeleton.tips)) == (0, 1, 2)


@pytest.mark.parametrize(
    ("package", "options"), [("networkx", ["-o", "a.graphml"]), ("matplotlib", ["-o", "a.swc", "--picture", "a.png"])]
)
@pytest.mark.parametrize("command", ["skeletonize", "batch"])
def test_a_missing_package_is_told_before_any_work(command, package, options, here, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setattr("lbskel.cli.skeletonize.as_shape", lambda _: pytest.fail("work was begun"))
    if command == "batch":
        options = ["-o", "out", *(["--format", "graphml"] if package == "networkx" else ["--picture"])]
    code, out, err = here(command, "rod.off", *options)
    assert (code, out, len(err)) == (2, [], 1)
    assert f"needs {package}, which is not installed" in err[0]
    assert file_names(folder) == GIVEN


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_written(name, here, folder):
    assert here("skeletonize", "rod.off", "-o", f"rod-skeleton.{name}", "--quiet") == (0, [], [])
    back = read_skeleton(folder / f"rod-skeleton.{name}")
    assert (len(back.tips), back.cycle_rank) == (2, 0)


def test_several_into_a_folder_with_pictures_and_reports(here, folder):
    for name in ("skeletons", "pictures", "reports"):
        (folder / name).mkdir()
    code, out, err = here(
        *["skeletonize", "rod.off", "pipe.ply", "-o", "skeletons", "--picture", "pictures", "--report", "reports"]
    )
    assert (code, err) == (0, [])
    assert sum(not line.startswith(" ") for line in out) == 2
    for name, suffix in (("skeletons", ".swc"), ("pictures", ".png"), ("reports", ".json")):
        assert file_names(folder / name) == [f"pipe{suffix}", f"rod{suffix}"]


def test_choices_reach_the_contraction(here):
    choices = ["--preset", "least_squares", "--operator", "robust", "--energy", "curvature_flow", "--solver", "superlu"]
    code, out, err = here("skeletonize", "rod.off", "-o", "rod.json", "--json", *choices)
    assert (code, err) == (0, [])
    settings = json.loads(out[0])["settings"]
    assert (settings["operator"], settings["energy"], settings["solver"]) == ("robust", "curvature_flow", "superlu")


def test_failed_measures_are_named_and_the_result_is_written(here, folder):
    code, out, err = here("skeletonize", "rod.off", "-o", "rod.swc", "--time-limit", "1e-9")
    assert (code, err) == (1, [])
    assert any(line.startswith("  score     fail: ") and "near_surface_fraction" in line for line in out)
    assert (folder / "rod.swc").exists()


@pytest.mark.parametrize("end", ["lowest", "highest"])  # one of them is the root without being asked for
def test_knobs(end, here, folder, rod):
    heights = rod.vertices[:, 2]
    root = int(heights.argmin() if end == "lowest" else heights.argmax())
    options = (
        "--root",
        str(root),
        "--anchor",
        "0,0,0.5",
        "--nodes",
        "9",
        "--tip-position",
        "surface",
        "--min-branch-ratio",
        "2",
    )
    assert here("skeletonize", "rod.off", "-o", "rod.json", *options)[0] == 0
    skeleton = read_skeleton(folder / "rod.json")
    assert (len(skeleton.nodes), len(skeleton.anchors)) == (9, 1)
    assert skeleton.node_of_vertex[root] == 0  # the root is the first node
    assert here("skeletonize", "rod.off", "-o", "rod.json", "--force", "--anchor", "99999")[0] == 2


def test_the_worst_exit_code_counts(here):
    assert here("skeletonize", "rod.off", "pipe.ply", "-o", ".", "--quiet", "--time-limit", "1e-9")[0] == 1
    assert here("skeletonize", "rod.off", "nosuch.off", "-o", ".", "--quiet", "--force")[0] == 2


def test_the_graphs_of_several_components_are_joined_where_that_is_asked(here, folder, rod):
    apart = rod.with_vertices(rod.vertices + [2.0, 0.0, 0.0])
    vertices = np.concatenate([rod.vertices, apart.vertices])
    faces = np.concatenate([rod.faces, rod.faces + len(rod.vertices)])
    write_mesh(folder / "two.off", lbskel.Mesh(vertices, faces))
    for options, n_components in (((), 2), (("--force", "--join"), 1), (("--force", "--join", "none"), 2)):
        assert here("skeletonize", "two.off", "-o", "two.json", *options)[0] == 0
        assert read_skeleton(folder / "two.json").n_components == n_components


def test_crumbs_share_one_line_of_the_summary(here, folder, rod, tetrahedron):
    fine = capsule(3.0, 0.4, 16)  # of more than 600 faces, so that 4 are less than a hundredth
    small = tetrahedron.with_vertices(0.2 * tetrahedron.vertices)  # else most of the area is coarse, and refined
    write_mesh(folder / "crumbs.off", joined(fine, *(moved(small, 3.0 + 2 * i) for i in range(12))))
    _, out, err = here("skeletonize", "crumbs.off", "-o", "crumbs.json")
    assert err == []
    large, crumbs = [line for line in out if line.startswith("  component ")]
    assert large.startswith(f"  component {len(fine.faces):,} faces, genus 0")
    assert crumbs == "  component 12 more of 48 faces together"


@pytest.mark.skipif(os.name == "nt", reason="no pseudo-terminals")
def test_a_terminal_is_told_the_stage_and_left_clean(folder):
    import fcntl
    import pty
    import termios

    program = "from lbskel.cli import main, terminal; terminal.PATIENCE = 0.0; raise SystemExit(main.main())"
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    process = subprocess.Popen(
        [sys.executable, "-c", program, "skeletonize", "rod.off", "-o", "rod.json"],
        stdout=subprocess.PIPE,
        stderr=theirs,
        cwd=folder,
    )
    os.close(theirs)
    shown = b""
    while True:
        try:
            piece = os.read(ours, 4096)
        except OSError:  # Linux: the other side is closed
            break
        if not piece:
            break
        shown += piece
    os.close(ours)
    assert process.wait() == 0
    process.stdout.close()
    assert b"rod.off: contract" in shown
    assert shown.endswith(b"\r")
    assert shown.split(b"\r")[-2].strip() == b""


# --- in this process


def test_a_point_cloud_with_report_and_picture(here, folder):
    np.savetxt(folder / "cloud.xyz", torus(1.0, 0.3).vertices)
    code, out, err = here("skeletonize", "cloud.xyz", "-o", "ring.json", "--picture", "ring.png", "--report", "r.json")
    assert (code, err) == (0, [])
    assert out[0].startswith("cloud.xyz: 1,152 points, ")
    skeleton = read_skeleton(folder / "ring.json")
    assert (skeleton.cycle_rank, len(skeleton.node_of_vertex)) == (1, 1152)
    assert json.loads((folder / "r.json").read_text())["reconstruction"]["points"] == 1152
    assert (folder / "ring.png").stat().st_size > 1000
