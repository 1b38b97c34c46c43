"""Mutation testing: plausible one-line bugs are put into the code one at a time, and the tests must fail on each.

The bugs are listed in ``benchmarks/mutations/PACKAGE.toml``. Each entry has ``file``, ``bug`` (what is wrong, in a
sentence), ``find`` (text that occurs exactly once in the file), ``replace``, and ``tests`` (the files that must fail).
``uncompiled = true`` removes the compiled module beside the source, ``equivalent`` says why no test can fail.

Every bug is applied to a temporary copy of the repository. The tests that it names first run there unchanged, and have
to pass.
"""

from __future__ import annotations

__all__ = ["FOLDER", "Mutation", "apply", "measure", "read_mutations", "run"]

import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.provenance import commit

ROOT = Path(__file__).parent.parent
FOLDER = Path(__file__).parent / "mutations"
MIN_CAUGHT = 0.9  # share of the mutations, without the equivalent ones, below which the run fails; the project's bar
TIME_LIMIT = 300.0  # seconds for the tests of one mutation; a guess: the tests named need less than 20
# the last is the record of what the kernels were compiled from, which would make a mutated kernel an error at import
NOT_COPIED = (".git", ".venv", "venv", "build", "dist", "*.egg-info", "__pycache__", ".*_cache", ".hypothesis", "*.crc")
OUTCOMES = ("caught", "survived", "equivalent")
SHOWN_LINES = 20  # the end of what pytest prints: its summary has whole messages where the variable CI is set
PYTEST_USAGE_ERROR, PYTEST_NO_TESTS = 4, 5  # exit codes of pytest that say nothing about the mutation


@dataclass(frozen=True)
class Mutation:
    """One bug, and the tests that must notice it.

    Parameters
    ----------
    package : str
        Name of the list that it is in, without ``.toml``.
    file : str
        The source file, relative to the root of the repository.
    bug : str
        What is wrong after the mutation, in one sentence.
    find, replace : str
        The text, which occurs exactly once in the file, and what it becomes.
    tests : tuple of str
        Test files, or ``file::test``, relative to the root.
    equivalent : str
        Why the mutation changes no result; empty where tests have to fail.
    uncompiled : bool
        Whether the compiled module beside the source is removed, so that the source itself runs.
    """

    package: str
    file: str
    bug: str
    find: str
    replace: str
    tests: tuple[str, ...]
    equivalent: str = ""
    uncompiled: bool = False


def run(quick: bool, results: Path, package: str | None = None, jobs: int = 1) -> int:
    """Apply every mutation, and write mutations.json and mutations.md; 1 if too many survive.

    Quick runs take the first mutation of each list. Runs of one package replace its rows, and leave those of others
    with the commit at which they were measured.
    """
    mutations = read_mutations(FOLDER, package)
    if quick:
        mutations = list({mutation.package: mutation for mutation in reversed(mutations)}.values())[::-1]
    rows = [{**row, "commit": commit()} for row in measure(mutations, ROOT, jobs)]
    path = results / "mutations.json"
    if package is not None and path.exists():
        others = json.loads(path.read_text(encoding="utf-8"))["mutations"]
        rows = sorted([*(row for row in others if row["package"] != package), *rows], key=lambda row: row["package"])
    summary = summarize(rows)
    save_json(path, {"summary": summary, "mutations": rows}, packages=("pytest",))
    save_markdown(results / "mutations.md", "Mutations that the tests notice", tables(rows))
    print(markdown_table(summary))
    survivors = [f"{row['file']}: {row['bug']}" for row in rows if row["outcome"] == "survived"]
    print("\n".join(["Survived:", *survivors] if survivors else ["None survived."]))
    return 0 if caught_share(rows) >= MIN_CAUGHT else 1


