"""Every application beside the libraries that people use today: all benchmarks ``applications_*`` in turn."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

# A part is a module benchmarks/applications_NAME.py with ``run(quick, results, peers)``, or with meshes, which writes
# applications_NAME.json, .md and pictures; it runs alone too: ``python -m benchmarks applications_NAME``.
HERE = Path(__file__).parent


def parts() -> list[str]:
    """Return the names of the modules that measure one application each."""
    return sorted(path.stem for path in HERE.glob("applications_*.py"))


def run(quick: bool, results: Path, peers: bool = False, meshes: list[Path] | None = None) -> None:
    """Run every part; those that take further meshes get them."""
    for name in parts():
        run_part = import_module(f"benchmarks.{name}").run
        further = {"meshes": meshes} if "meshes" in inspect.signature(run_part).parameters else {}
        run_part(quick, results, peers=peers, **further)
