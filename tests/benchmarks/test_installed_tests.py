"""The benchmark that tests the installed wheel with each Python: what it reads of a report; nothing is installed."""

import subprocess
import sys
import tarfile

import pytest

from benchmarks import installed_tests

TESTS = """
import pytest

def test_passes():
    pass

@pytest.mark.parametrize("number", [0, 1])
def test_skips(number):
    pytest.skip("no such tool")

def test_fails():
    assert False

@pytest.fixture
def broken():
    raise RuntimeError

def test_has_no_fixture(broken):
    pass
"""


def test_a_report_is_counted(tmp_path):
    (tmp_path / "test_some.py").write_text(TESTS)
    report = tmp_path / "report.xml"
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", f"--junitxml={report}", tmp_path]
    subprocess.run(command, cwd=tmp_path, capture_output=True)
    counts, reasons, failed = installed_tests._counted(report)
    assert counts.pop("seconds") > 0
    assert counts == {"passed": 1, "skipped": 2, "failed": 2}
    assert reasons == {"no such tool": 2}
    assert failed == ["test_some::test_fails", "test_some::test_has_no_fixture"]


@pytest.fixture
def environment(tmp_path):
    """What looks like a virtual environment with the package installed, and a distribution with another one."""
    site = tmp_path / "lib" / "python3.11" / "site-packages"
    tree = tmp_path / "lbskel-1"
    for folder in (site / "lbskel", tmp_path / "bin", tree / "lbskel", tree / "tests"):
        folder.mkdir(parents=True)
    (site / "lbskel" / "installed").touch()
    (tree / "tests" / "test_some.py").write_text(
        "import os\n"
        "def test_it_is_the_installed_one():\n"
        "    assert os.listdir('lbskel') == ['installed'] and os.environ['CC'] == '/bin/false'\n"
    )
    with tarfile.open(tmp_path / "source.tar.gz", "w:gz") as archive:
        archive.add(tree, "lbskel-1")
    return tmp_path


def script(path, line):
    path.write_text(f"#!/bin/sh\n{line}\n")
    path.chmod(0o755)


def test_only_the_installed_package_is_there(environment):
    script(environment / "bin" / "pytest", f"exec {sys.executable} -m pytest $5 $6")  # one process, in place of two
    counts, _, failed = installed_tests._tested(
        environment / "bin" / "python", environment / "source.tar.gz", environment / "tree", ["tests"]
    )
    assert (counts["passed"], failed) == (1, [])


def test_a_run_without_a_report_is_an_error(environment):
    script(environment / "bin" / "pytest", "echo no such option; exit 4")
    with pytest.raises(RuntimeError, match="no such option"):
        installed_tests._tested(environment / "bin" / "python", environment / "source.tar.gz", environment / "tree", [])
