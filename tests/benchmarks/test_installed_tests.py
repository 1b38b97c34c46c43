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


def test_the_package_of_the_distribution_is_not_what_is_tested(tmp_path, monkeypatch):
    """Tests run beside the meshes, without the sources of the package."""
    tree = tmp_path / "lbskel-1"
    for name in ("lbskel", "tests"):
        (tree / name).mkdir(parents=True)
    (tree / "tests" / "test_some.py").write_text(
        "import os\ndef test_gone():\n    assert not os.path.exists('lbskel') and os.environ['CC'] == '/bin/false'\n"
    )
    with tarfile.open(tmp_path / "source.tar.gz", "w:gz") as archive:
        archive.add(tree, "lbskel-1")
    (tmp_path / "bin").mkdir()
    script = tmp_path / "bin" / "pytest"
    script.write_text(f"#!/bin/sh\nexec {sys.executable} -m pytest $5 $6\n")  # one process, in place of two
    script.chmod(0o755)
    counts, _, failed = installed_tests._tested(
        tmp_path / "bin" / "python", tmp_path / "source.tar.gz", tmp_path / "tree", ["tests"]
    )
    assert (counts["passed"], failed) == (1, [])


def test_a_run_without_a_report_is_an_error(tmp_path):
    (tmp_path / "lbskel").mkdir()
    with tarfile.open(tmp_path / "source.tar.gz", "w:gz") as archive:
        archive.add(tmp_path / "lbskel", "lbskel-1/lbskel")
    (tmp_path / "pytest").write_text("#!/bin/sh\necho no such option\nexit 4\n")
    (tmp_path / "pytest").chmod(0o755)
    with pytest.raises(RuntimeError, match="no such option"):
        installed_tests._tested(tmp_path / "python", tmp_path / "source.tar.gz", tmp_path / "tree", [])