def read_mutations(folder: Path, package: str | None = None) -> list[Mutation]:
    """The mutations of all lists in a folder, or of one.

    Raises
    ------
    ValueError
        If there is no such list, or an entry has unknown or missing keys.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    paths = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    if package is not None and package not in paths:
        raise ValueError(f"there are no mutations of {package!r}; there are of: {', '.join(paths)}")
    known = {field.name for field in fields(Mutation)} - {"package"}
    required = {field.name for field in fields(Mutation) if field.default is MISSING} - {"package"}
    mutations = []
    for name in paths if package is None else [package]:
        for number, entry in enumerate(tomllib.loads(paths[name].read_text(encoding="utf-8")).get("mutation", []), 1):
            if wrong := sorted(set(entry) - known | required - set(entry)):
                raise ValueError(f"{paths[name].name}, mutation {number}: unknown or missing: {', '.join(wrong)}")
            mutations.append(Mutation(package=name, **{**entry, "tests": tuple(entry["tests"])}))
    return mutations


def apply(mutation: Mutation, root: Path) -> str:
    """The mutated text of the file.

    Raises
    ------
    ValueError
        If the file or a test file does not exist, the text to find does not occur exactly once, the mutation changes
        nothing, or a compiled module would run in place of the mutated source.
    """
    name = f"{mutation.package}.toml, {mutation.bug!r}"
    path = root / mutation.file
    if missing := [file for file in (mutation.file, *_files(mutation)) if not (root / file).is_file()]:
        raise ValueError(f"{name}: there is no file {', '.join(missing)}")
    text = path.read_text(encoding="utf-8")
    if (count := text.count(mutation.find)) != 1:
        raise ValueError(f"{name}: the text to find occurs {count} times in {mutation.file}: {mutation.find!r}")
    if mutation.find == mutation.replace:
        raise ValueError(f"{name}: the replacement equals the text to find")
    if not mutation.uncompiled and path.parent.name == "_kernels" and path.stem != "build_ext":
        raise ValueError(f"{name}: the compiled module would run instead; it needs uncompiled = true")
    return text.replace(mutation.find, mutation.replace)


def _require_applicable(mutations: Sequence[Mutation], root: Path) -> None:
    """Raise one ValueError for all mutations that cannot be applied."""
    problems = []
    for mutation in mutations:
        try:
            apply(mutation, root)
        except ValueError as error:
            problems.append(str(error))
    if problems:
        raise ValueError("\n".join(problems))


def _files(mutation: Mutation) -> list[str]:
    """The test files."""
    return [test.split("::")[0] for test in mutation.tests]


def measure(mutations: Sequence[Mutation], root: Path, jobs: int = 1) -> list[dict[str, Any]]:
    """One row for each mutation, with its ``outcome``: caught, survived or equivalent.

    Parameters
    ----------
    mutations : sequence of Mutation
    root : Path
        The repository, which is not changed.
    jobs : int
        How many copies of it work at the same time.

    Raises
    ------
    ValueError
        If a mutation cannot be applied.
    RuntimeError
        If tests that it names fail without it.
    """
    _require_applicable(mutations, root)
    with ExitStack() as stack:
        copies: queue.SimpleQueue[Path] = queue.SimpleQueue()
        for _ in range(jobs):
            copies.put(stack.enter_context(_copy(root)))
        pool = stack.enter_context(ThreadPoolExecutor(jobs))
        suites: dict[str, dict[str, None]] = {}  # tests by the kernel that runs uncompiled, or none
        for mutation in mutations:
            suites.setdefault(mutation.file if mutation.uncompiled else "", {}).update(dict.fromkeys(mutation.tests))
        broken = [
            text for text in pool.map(lambda suite: _unchanged([*suite[1]], suite[0], copies), suites.items()) if text
        ]
        if broken:
            raise RuntimeError("tests fail without any mutation:\n" + "\n".join(broken))
        return list(pool.map(lambda mutation: _row(mutation, root, copies), mutations))


@contextmanager
def _copy(root: Path) -> Iterator[Path]:
    """A copy of the repository with its compiled modules, whose times of change are kept."""
    with tempfile.TemporaryDirectory(prefix="lbskel-mutations-") as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(root, copy, ignore=shutil.ignore_patterns(*NOT_COPIED))
        yield copy


@contextmanager
def _uncompiled(copy: Path, file: str) -> Iterator[None]:
    """The compiled modules beside a source file, moved away for a while."""
    source = copy / file
    compiled = [path for path in source.parent.glob(f"{source.stem}.*") if path.suffix in (".so", ".pyd")]
    with tempfile.TemporaryDirectory() as folder:
        for path in compiled:
            shutil.move(path, folder)
        try:
            yield
        finally:
            for path in compiled:
                shutil.move(Path(folder) / path.name, path)


def _pytest(copy: Path, tests: Sequence[str], time_limit: float = TIME_LIMIT) -> tuple[int | None, str]:
    """The exit code of the tests in a copy, None at the time limit, and the end of what they print."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(copy),
        "PYTHONDONTWRITEBYTECODE": "1",  # files changed twice in a second would run from an old cache
        "OMP_NUM_THREADS": "1",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # which takes longer than most of the tests
    }
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=time_limit)
    except subprocess.TimeoutExpired:
        return None, f"over {time_limit:g} s"
    return done.returncode, "\n".join((done.stdout + done.stderr).splitlines()[-SHOWN_LINES:])


