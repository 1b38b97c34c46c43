"""Results that are older than the code that they describe, with the packages that have changed since.

A result records the commit at which it was measured and, for each package that its benchmark imports, directly or
through others, a digest of the code without docstrings, lines of comments and blank lines. The packages whose digest
has changed are named, and the commits of rows that remain from an earlier run; nothing is measured.
"""

from __future__ import annotations

__all__ = ["SOURCES", "code_digests", "commit", "imported_modules", "mesh_files", "run", "stale"]

import ast
import functools
import hashlib
import json
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
SOURCES = Path(__file__).parent / "mesh_sources.json"  # of those not in the repository, by SHA-256
DIGITS = 12  # of digests and commits; two of a thousand are equal by chance with a probability of 1e-9
WRITERS = {"benchmarks.harness", "benchmarks.provenance"}  # what they measure is time, which no commit repeats


def run(quick: bool, results: Path) -> None:
    """Print what has changed since each result, of those in the folder."""
    for path in sorted(results.glob("*.json")):
        document = json.loads(path.read_text(encoding="utf-8"))
        recorded = document.pop("machine", {})
        others = sorted(_commits(document) - {recorded.get("commit")})
        left = f"; rows of other commits: {', '.join(others)}" if others else ""
        if "code" not in recorded:
            print(f"{path.stem}: no record of the code")
        elif changed := stale(path.stem, recorded["code"]):
            there = [package for package in changed if package in code_digests(path.stem)]
            gone = f"; removed: {len(changed) - len(there)} packages" if len(there) < len(changed) else ""
            print(f"{path.stem}: measured at {recorded['commit']}; changed since: {', '.join(there)}{gone}{left}")
        else:
            print(f"{path.stem}: up to date{left}")


def _commits(found: Any) -> set[str]:
    """All commits of parts and rows of a result, by the keys ``commit`` and ``parts``."""
    if isinstance(found, list):
        return {commit for each in found for commit in _commits(each)}
    if not isinstance(found, dict):
        return set()
    own = {found["commit"]} if isinstance(found.get("commit"), str) else set()
    parts = found["parts"] if isinstance(found.get("parts"), dict) else {}
    own |= {commit for name, commit in parts.items() if name != "quick" and isinstance(commit, str)}
    return own | {commit for each in found.values() for commit in _commits(each)}


def stale(name: str, recorded: dict[str, str], root: Path = ROOT) -> list[str]:
    """Packages whose code is not the recorded one any more, for a result of that name."""
    now = code_digests(name, root)
    return sorted(package for package in recorded.keys() | now if recorded.get(package) != now.get(package))


@functools.cache
def commit(root: Path = ROOT) -> str:
    """Return the commit of the clone, and whether files differ from it."""

    def git(*arguments: str) -> str:
        return subprocess.run(
            ["git", "-C", root, *arguments], capture_output=True, text=True, check=True
        ).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", "lbskel", "benchmarks/*.py")
        return git("rev-parse", f"--short={DIGITS}", "HEAD") + (" with changes" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return "not in a clone"


def mesh_files(paths: Iterable[Path]) -> list[dict[str, str]]:
    """Name, SHA-256 and source of each file."""
    sources = json.loads(SOURCES.read_text(encoding="utf-8"))
    files = []
    for path in paths:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        is_own = path.absolute().parent == ROOT / "meshes"
        source = "lbskel.shapes, as meshes/README.md says" if is_own else sources.get(digest, "not known")
        files.append({"name": path.name, "sha256": digest, "source": source})
    return files


def code_digests(name: str, root: Path = ROOT) -> dict[str, str]:
    """Digest of the code of each package, of those modules that a benchmark depends on.

    A benchmark that imports no module of lbskel runs it in another way, and depends on all of them.
    """
    modules = imported_modules(f"benchmarks.{name}", root)
    if not any(module.startswith("lbskel.") for module in modules):
        modules |= {module for module in _files(root) if module.startswith("lbskel.")}
    packages: dict[str, list[str]] = {}
    for module in sorted(modules - WRITERS):
        packages.setdefault(".".join(module.split(".")[:2]), []).append(_code(_files(root)[module]))
    return {
        package: hashlib.sha256("\n\n".join(texts).encode()).hexdigest()[:DIGITS] for package, texts in packages.items()
    }


def imported_modules(name: str, root: Path = ROOT) -> set[str]:
    """Modules of lbskel and of the benchmarks that a module imports, also through others, and itself."""
    found, waiting = set(), [name]
    while waiting:
        module = waiting.pop()
        if module not in found and module in _files(root) and module != "lbskel":  # which imports nothing at once
            found.add(module)
            waiting += _imports(module, root)
    return found


@functools.cache
def _files(root: Path) -> dict[str, Path]:
    """The file of each module."""
    files = {}
    for path in [*root.glob("lbskel/**/*.py"), *root.glob("benchmarks/*.py")]:
        parts = path.relative_to(root).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return files


@functools.cache
def _public_names(root: Path) -> dict[str, str]:
    """The module of each name that lbskel exports: it imports them when they are first used."""
    return {
        alias.name: node.module or ""
        for node in ast.walk(_tree(_files(root)["lbskel"]))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


@functools.cache
def _imports(module: str, root: Path) -> Sequence[str]:
    """What a module imports: modules, names of packages that may be modules, and public names of lbskel."""
    names = []
    for node in ast.walk(_tree(_files(root)[module])):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names += [node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "lbskel":
            names.append(f"lbskel.{node.attr}")
    return [_public_names(root).get(name.removeprefix("lbskel."), name) for name in names]


@functools.cache
def _tree(path: Path) -> ast.Module:
    """Parse a module."""
    return ast.parse(path.read_text(encoding="utf-8"))


@functools.cache
def _code(path: Path) -> str:
    """Text of a module without docstrings, lines of comments and blank lines; the same with every version of Python."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            first, last = node.lineno - 1, node.end_lineno or node.lineno
            lines[first:last] = [""] * (last - first)
    return "\n".join(line.rstrip() for line in lines if line.strip() and not line.lstrip().startswith("#"))
