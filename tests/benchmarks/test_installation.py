"""The benchmark of installations: seconds of processes, sizes of packages, and interpreters; nothing is installed."""

import json
import subprocess
import sys

import pytest

from benchmarks import installation, installation_tools
from benchmarks.installation_numba import compile_kernels


def test_the_least_of_all_turns_but_the_first_counts(monkeypatch):
    taken = {"a": iter([1.0, 5.0, 4.0]), "b": iter([9.0, 2.0, 3.0])}
    monkeypatch.setattr(
        installation, "processor_seconds", lambda command, **environment: next(taken[environment["name"]])
    )
    commands = {name: (["python"], {"name": name}) for name in taken}
    assert installation._least(commands, 2) == {"a": 4.0, "b": 2.0}


def test_seconds_are_of_the_processor_and_a_failure_tells_what_was_printed():
    assert installation_tools.processor_seconds([sys.executable, "-c", "sum(range(10**6))"]) > 0
    with pytest.raises(RuntimeError, match="no such mesh"):
        installation_tools.processor_seconds([sys.executable, "-c", "raise SystemExit('no such mesh')"])


def test_variables_reach_the_process(tmp_path):
    code = f"import os; open({str(tmp_path / 'cc')!r}, 'w').write(os.environ['CC'] + os.environ['OMP_NUM_THREADS'])"
    installation_tools.processor_seconds([sys.executable, "-c", code], CC="none")
    assert (tmp_path / "cc").read_text() == "none1"


def test_sizes_are_of_the_files_of_packages():
    done = subprocess.run([sys.executable, "-c", installation.PACKAGE_SIZES], capture_output=True, text=True)
    sizes = json.loads(done.stdout)
    assert sizes["scipy"] > sizes["tqdm"] > 0


def test_interpreters_are_of_the_named_versions():
    found = installation_tools.interpreters()
    assert all(version.startswith("3.") and int(version.split(".")[1]) >= 10 for version in found)


def test_kernels_run_with_plain_blocks_where_another_compiler_takes_them(tmp_path):
    """With a stand-in for numba that compiles nothing."""
    (tmp_path / "numba.py").write_text("def njit(function):\n    return function\n")
    rows = compile_kernels(sys.executable, tmp_path)
    assert {"corner_products", "nearest_points", "winding_numbers"} <= {row["function"] for row in rows}
    assert all(row["seconds"] > 0 for row in rows)


def test_the_first_run_is_that_of_the_readme(monkeypatch, tmp_path):
    commands = []
    monkeypatch.setattr(
        installation, "processor_seconds", lambda command, **environment: commands.append(command) or 1.0
    )
    rows = installation._first_run(sys.executable, tmp_path)
    assert rows[-1]["processor seconds"] == 4.0
    assert "pip install '.[view]'" in commands[2][2]
    assert "lbskel skeletonize meshes/dinosaur.ply" in commands[3][2]