def _unchanged(tests: Sequence[str], uncompiled: str, copies: queue.SimpleQueue[Path]) -> str:
    """Why tests fail without any mutation, with one compiled module removed if it is named; empty if they pass."""
    copy = copies.get()
    try:
        with _uncompiled(copy, uncompiled) if uncompiled else nullcontext():
            code, printed = _pytest(copy, tests, len(tests) * TIME_LIMIT)
        return "" if code == 0 else printed
    finally:
        copies.put(copy)


def _row(mutation: Mutation, root: Path, copies: queue.SimpleQueue[Path]) -> dict[str, Any]:
    """Put a mutation into a copy, run its tests, and restore the copy."""
    copy = copies.get()
    path = copy / mutation.file
    began = time.perf_counter()
    try:
        with _uncompiled(copy, mutation.file) if mutation.uncompiled else nullcontext():
            path.write_text(apply(mutation, copy), encoding="utf-8")
            code, printed = _pytest(copy, mutation.tests)
    finally:
        shutil.copy2(root / mutation.file, path)
        copies.put(copy)
    if code in (PYTEST_USAGE_ERROR, PYTEST_NO_TESTS):
        raise RuntimeError(f"{mutation.package}.toml, {mutation.bug!r}: pytest ran no test: {printed}")
    outcome = "caught" if code != 0 else "equivalent" if mutation.equivalent else "survived"
    print(f"{outcome:10} {mutation.file}: {mutation.bug}", file=sys.stderr, flush=True)
    return {
        "package": mutation.package,
        "file": mutation.file,
        "bug": mutation.bug,
        "outcome": outcome,
        "seconds": time.perf_counter() - began,
        "tests": ", ".join(mutation.tests),
        "why equivalent": mutation.equivalent if outcome == "equivalent" else None,
    }


def caught_share(rows: Sequence[dict[str, Any]]) -> float:
    """Share of the mutations caught, of those that are not equivalent; 1 where there are none."""
    judged = [row["outcome"] == "caught" for row in rows if row["outcome"] != "equivalent"]
    return sum(judged) / len(judged) if judged else 1.0


def summarize(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One line for each package, and one for all."""
    lines = []
    for package in (*dict.fromkeys(row["package"] for row in rows), None):
        own = [row for row in rows if package in (None, row["package"])]
        count = {outcome: sum(row["outcome"] == outcome for row in own) for outcome in OUTCOMES}
        share = f"{100 * caught_share(own):.0f} %"
        at = ", ".join(dict.fromkeys(row.get("commit", "earlier") for row in own)) if package else None
        lines.append(
            {"package": package or "all", "mutations": len(own), **count, "share caught": share, "measured at": at}
        )
    return lines


def tables(rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    """The summary, what survived, what is equivalent, and every mutation."""
    survived = [row for row in rows if row["outcome"] == "survived"]
    equivalent = [row for row in rows if row["outcome"] == "equivalent"]
    return {
        "Summary": markdown_table(summarize(rows))
        + "\nThe share is of the mutations that are not equivalent, that is, that change a result.\n",
        "Survived": markdown_table(survived, ["file", "bug", "tests"]) if survived else "None.\n",
        "Equivalent": markdown_table(equivalent, ["file", "bug", "why equivalent"]) if equivalent else "None.\n",
        "All mutations": markdown_table(rows, ["file", "bug", "outcome"]),
    }
