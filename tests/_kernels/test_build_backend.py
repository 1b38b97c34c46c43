"""The build backend asks for a C compiler where the machine has none, and setuptools then finds that."""

import runpy
import shlex
import sys
from pathlib import Path

import pytest

from lbskel import _kernels

FILE = Path(_kernels.__file__).parent / "build_backend.py"


@pytest.fixture
def backend():
    """The module as setuptools loads it: on its own."""
    return runpy.run_path(str(FILE))


def requirements(backend):
    return [*backend["get_requires_for_build_wheel"](), *backend["get_requires_for_build_editable"]()]


def test_a_machine_with_a_compiler_needs_none(backend, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CC", f"{shlex.quote(sys.executable)} -O2")  # any program that exists
    assert "ziglang" not in requirements(backend)
    assert backend["find_compiler"]() == {}


@pytest.mark.skipif(sys.platform != "linux", reason="setuptools finds the compilers of other systems")
def test_a_machine_without_one_gets_one(backend, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CC", "no-such-compiler -pthread")
    assert requirements(backend).count("ziglang") == 2
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert backend["find_compiler"]() == {}  # then the kernels stay uncompiled
    monkeypatch.setattr("importlib.util.find_spec", lambda name: name)
    assert shlex.split(backend["find_compiler"]()["CC"]) == [sys.executable, "-m", "ziglang", "cc"]
    assert backend["find_compiler"]()["LDSHARED"].endswith("cc -shared")
