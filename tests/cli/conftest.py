"""Fixtures of the command line's tests: a folder with meshes, and two ways to run a command in it."""

import pytest

from lbskel import write_mesh
from lbskel.cli.main import main
from lbskel.pipeline.environment import SLOW
from lbskel.shapes import cylinder


@pytest.fixture
def folder(tmp_path, monkeypatch, rod, ring):
    """A folder to work in, with a rod, a ring and an open pipe."""
    monkeypatch.chdir(tmp_path)
    write_mesh("rod.off", rod)
    write_mesh("ring.obj", ring)
    write_mesh("pipe.ply", cylinder(0.3, 3.0, 12, 12))
    return tmp_path


def without_warning(err):
    """The lines of stderr but the one that says that kernels are not compiled: ``test_main`` tests that."""
    return [line for line in err.splitlines() if line != f"lbskel: warning: {SLOW}"]


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
        return code, out.splitlines(), without_warning(err)

    return run


@pytest.fixture
def apart(folder, python):
    """Run a command in a process of its own."""

    def run(*arguments, **environment):
        result = python("-m", "lbskel", *arguments, cwd=folder, **environment)
        return result.returncode, result.stdout.splitlines(), without_warning(result.stderr)

    return run
