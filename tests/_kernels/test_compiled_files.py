"""Compiled kernels that are not those of the sources are noticed at import; a clone uses those that are installed."""

import os
import shutil
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

import lbskel
from lbskel import _kernels
from lbskel._kernels.compiled_files import (
    SUFFIX,
    changed_sources,
    checksums,
    installed_twin,
    is_compiled,
    uncompiled_kernels,
    write_record,
)

PACKAGE = Path(lbskel.__file__).parent


@pytest.fixture
def make_folder(tmp_path):
    """Make a folder of kernels, with one that looks compiled or with none."""

    def make(name, sources, *, compiled):
        folder = tmp_path / name / "lbskel" / "_kernels"
        folder.mkdir(parents=True)
        for source, text in sources.items():
            (folder / source).write_text(text)
        if compiled:
            (folder / f"a{SUFFIX}").touch()
        return folder

    return make


def test_sources_that_change_after_the_record_are_named(make_folder):
    folder = make_folder("clone", {"a.py": "1", "b.py": "2", "c.py": "3"}, compiled=True)
    write_record(folder)
    assert changed_sources(folder) == []
    os.utime(folder / "a.py", (1, 1))  # a checkout changes times, not contents
    assert changed_sources(folder) == []
    (folder / "a.py").write_text("4")
    (folder / "b.py").unlink()
    (folder / "d.py").touch()
    assert changed_sources(folder) == ["a.py", "b.py", "d.py"]
    write_record(folder)
    assert changed_sources(folder) == []


def test_without_a_record_nothing_has_changed(make_folder):
    assert changed_sources(make_folder("installed", {"a.py": "1"}, compiled=True)) == []


def test_a_record_leaves_no_file_that_is_imported_in_place_of_those_just_compiled(make_folder):
    folder = make_folder("clone", {"a.py": "1"}, compiled=True)
    (folder / f"a{EXTENSION_SUFFIXES[0]}").touch()
    write_record(folder)
    assert {path.name for path in folder.glob("a.*")} == {"a.py", f"a{SUFFIX}"}


def test_uncompiled_kernels_are_named(clone, python):
    with open(clone / "_kernels" / "bvh.py", "a") as file:
        file.write("# changed\n")  # so that no installed kernels are those of the clone
    code = "from lbskel import _kernels; print(_kernels.is_slow())"
    assert python("-c", code, cwd=clone.parent).stdout == "True\n"
    assert ("bvh" in uncompiled_kernels(PACKAGE / "_kernels")) == _kernels.is_slow()
    assert not set(uncompiled_kernels(PACKAGE / "_kernels")) & {"__init__", "build_ext", "c_types", "compiled_files"}


def test_checksums_are_crc_32(make_folder):
    folder = make_folder("clone", {"a.py": "123456789", "note.txt": ""}, compiled=False)
    assert checksums(folder) == {"a.py": "cbf43926"}  # the check value of CRC-32 in its catalogs


def test_a_twin_has_the_same_sources_and_is_compiled(make_folder, monkeypatch):
    sources = {"a.py": "1"}
    clone = make_folder("clone", sources, compiled=False)
    folders = [
        clone,
        make_folder("uncompiled", sources, compiled=False),
        make_folder("other", {"a.py": "2"}, compiled=True),
        make_folder("twin", sources, compiled=True),
    ]
    assert [is_compiled(folder) for folder in folders] == [False, False, True, True]
    entries = [str(folder.parent.parent) for folder in folders]
    monkeypatch.setattr(sys, "path", ["", "/nowhere", *entries[:3]])
    assert installed_twin(clone) is None
    monkeypatch.setattr(sys, "path", ["", "/nowhere", *entries])
    assert installed_twin(clone) == str(folders[3])
    (folders[3] / "a.py").write_text("2")
    write_record(folders[3])
    (folders[3] / "a.py").write_text("1")
    assert installed_twin(clone) is None  # the twin's own sources have changed since


@pytest.fixture
def clone(tmp_path):
    """A copy of the package without compiled files."""
    folder = tmp_path / "clone" / "lbskel"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__", f"*{SUFFIX}*"))
    return folder


def test_stale_kernels_are_an_error_at_import(clone, python):
    (clone / "_kernels" / f"bvh{SUFFIX}").touch()
    write_record(clone / "_kernels")
    with open(clone / "_kernels" / "bvh.py", "a") as file:
        file.write("# changed\n")
    result = python("-c", "import lbskel.geometry", cwd=clone.parent)
    assert result.returncode == 1
    assert "ImportError: the compiled kernels in" in result.stderr
    assert "bvh.py changed): run pip install -e ." in result.stderr


def test_a_clone_uses_the_kernels_that_are_installed(clone, python):
    installed = Path(_kernels.__path__[0])
    if not is_compiled(installed):
        pytest.skip("kernels were not compiled at installation")
    code = "import lbskel; from lbskel._kernels import bvh; print(lbskel.__file__); print(bvh.__file__)"
    result = python("-c", code, cwd=clone.parent, PYTHONPATH=str(installed.parent.parent))
    package, kernel = map(Path, result.stdout.splitlines())
    assert package.parent == clone
    assert kernel.parent == installed
    assert kernel.name == f"bvh{SUFFIX}"
