"""The command line: what it writes, prints and exits with; every failure is one line and never a traceback."""

import json
import os
import re
import struct
import subprocess
import sys

import numpy as np
import pytest

import lbskel
from lbskel import read_skeleton, write_mesh
from lbskel.cli.main import main
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import PRESETS
from lbskel.io import FORMATS
from lbskel.shapes import cylinder
from lbskel.solvers import SOLVERS


@pytest.fixture
def folder(tmp_path, monkeypatch, rod, ring):
    """A folder to work in, with a rod, a ring and an open pipe."""
    monkeypatch.chdir(tmp_path)
    write_mesh("rod.off", rod)
    write_mesh("ring.obj", ring)
    write_mesh("pipe.ply", cylinder(0.3, 3.0, 12, 12))
    return tmp_path


@pytest.fixture
def here(folder, capfd):
    """Run a command in this process: its exit code, and the lines that it left on stdout and stderr."""

    def run(*arguments):
        capfd.readouterr()
        try:
            code = main(list(arguments))
        except SystemExit as error:
            code = error.code
        out, err = capfd.readouterr()
        return code, out.splitlines(), err.splitlines()

    return run


@pytest.fixture
def apart(folder, python):
    """Run a command in a process of its own."""

    def run(*arguments, **environment):
        result = python("-m", "lbskel", *arguments, cwd=folder, **environment)
        return result.returncode, result.stdout.splitlines(), result.stderr.splitlines()

    return run


def names(folder):
    return sorted(path.name for path in folder.iterdir())


GIVEN = ["pipe.ply", "ring.obj", "rod.off"]


# --- in a process of its own


