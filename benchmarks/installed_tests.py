"""The tests of the source distribution against the installed wheel, with each Python of the machine.

The wheel is installed with the extra ``test`` into a fresh virtual environment, where the C compiler fails. The source
distribution is unpacked, and README's second command runs there. A link to the installed package replaces the unpacked
one, so that nothing else can be imported or read. Everything comes from the package index by pip.
"""

from __future__ import annotations

__all__ = ["run"]

import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.installation_tools import (
    NO_COMPILER,
    ON_ONE_THREAD,
    build_wheels,
    interpreters,
    make_environment,
    processor_seconds,
    source_distribution,
)
from benchmarks.provenance import code_digests, commit

COMMAND = ("pytest", "-n", "2", "--dist", "loadfile")  # README's
QUICK = ("tests/_kernels", "tests/test_import.py")


def run(quick: bool, results: Path) -> int:
    """Run the tests, and write installed_tests.json and installed_tests.md; 1 if any fails."""
    commit(), code_digests("installed_tests")  # both are kept for the header: the clone may change while tests run
    rows: list[dict[str, Any]] = []
    skipped: Counter[str] = Counter()
    failed: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = source_distribution(folder)
        pythons = {sys.version.split()[0]: Path(sys.executable)} if quick else interpreters()
        wheels, _ = build_wheels(source, pythons, folder)
        for version, python in pythons.items():
            environment = make_environment(python, folder / version)
            processor_seconds([environment, "-m", "pip", "install", f"{wheels[version]}[test]"], **NO_COMPILER)
            row, reasons, names = _tested(environment, source, folder / f"tree-{version}", QUICK if quick else ())
            rows.append({"Python": version, "wheel": wheels[version].name.split("-", 2)[2], **row})
            skipped.update({f"{version}: {reason}": count for reason, count in reasons.items()})
            failed.extend(f"{version}: {each}" for each in names)
    save_json(results / "installed_tests.json", {"pythons": rows, "skipped": skipped, "failed": failed})
    text = "\nThe wheel, installed without a compiler; seconds of the clock, of two processes at once.\n"
    sections = {"Each Python": markdown_table(rows) + text}
    sections["Skipped"] = markdown_table([{"reason": reason, "tests": count} for reason, count in skipped.items()])
    sections["Failed"] = "\n".join(f"- {each}" for each in failed) + "\n" if failed else "None.\n"
    save_markdown(results / "installed_tests.md", "Tests of the installed wheel", sections)
    return int(bool(failed))


def _tested(
    python: Path, source: Path, tree: Path, chosen: Sequence[str]
) -> tuple[dict[str, Any], Counter[str], list[str]]:
    """Run tests in the unpacked distribution; counts, reasons of those that are skipped, names of those that fail."""
    with tarfile.open(source) as archive:
        archive.extractall(tree, filter="data")
    [root] = tree.iterdir()
    shutil.rmtree(root / "lbskel")
    [installed] = python.parent.parent.glob("lib/python*/site-packages/lbskel")
    (root / "lbskel").symlink_to(installed)
    report = tree / "report.xml"
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    paths = f"{python.parent}{os.pathsep}{variables['PATH']}"  # as in an activated environment
    done = subprocess.run(
        [python.parent / COMMAND[0], *COMMAND[1:], f"--junitxml={report}", *chosen],
        env={**variables, **ON_ONE_THREAD, **NO_COMPILER, "PATH": paths},
        cwd=root,
        capture_output=True,
        text=True,
    )
    if not report.exists():
        raise RuntimeError(f"{python}: {(done.stdout + done.stderr)[-2000:]}")
    return _counted(report)


def _counted(report: Path) -> tuple[dict[str, Any], Counter[str], list[str]]:
    """Read a report of pytest as JUnit's XML."""
    [suite] = ElementTree.parse(report).getroot().iter("testsuite")
    reasons: Counter[str] = Counter()
    failed = []
    for case in suite.iter("testcase"):
        if (skip := case.find("skipped")) is not None:
            reasons[skip.get("message", "")] += 1
        if case.find("failure") is not None or case.find("error") is not None:
            failed.append(f"{case.get('classname')}::{case.get('name')}")
    total = int(suite.get("tests", 0))
    counts = {"passed": total - reasons.total() - len(failed), "skipped": reasons.total(), "failed": len(failed)}
    return {**counts, "seconds": float(suite.get("time", 0))}, reasons, failed
