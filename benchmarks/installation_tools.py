"""Shared by the benchmarks of installations: distributions, interpreters, environments, and seconds of processes."""

from __future__ import annotations

__all__ = [
    "NO_COMPILER",
    "ON_ONE_THREAD",
    "ROOT",
    "build_wheels",
    "interpreters",
    "make_environment",
    "processor_seconds",
    "source_distribution",
]

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
VERSIONS = range(10, 15)  # of Python 3: those that pyproject.toml names
NO_COMPILER = {"CC": "/bin/false"}
ON_ONE_THREAD = {"OMP_NUM_THREADS": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


def processor_seconds(command: Sequence[str | Path], **environment: str) -> float:
    """Run a command on one thread, and return its processor seconds, with those of the processes that it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    variables = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(each) for each in command],
        env={**variables, **ON_ONE_THREAD, **environment},
        cwd=tempfile.gettempdir(),  # not the clone, whose package would be imported
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: {(done.stdout + done.stderr)[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def interpreters() -> dict[str, Path]:
    """The interpreters of this machine by their versions: those on the path and those of pyenv."""
    found = {}
    for minor in VERSIONS:
        of_pyenv = sorted((Path.home() / ".pyenv" / "versions").glob(f"3.{minor}.*/bin/python"))
        on_path = shutil.which(f"python3.{minor}")
        for path in [*of_pyenv[-1:], *([Path(on_path)] if on_path else [])]:
            asked = subprocess.run([path, "-V"], capture_output=True, text=True)
            if asked.returncode == 0:
                found[asked.stdout.split()[1]] = path
                break
    return found


def source_distribution(folder: Path) -> Path:
    """Make the source distribution of the clone's last commit."""
    processor_seconds(["git", "clone", "--quiet", ROOT, folder / "clone"])
    processor_seconds([sys.executable, "-m", "build", "--sdist", "--outdir", folder / "sdist", folder / "clone"])
    return next((folder / "sdist").glob("*.tar.gz"))


def build_wheels(
    source: Path, pythons: Mapping[str, Path], folder: Path
) -> tuple[dict[str, Path], list[dict[str, Any]]]:
    """The wheel for each Python, and what each took; the one of Python 3.11 serves all later ones."""
    wheels: dict[str, Path] = {}
    rows = []
    for version, python in pythons.items():
        limited = next((wheel for wheel in wheels.values() if "abi3" in wheel.name), None)
        if limited is None:
            out = folder / f"wheel-{version}"
            seconds = processor_seconds([python, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", out, source])
            wheels[version] = next(out.glob("*.whl"))
            size = wheels[version].stat().st_size / 1e6
            rows.append({"what": wheels[version].name, "megabytes": size, "seconds": seconds})
        else:
            wheels[version] = limited
    return wheels, rows


def make_environment(python: Path, folder: Path) -> Path:
    """Make a virtual environment, and return its interpreter."""
    processor_seconds([python, "-m", "venv", folder])
    return folder / "bin" / "python"
