"""The command line as a whole: help, errors in one line, exit codes, streams."""

import re
import subprocess
import sys

import pytest
from helpers import file_names

import lbskel
from lbskel import write_mesh
from lbskel.cli.main import main
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import PRESETS
from lbskel.io import FORMATS
from lbskel.pipeline.environment import SLOW
from lbskel.solvers import SOLVERS

GIVEN = ["pipe.ply", "ring.obj", "rod.off"]


# --- in a process of its own


def test_wrong_usage_is_told_in_one_line(apart):
    code, out, err = apart("skeletonize", "rod.off", "-o", "rod.swc", "--preset", "nosuch")
    assert (code, out, len(err)) == (2, [], 1)
    assert re.match(
        r"lbskel: argument --preset: invalid choice: 'nosuch' \(choose from .*curvature_flow.*au2008", err[0]
    )
    assert err[0].endswith("; see lbskel skeletonize --help")


def test_a_slip_in_an_option_is_told_when_something_is_missing_too(here):
    """Before what is missing is given, as the first thing that a newcomer sees."""
    for arguments in (["skeletonize", "--presett", "neuron", "x.off"], ["skeletonize", "x.off", "--presett=neuron"]):
        code, _, [line] = here(*arguments)
        assert code == 2
        assert "required: -o/--output; unrecognized argument: --presett, did you mean '--preset'?; see" in line
    assert "unrecognized" not in here("skeletonize", "--pres", "neuron", "x.off")[2][0]


