"""Every application beside the library that people use today: all benchmarks ``applications_*`` in turn."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

# A part is a module benchmarks/applications_NAME.py with ``run(quick, results, peers)``, which writes
# applications_NAME.json, .md and pictures; it runs alone too: ``python -m benchmarks applications_NAME``.
HERE = Path(__file__).parent


def parts() -> list[str]:
    """Return the names of the modules that measure one application each."""
    return sorted(path.stem for path in HERE.glob("applications_*.py"))


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Run every part."""
    for name in parts():
        import_module(f"benchmarks.{name}").run(quick, results, peers=peers)
