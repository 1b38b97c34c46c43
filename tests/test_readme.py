"""What the documentation shows is run: every block of README.md, and every example in a docstring."""

import contextlib
import doctest
import importlib
import io
import os
import pkgutil
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import lbskel
from lbskel.cli import COMMANDS
from lbskel.cli.main import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = [(match[1], match[2]) for match in re.finditer(r"^```(\w*)\n(.*?)^```$", README, re.M | re.S)]
RUN = {"bash", "console", "python"}  # the others only show
SHOWN = {"text"}

MODULES = [
    module.name
    for module in pkgutil.walk_packages(lbskel.__path__, "lbskel.")
    if not module.name.endswith(("__main__", "memory_views"))  # a script, and the code that kernels share
]


def blocks(*languages):
    return [
        pytest.param(body, id=f"{language} {n}") for n, (language, body) in enumerate(BLOCKS) if language in languages
    ]


@pytest.fixture
def clone(tmp_path, monkeypatch):
    """A folder that looks like a clone to what the README does there: its meshes are in it."""
    shutil.copytree(ROOT / "meshes", tmp_path / "meshes")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_block_is_of_a_kind_that_is_known():
    assert README.count("```") == 2 * len(BLOCKS)
    assert {language for language, _ in BLOCKS} <= RUN | SHOWN
    assert {language for language, _ in BLOCKS} >= {"bash", "python"}


def test_items_of_lists_begin_a_line():
    assert not re.search(r"\S (\d\.|-) \*\*", README)


def test_the_first_screen_has_the_two_commands():
    lines = [line for language, body in BLOCKS if language == "bash" for line in body.splitlines()]
    install, check = [line for line in lines if line.startswith("pip install ")]
    assert re.match(r"pip install '\.\[view\]' && lbskel skeletonize meshes/\S+ -o \S+ --picture \S+\.png", install)
    assert check == "pip install '.[test]' && pytest -n 2 --dist loadfile"


def without_installing(line):
    """The part of a command after ``pip install ... &&``; the whole of any other, without its prompt."""
    return re.sub(r"^pip install \S+( && |$)", "", line.removeprefix("$ "))


def run_here(command):
    """Run lines of ``lbskel`` that are joined by ``&&``; the last exit code."""
    for each in command.split(" && "):
        name, *arguments = shlex.split(each, comments=True)
        assert name == "lbskel"
        if code := main(arguments):
            break
    return code


@pytest.mark.skipif(os.name == "nt", reason="the commands are for a POSIX shell")
@pytest.mark.parametrize("body", blocks("bash", "console"))
def test_commands(body, clone, capfd):
    """The first one in a shell, as it is printed; many in this process, which has imported what they need."""
    paths = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    is_console = any(line.startswith("$ ") for line in body.splitlines())
    lines = [line for line in body.splitlines() if line.startswith("$ ") or (line and not is_console)]
    commands = [command for command in map(without_installing, lines) if command]
    if [command.split()[0] for command in commands] == ["pytest"]:
        pytest.skip("that is what is running now")
    for command in commands:
        if len(commands) > 1:
            code, errors = run_here(command), capfd.readouterr().err
        else:
            environment = {**os.environ, "PATH": paths}
            result = subprocess.run(command, shell=True, cwd=clone, env=environment, capture_output=True, text=True)
            code, errors = result.returncode, result.stderr
        assert (code, errors) == (0, ""), command
        for name in re.findall(r"(?:-o|--output|--picture|--report|--page) (\S+)", command):
            assert (clone / name).stat().st_size > 0


@pytest.mark.parametrize("body", blocks("python"))
def test_python(body, clone):
    """It runs, and ``print(...)  # text`` prints that text."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(body, "README.md", "exec"), {"__name__": "readme"})
    promised = re.findall(r"^print\(.*\)  # (.*)$", body, re.M)
    check = doctest.OutputChecker().check_output
    for text in promised:
        assert any(check(text, line, doctest.ELLIPSIS) for line in printed.getvalue().splitlines()), text


def test_commands_that_are_named_exist():
    named = set(re.findall(r"^lbskel (\w+)", "\n".join(body for language, body in BLOCKS if language == "text"), re.M))
    assert named == {command.__name__.rpartition(".")[2] for command in COMMANDS}


def test_files_that_are_linked_exist():
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", README) if "://" not in link]
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_the_modules_are_found():
    assert {"lbskel.geometry.mesh", "lbskel.operators.cotangent", "lbskel.io.swc", "lbskel.cli.info"} <= set(MODULES)


@pytest.mark.parametrize("name", ["lbskel", *MODULES])
def test_examples_in_docstrings(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    finder, runner, report = doctest.DocTestFinder(), doctest.DocTestRunner(), io.StringIO()
    for test in finder.find(module, name):
        runner.run(test, out=report.write)
    results = runner.summarize(verbose=False)
    place = Path(module.__file__)  # of kernels, what they were compiled to
    source = (place if place.suffix == ".py" else ROOT / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8")
    assert results.failed == 0, report.getvalue()
    assert results.attempted == len(re.findall(r"^\s*>>> ", source, re.M))  # none is overlooked
    assert list(tmp_path.iterdir()) == []


def test_the_tables_are_those_of_the_results_and_of_the_code(monkeypatch, tmp_path):
    from benchmarks import readme

    copy = tmp_path / "README.md"
    copy.write_text(README, encoding="utf-8")
    monkeypatch.setattr(readme, "README", copy)
    readme.run(False, ROOT / "benchmarks" / "results")
    assert copy.read_text(encoding="utf-8") == README
    assert f"<!-- measures -->\n{readme.measures_table()}<!-- end -->" in README