def test_a_skeleton_with_picture_and_report(apart, folder):
    code, out, err = apart("skeletonize", "rod.off", "-o", "rod.swc", "--picture", "rod.png", "--report", "rod.json")
    assert (code, err) == (0, [])
    assert out[0] == "rod.off: 152 vertices, 300 faces, 1 component(s)"
    assert re.fullmatch(r"  skeleton  \d+ nodes, 2 tips, 0 junctions, 0 cycles, inscribed radii", out[1])
    assert re.fullmatch(r"  component 300 faces, genus 0: 0 cycles; \d+ steps, the volume .*", out[2])
    assert re.fullmatch(r"  wrote     rod\.swc in \d+\.\d s", out[-1])
    assert len(read_skeleton(folder / "rod.swc").tips) == 2
    assert (folder / "rod.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((folder / "rod.json").read_text())["passed"] is True
    assert names(folder) == sorted([*GIVEN, "rod.swc", "rod.png", "rod.json"])


def test_json_is_one_line_per_input_on_a_closed_and_an_open_mesh(apart, folder):
    code, out, err = apart("skeletonize", "ring.obj", "pipe.ply", "-o", ".", "--json", "--cut-cycles")
    assert (code, err) == (0, [])
    reports = [json.loads(line, parse_constant=pytest.fail) for line in out]
    assert [report["mesh"] for report in reports] == ["ring.obj", "pipe.ply"]
    assert [report["components"][0]["genus"] for report in reports] == [1, 0]  # the ends of the pipe were closed
    assert names(folder) == sorted([*GIVEN, "ring.swc", "pipe.swc"])


def test_one_bad_input_does_not_stop_the_others(apart, folder):
    (folder / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n")
    code, out, err = apart("skeletonize", "bad.off", "nosuch.ply", "rod.off", "-o", ".", "--quiet")
    assert (code, out) == (2, [])
    assert [line.split(":")[:2] for line in err] == [["lbskel", " bad.off"], ["lbskel", " nosuch.ply"]]
    assert names(folder) == sorted([*GIVEN, "bad.off", "rod.swc"])


def test_a_result_that_fails_its_score_exits_with_one(folder, python):
    options = ("skeletonize", "rod.off", "-o", "rod.json", "--time-limit", "1e-9")
    result = python("-m", "lbskel", *options, cwd=folder)
    assert (result.returncode, result.stderr) == (1, "")
    assert "  score     fail: " in result.stdout
    assert read_skeleton(folder / "rod.json").report["passed"] is False


def test_wrong_usage_is_told_in_one_line(apart):
    code, out, err = apart("skeletonize", "rod.off", "-o", "rod.swc", "--preset", "nosuch")
    assert (code, out, len(err)) == (2, [], 1)
    assert re.match(
        r"lbskel: argument --preset: invalid choice: 'nosuch' \(choose from .*curvature_flow.*au2008", err[0]
    )
    assert err[0].endswith("; see lbskel skeletonize --help")


def test_a_reader_that_goes_away_is_no_failure(folder):
    process = subprocess.Popen(
        [sys.executable, "-m", "lbskel", "info", "rod.off"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder
    )
    process.stdout.close()
    assert (process.stderr.read(), process.wait(timeout=60)) == (b"", 0)
    process.stderr.close()


def test_a_name_that_the_terminal_cannot_show_is_no_failure(apart, folder, rod):
    write_mesh(folder / "棒.off", rod)
    code, out, err = apart("skeletonize", "棒.off", "-o", "bar.json", PYTHONIOENCODING="ascii")
    assert (code, err) == (0, [])
    assert out[0].startswith("\\u68d2.off: 152 vertices")


@pytest.mark.skipif(os.name == "nt", reason="no pseudo-terminals")
def test_a_terminal_is_told_the_stage_and_left_clean(folder):
    import fcntl
    import pty
    import termios

    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    process = subprocess.Popen(
        [sys.executable, "-m", "lbskel", "skeletonize", "rod.off", "-o", "rod.json"],
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
    assert process.wait(timeout=60) == 0
    process.stdout.close()
    assert b"rod.off: contract" in shown
    assert shown.endswith(b"\r")
    assert shown.split(b"\r")[-2].strip() == b""


# --- in this process


def test_without_arguments_and_with_help(here):
    code, out, err = here()
    assert (code, out, err) == (2, [], ["lbskel: the following arguments are required: COMMAND; see lbskel --help"])
    code, out, err = here("nosuch")
    assert (code, out, len(err)) == (2, [], 1)
    assert "invalid choice: 'nosuch'" in err[0]
    assert here("--version") == (0, [f"lbskel {lbskel.__version__}"], [])
    code, out, err = here("--help")
    assert (code, err) == (0, [])
    assert any("skeletonize" in line for line in out)


def test_help_lists_every_choice(here):
    code, out, err = here("skeletonize", "--help")
    assert (code, err) == (0, [])
    text = re.sub(r"\s+", "", "".join(out))
    for table in (PRESETS, ENERGIES, SOLVERS):
        assert all(name in text for name in table)
    assert all(name in text for name in FORMATS)
    assert "`" not in text


BAD = {
    "no output": (["skeletonize", "rod.off"], r"required: -o/--output"),
    "no input": (["skeletonize", "-o", "a.swc"], r"required: MESH"),
    "unknown option": (["skeletonize", "rod.off", "-o", "a.swc", "--nosuch"], r"unrecognized arguments: --nosuch"),
    "unknown operator": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--operator", "x"],
        r"argument --operator.*cotangent",
    ),
    "unknown energy": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--energy", "x"],
        r"argument --energy.*curvature_flow",
    ),
    "unknown solver": (["skeletonize", "rod.off", "-o", "a.swc", "--solver", "x"], r"argument --solver.*cholmod"),
    "no such file": (["skeletonize", "a.off", "-o", "a.swc"], r"a\.off: no such file"),
    "unknown mesh format": (
        ["skeletonize", "rod.xyz", "-o", "a.swc"],
        r"rod\.xyz: unknown extension 'xyz'; known .*obj",
    ),
    "a folder as mesh": (["skeletonize", ".", "-o", "a.swc"], r"\.: is a folder"),
    "unknown skeleton format": (["skeletonize", "rod.off", "-o", "a.xyz"], r"a\.xyz: .* swc, json, npz"),
    "no format": (["skeletonize", "rod.off", "-o", "a"], r"a: .* swc, json, npz"),
    "a picture as skeleton": (["skeletonize", "rod.off", "-o", "a.png"], r"a\.png: .* swc, json, npz"),
    "a picture of another kind": (["skeletonize", "rod.off", "-o", "a.swc", "--picture", "a.jpg"], r"a\.jpg: .* png"),
    "a skeleton as picture": (["skeletonize", "rod.off", "-o", "a.swc", "--picture", "b.swc"], r"b\.swc: .* png"),
    "a report of another kind": (["skeletonize", "rod.off", "-o", "a.swc", "--report", "a.txt"], r"a\.txt: .* json"),
    "two outputs of one name": (["skeletonize", "rod.off", "-o", "a.json", "--report", "a.json"], r"the same name"),
    "one input twice": (["skeletonize", "rod.off", "rod.off", "-o", "."], r"the same name"),
    "missing folder": (["skeletonize", "rod.off", "-o", "no/a.swc"], r"no/a\.swc: the folder no does not exist"),
    "missing folder of a picture": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--picture", "no/a.png"],
        r"no/a\.png: the folder no does not exist",
    ),
    "several into a file": (["skeletonize", "rod.off", "ring.obj", "-o", "a.swc"], r"a\.swc is not a folder; several"),
    "several into nowhere": (["skeletonize", "rod.off", "ring.obj", "-o", "no"], r"no is not a folder; several"),
    "several pictures into a file": (
        ["skeletonize", "rod.off", "pipe.ply", "-o", ".", "--picture", "a.png"],
        r"a\.png is not a folder; several",
    ),
    "a name that is too long": (["skeletonize", "rod.off", "-o", 300 * "a" + ".swc"], r"aaa"),
    "cycles in swc": (["skeletonize", "ring.obj", "-o", "a.swc"], r"ring\.obj: a\.swc: .* 1 cycles .*--cut-cycles"),
    "one face": (["skeletonize", "face.obj", "-o", "a.swc"], r"face\.obj: no component of the mesh has 4 faces"),
    "not a number": (["skeletonize", "nan.obj", "-o", "a.swc"], r"nan\.obj: vertices 1 have NaN"),
    "text that is no mesh": (["info", "text.obj"], r"text\.obj: "),
    "bytes that are no mesh": (["info", "bytes.ply"], r"bytes\.ply: "),
    "no mesh of info": (["info"], r"required: MESH"),
    "no such mesh of info": (["info", "a.off"], r"a\.off: no such file"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_told_in_one_line_and_nothing_is_written(name, here, folder):
    (folder / "face.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "nan.obj").write_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "text.obj").write_text("It was a dark and stormy night.\n")
    (folder / "bytes.ply").write_bytes(bytes(range(256)))
    before = names(folder)
    arguments, message = BAD[name]
    code, out, err = here(*arguments)
    assert (code, out, len(err)) == (2, [], 1)
    assert err[0].startswith("lbskel: ")
    assert re.search(message, err[0])
    assert names(folder) == before


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (
            RuntimeError("one\ntwo"),
            2,
            r"internal error in test_main\.py line \d+, please report it: RuntimeError: one two",
        ),
        (MemoryError(), 2, "out of memory; simplify the mesh first"),
        (KeyboardInterrupt(), 130, "interrupted; no partial file is left"),
        (OSError(5, "Input/output error"), 2, r"\[Errno 5\] Input/output error"),
        (lbskel.SolveError("no\nsolution"), 2, "rod.off: no solution"),
        (lbskel.MissingDependency("p", "view", "it"), 2, r"rod\.off: it needs p.*pip install 'lbskel\[view\]'"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
def test_whatever_happens_is_told_in_one_line(error, code, message, here, folder, monkeypatch):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("lbskel.cli.skeletonize.skeletonize", fail)
    given_code, out, err = here("skeletonize", "rod.off", "-o", "a.swc")
    assert (given_code, out, len(err)) == (code, [], 1)
    assert re.fullmatch(f"lbskel: {message}", err[0])
    assert names(folder) == GIVEN


def test_all_is_refused_before_any_work(here, folder):
    """One of three outputs is there already: not one of the inputs is begun."""
    (folder / "ring.json").touch()
    code, out, err = here("skeletonize", "rod.off", "ring.obj", "-o", ".", "--report", ".", "--cut-cycles")
    assert (code, out, err) == (2, [], ["lbskel: ring.json exists already; give --force to replace it"])
    assert names(folder) == sorted([*GIVEN, "ring.json"])


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


def test_cycles_are_cut_on_request_and_noted(here, folder):
    assert here("skeletonize", "ring.obj", "-o", "ring.swc", "--cut-cycles", "--quiet") == (0, [], [])
    assert "# cut edge" in (folder / "ring.swc").read_text()
    assert read_skeleton(folder / "ring.swc").cycle_rank == 1


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
        assert names(folder / name) == [f"pipe{suffix}", f"rod{suffix}"]


def test_choices_reach_the_contraction(here):
    choices = ["--preset", "least_squares", "--operator", "robust", "--energy", "curvature_flow", "--solver", "superlu"]
    code, out, err = here("skeletonize", "rod.off", "-o", "rod.json", "--json", *choices)
    assert (code, err) == (0, [])
    settings = json.loads(out[0])["settings"]
    assert (settings["operator"], settings["energy"], settings["solver"]) == ("robust", "curvature_flow", "superlu")


def test_failed_measures_are_named_and_the_result_is_written(here, folder):
    code, out, err = here("skeletonize", "rod.off", "-o", "rod.swc", "--time-limit", "1e-9")
    assert (code, err) == (1, [])
    assert any(line.startswith("  score     fail: ") and "inside_fraction" in line for line in out)
    assert (folder / "rod.swc").exists()


def test_knobs(here, folder):
    options = (
        "--root",
        "0",
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
    assert here("skeletonize", "rod.off", "-o", "rod.json", "--force", "--anchor", "99999")[0] == 2


def test_the_worst_exit_code_counts(here):
    assert here("skeletonize", "rod.off", "pipe.ply", "-o", ".", "--quiet", "--time-limit", "1e-9")[0] == 1
    assert here("skeletonize", "rod.off", "nosuch.off", "-o", ".", "--quiet", "--force")[0] == 2


def test_info(here, rod):
    code, out, err = here("info", "rod.off")
    assert (code, err) == (0, [])
    facts = dict(re.split(r"\s{2,}", line, maxsplit=1) for line in out)
    assert facts["vertices"] == "152"
    assert facts["closed manifold"] == "yes"
    assert facts["genus"] == "0"
    assert float(facts["volume"]) == pytest.approx(rod.volume, rel=1e-5)  # six digits are printed
    assert facts["notes"] == "none"


def test_info_as_json_of_an_open_mesh_with_faults(here, folder):
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "v 2 0 0", "v 9 9 9", "f 1 2 3 4", "f 1 2 5"]
    (folder / "faults.obj").write_text("\n".join(lines) + "\n")
    code, out, err = here("info", "faults.obj", "--json")
    assert (code, err, len(out)) == (0, [], 1)
    facts = json.loads(out[0])
    assert facts["vertices"] == 6
    assert facts["faces"] == 3
    assert facts["closed_manifold"] is False
    assert (facts["genus"], facts["volume"]) == (None, None)
    assert facts["zero_area_faces"] == 1
    assert facts["unused_vertices"] == 1
    assert facts["area"] == pytest.approx(1.0)
    assert np.array(facts["bounding_box"]).tolist() == [[0, 0, 0], [9, 9, 9]]
    assert facts["notes"] == ["1 polygons were cut into triangles"]


def test_the_graphs_of_several_components_are_joined_where_that_is_asked(here, folder, rod):
    apart = rod.with_vertices(rod.vertices + [2.0, 0.0, 0.0])
    vertices = np.concatenate([rod.vertices, apart.vertices])
    faces = np.concatenate([rod.faces, rod.faces + len(rod.vertices)])
    write_mesh(folder / "two.off", lbskel.Mesh(vertices, faces))
    for options, n_components in (((), 2), (("--join", "--force"), 1)):
        assert here("skeletonize", "two.off", "-o", "two.json", *options)[0] == 0
        assert read_skeleton(folder / "two.json").n_components == n_components