@pytest.mark.parametrize("arguments", [["info", "rod.off"], ["--print-completion", "zsh"]])
def test_a_reader_that_goes_away_is_no_failure(folder, arguments):
    if arguments[0] == "--print-completion":
        pytest.importorskip("shtab")
    process = subprocess.Popen(
        [sys.executable, "-m", "lbskel", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder
    )
    process.stdout.close()
    assert (process.stderr.read(), process.wait()) == (b"", 0)
    process.stderr.close()


@pytest.mark.parametrize("closed", [1, 2])
def test_a_stream_that_the_caller_has_closed_is_no_failure(folder, closed):
    """As in a job of a daemon: the file is written, and the exit code tells so."""
    code = (
        f"import os, sys; os.close({closed}); os.execv(sys.executable, [sys.executable, '-m', 'lbskel', *sys.argv[1:]])"
    )
    command = [sys.executable, "-c", code, "smooth", "rod.off", "-o", "smooth.off"]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert (result.returncode, result.stderr) == (0, "")
    assert (folder / "smooth.off").exists()


def test_a_name_that_the_terminal_cannot_show_is_no_failure(apart, folder, rod):
    write_mesh(folder / "棒.off", rod)
    code, out, err = apart("skeletonize", "棒.off", "-o", "bar.json", PYTHONIOENCODING="ascii")
    assert (code, err) == (0, [])
    assert out[0].startswith("\\u68d2.off: 152 vertices")


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


@pytest.mark.parametrize("is_slow", [True, False])
def test_kernels_that_are_not_compiled_are_told(folder, capfd, monkeypatch, is_slow):
    monkeypatch.setattr("lbskel.cli.main.are_kernels_compiled", lambda: not is_slow)
    assert main(["info", "rod.off"]) == 0
    assert capfd.readouterr().err == (f"lbskel: warning: {SLOW}\n" if is_slow else "")


def test_help_lists_every_choice(here):
    code, out, err = here("skeletonize", "--help")
    assert (code, err) == (0, [])
    text = re.sub(r"\s+", "", "".join(out))
    for table in (PRESETS, ENERGIES, SOLVERS):
        assert all(name in text for name in table)
    assert all(name in text for name in FORMATS)
    assert "`" not in text


def test_completions_are_those_of_the_parser(here, folder, monkeypatch):
    pytest.importorskip("shtab")
    code, out, err = here("--print-completion", "bash")
    assert (code, err) == (0, [])
    script = folder / "completion"
    script.write_text("\n".join(out))

    def completed(*words):
        line = f"source {script}; COMP_WORDS=(lbskel {' '.join(words)}); COMP_CWORD={len(words)}; _shtab_lbskel;"
        done = subprocess.run(["bash", "-c", line + 'echo "${COMPREPLY[@]}"'], capture_output=True, text=True)
        return done.stdout.split()

    assert completed("skel") == ["skeletonize"]
    assert completed("smooth", "--meth") == ["--method"]
    assert completed("skeletonize", "--solver", "cho") == ["cholmod"]
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert here("--print-completion", "bash")[2] == [
        "lbskel: --print-completion needs shtab, which is not installed: pip install 'lbskel[completion]'"
    ]


BAD = {
    "no output": (["skeletonize", "rod.off"], r"required: -o/--output"),
    "no input": (["skeletonize", "-o", "a.swc"], r"required: MESH"),
    "unknown option": (["skeletonize", "rod.off", "-o", "a.swc", "--nosuch"], r"unrecognized arguments: --nosuch"),
    "a slip in an option": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--opertor=robust"],
        r"--opertor=robust, did you mean '--operator'\?; see lbskel skeletonize --help",
    ),
    "a slip in a command": (["skeletonise", "rod.off"], r"'skeletonise', did you mean 'skeletonize'\? \(choose from"),
    "a slip in a name": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--operator", "cotangnet"],
        r"argument --operator: invalid choice: 'cotangnet', did you mean 'cotangent'\?",
    ),
    "unknown operator": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--operator", "x"],
        r"argument --operator.*cotangent",
    ),
    "unknown energy": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--energy", "x"],
        r"argument --energy.*curvature_flow",
    ),
    "unknown solver": (["skeletonize", "rod.off", "-o", "a.swc", "--solver", "x"], r"argument --solver.*cholmod"),
    "no such file": (["skeletonize", "a.off", "-o", "a.swc"], r"a\.off: no such file$"),
    "a slip in a file": (["skeletonize", "rodd.off", "-o", "a.swc"], r"no such file, did you mean 'rod\.off'\?"),
    "unknown mesh format": (
        ["skeletonize", "rod.doc", "-o", "a.swc"],
        r"rod\.doc: unknown extension 'doc'; known .*obj",
    ),
    "a folder as mesh": (["skeletonize", ".", "-o", "a.swc"], r"\.: is a folder"),
    "unknown skeleton format": (["skeletonize", "rod.off", "-o", "a.xyz"], r"a\.xyz: .* \.swc, \.json, \.npz"),
    "no format": (["skeletonize", "rod.off", "-o", "a"], r"a: .* \.swc, \.json, \.npz"),
    "a picture as skeleton": (["skeletonize", "rod.off", "-o", "a.png"], r"a\.png: .* \.swc, \.json, \.npz"),
    "a picture of another kind": (["skeletonize", "rod.off", "-o", "a.swc", "--picture", "a.jpg"], r"a\.jpg: .* \.png"),
    "a skeleton as picture": (["skeletonize", "rod.off", "-o", "a.swc", "--picture", "b.swc"], r"b\.swc: .* \.png"),
    "a report of another kind": (["skeletonize", "rod.off", "-o", "a.swc", "--report", "a.txt"], r"a\.txt: .* \.json"),
    "two outputs of one name": (
        ["skeletonize", "rod.off", "-o", "a.json", "--report", "a.json"],
        r"a\.json: two outputs have the same name; give another name$",
    ),
    "one input twice": (
        ["skeletonize", "rod.off", "rod.off", "-o", "."],
        r"rod\.swc: two outputs have the same name; give inputs of different names, or run them one by one$",
    ),
    "missing folder": (["skeletonize", "rod.off", "-o", "no/a.swc"], r"no/a\.swc: the folder /.*/no does not exist"),
    "missing folder of a picture": (
        ["skeletonize", "rod.off", "-o", "a.swc", "--picture", "no/a.png"],
        r"no/a\.png: the folder /.*/no does not exist",
    ),
    "missing folder of distances": (
        ["geodesic", "rod.off", "--source", "0", "-o", "no/a.csv"],
        r"no/a\.csv: the folder /.*/no does not exist; create it first",
    ),
    "a tree of segments": (["segment", "rod.off", "-o", "a.ply", "--tree"], r"unrecognized arguments: --tree"),
    "units of segments": (
        ["segment", "rod.off", "-o", "a.ply", "--units", "um"],
        r"unrecognized arguments: --units um",
    ),
    "several into a file": (["skeletonize", "rod.off", "ring.obj", "-o", "a.swc"], r"a\.swc is not a folder; several"),
    "several into nowhere": (["skeletonize", "rod.off", "ring.obj", "-o", "no"], r"no is not a folder; several"),
    "several pictures into a file": (
        ["skeletonize", "rod.off", "pipe.ply", "-o", ".", "--picture", "a.png"],
        r"a\.png is not a folder; several",
    ),
    "a name that is too long": (["skeletonize", "rod.off", "-o", 300 * "a" + ".swc"], r"aaa"),
    "one face": (["skeletonize", "face.obj", "-o", "a.swc"], r"face\.obj: no component of the mesh has 4 faces"),
    "not a number": (["skeletonize", "nan.obj", "-o", "a.swc"], r"nan\.obj: vertices 1 have NaN"),
    "text that is no mesh": (["info", "text.obj"], r"text\.obj: "),
    "bytes that are no mesh": (["info", "bytes.ply"], r"bytes\.ply: "),
    "no mesh of info": (["info"], r"one of the arguments MESH --system is required"),
    "no such mesh of info": (["info", "a.off"], r"a\.off: no such file"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_told_in_one_line_and_nothing_is_written(name, here, folder):
    (folder / "face.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "nan.obj").write_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "text.obj").write_text("It was a dark and stormy night.\n")
    (folder / "bytes.ply").write_bytes(bytes(range(256)))
    before = file_names(folder)
    arguments, message = BAD[name]
    code, out, err = here(*arguments)
    assert (code, out, len(err)) == (2, [], 1)
    assert err[0].startswith("lbskel: ")
    assert re.search(message, err[0])
    assert file_names(folder) == before


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (
            RuntimeError("one\ntwo"),
            2,
            r"rod\.off: internal error in test_main\.py line \d+, please report it: RuntimeError: one two",
        ),
        (MemoryError(), 2, r"rod\.off: out of memory; simplify the mesh first"),
        (KeyboardInterrupt(), 130, "interrupted; no partial file is left"),
        (OSError(5, "Input/output error"), 2, r"rod\.off: \[Errno 5\] Input/output error"),
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
    assert file_names(folder) == GIVEN


@pytest.mark.parametrize(
    "arguments",
    [
        ["geodesic", "cloud.xyz", "--source", "0"],
        ["segment", "cloud.xyz", "-o", "parts.ply"],
        ["rig", "cloud.xyz", "-o", "rig.glb"],
        ["branches", "cloud.xyz"],
        ["laplacian", "cloud.xyz"],
        ["spectrum", "rod.off", "cloud.xyz"],
        ["smooth", "cloud.xyz", "-o", "smooth.ply"],
        ["compress", "cloud.xyz", "-o", "small.ply"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_command_for_meshes_says_how_to_make_one_of_a_cloud(here, folder, arguments):
    (folder / "cloud.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
    code, _, [line] = here(*arguments)
    assert code == 2
    assert line.startswith(
        "lbskel: cloud.xyz: is a point cloud, and this command needs a mesh; lbskel preprocess cloud.xyz"
    )


def test_an_error_in_a_mesh_names_its_file(here, folder):
    (folder / "point.off").write_text("OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n")
    for arguments in (["spectrum", "rod.off", "point.off", "-k", "5"], ["geodesic", "point.off", "--source", "0"]):
        code, _, [line] = here(*arguments)
        assert code == 2
        assert line.startswith("lbskel: point.off: the mesh has no area")
