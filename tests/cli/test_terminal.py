"""Results as text and as JSON, quietly or not, and the bar on a terminal."""

import io
import json
import sys
from argparse import Namespace

import pytest

from lbskel.cli import terminal
from lbskel.cli.main import command_line_parser, main
from lbskel.cli.terminal import progress, tell, with_options


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("quiet", "json", "shown"), [(False, False, "a text\n"), (True, False, ""), (False, True, '{"n": 1}\n')]
)
def test_a_result_is_text_or_json_or_nothing(capsys, quiet, json, shown):
    tell(Namespace(quiet=quiet, json=json), "a text", {"n": 1})
    assert capsys.readouterr().out == shown


def test_what_is_not_finite_is_null_in_json(capsys):
    tell(Namespace(quiet=False, json=True), "", {"a": [1.5, float("nan")], "b": {"c": (float("inf"), "NaN", 2)}})
    assert capsys.readouterr().out == '{"a": [1.5, null], "b": {"c": [null, "NaN", 2]}}\n'


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("n_nodes must be a whole number", "--nodes must be a whole number"),
        ("a larger min_branch_ratio leaves fewer", "a larger --min-branch-ratio leaves fewer"),
        ("preprocess='merge_close:tolerance=1' merges", "--preprocess merge_close:tolerance=1 merges"),
        ("the root is no node; preprocess first", "the root is no node; preprocess first"),
        ("n_nodes.ply: n_nodes of no/n_nodes is n_nodes.", "n_nodes.ply: --nodes of no/n_nodes is --nodes."),
        ("old-n_nodes.ply, n_nodes-2.ply: n_nodes", "old-n_nodes.ply, n_nodes-2.ply: --nodes"),
    ],
)
def test_messages_name_options_in_place_of_arguments_of_python(message, shown):
    options = {
        name: f"--{name.removeprefix('n_').replace('_', '-')}"
        for name in ("n_nodes", "min_branch_ratio", "preprocess", "root")
    }
    assert with_options(message, Namespace(options=options)) == shown


@pytest.mark.parametrize(
    ("command", "option", "message"),
    [
        ("skeletonize", "--nodes", "--nodes must be at least"),
        ("skeletonize", "--memory-limit", "or raise --memory-limit"),
        ("batch", "--nodes", "--nodes must be at least"),
    ],
)
def test_errors_of_the_library_name_options(folder, capsys, command, option, message):
    assert main([command, "rod.off", "-o", "a.swc", option, "1"]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("stream", "quiet", "shows"), [(Terminal, False, True), (Terminal, True, False), (io.StringIO, False, False)]
)
def test_what_takes_long_is_shown_on_a_terminal_only(monkeypatch, capsys, stream, quiet, shows):
    """The result takes the place of the bar."""
    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)  # shown at once, by this thread
    arguments = Namespace(command="smooth", quiet=quiet)
    with progress(arguments):
        arguments.on_stage("rod.off: solve")
        before = sys.stderr.getvalue()
        print("done")
    assert ("lbskel smooth: rod.off: solve" in before) == shows
    assert sys.stderr.getvalue().endswith("\r") == shows  # it leaves an empty line
    assert capsys.readouterr().out == "done\n"


def test_what_is_quick_shows_nothing_on_a_terminal(monkeypatch, folder):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(terminal, "PATIENCE", 1e6)  # so that nothing is slow
    assert main(["info", "rod.off", "--json"]) == 0
    assert sys.stderr.getvalue() == ""


COMMANDS = {
    "branches": ["ring.obj"],
    "check": ["rod.off"],
    "compress": ["rod.off", "-o", "a.off", "-k", "20"],
    "edit": ["rod.off", "-o", "a.off", "--move", "x:0.9:1", "--fix", "x:0:0.1"],
    "geodesic": ["rod.off", "--source", "0"],
    "info": ["rod.off"],
    "laplacian": ["rod.off"],
    "preprocess": ["rod.off", "-o", "a.off"],
    "quantize": ["rod.off", "-o", "a.off"],
    "rig": ["rod.off", "-o", "a.glb"],
    "segment": ["rod.off", "-o", "a.ply"],
    "skeletonize": ["rod.off", "-o", "a.swc"],
    "smooth": ["rod.off", "-o", "a.off"],
    "spectrum": ["rod.off", "-k", "8"],
    "view": ["rod.off", "-o", "a.html"],
}
ELSEWHERE = {"batch", "compare", "score"}  # whose tests have them too: they take longer, or need more files


def test_every_command_has_quiet_and_json():
    parsers = command_line_parser()._subparsers._group_actions[0].choices
    assert set(parsers) == set(COMMANDS) | ELSEWHERE
    for name, parser in parsers.items():
        options = parser.format_help()
        assert "--quiet" in options, name
        assert "--json" in options, name
        assert "\nexample:\n  lbskel " + name in options, name


@pytest.mark.parametrize("name", COMMANDS)
def test_json_is_one_document_and_quiet_is_nothing(here, name):
    code, out, err = here(name, *COMMANDS[name], "--json")
    assert (code, err) == (0, [])
    assert json.loads("\n".join(out))
    force = ["--force"] if "-o" in COMMANDS[name] else []
    assert here(name, *COMMANDS[name], *force, "--quiet") == (0, [], [])
