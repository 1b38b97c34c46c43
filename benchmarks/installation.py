"""Installation: sizes, seconds to build and to import, and speed with each Python and without a compiler.

A source distribution is made from the clone; wheels are made from it and installed in fresh virtual environments, with
a C compiler that fails. Everything comes from the package index by pip. Times are processor seconds of whole processes,
minima over turns: a skeleton includes the start of Python and all imports. Only the way from a clone to a picture has
wall-clock seconds too, on a machine that may do other work.
"""

from __future__ import annotations

__all__ = ["run"]

import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.installation_numba import compile_kernels
from benchmarks.installation_tools import (
    NO_COMPILER,
    ROOT,
    build_wheels,
    interpreters,
    make_environment,
    processor_seconds,
    source_distribution,
)
from lbskel.shapes import make

SIZES = (2_000, 10_000, 50_000)  # vertices of the dinosaur
TURNS, QUICK_TURNS = 3, 1
EXTRAS = ("view", "preprocess")
OTHER = "numba"  # which could compile kernels at run time

PACKAGE_SIZES = """
import json
from importlib.metadata import distributions
print(json.dumps({
    each.metadata["Name"]: sum(
        path.stat().st_size for path in map(each.locate_file, each.files or ()) if path.is_file()
    )
    for each in distributions()
}))
"""


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Build, install, measure, and write installation.json and installation.md."""
    turns = QUICK_TURNS if quick else TURNS
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = source_distribution(folder)
        sizes = _meshes(folder, SIZES[:1] if quick else SIZES)
        pythons = {sys.version.split()[0]: Path(sys.executable)} if quick else interpreters()
        wheels, builds = build_wheels(source, pythons, folder)
        environments = {version: make_environment(python, folder / version) for version, python in pythons.items()}
        versions = _each_python(environments, wheels, sizes, folder, turns)
        version = min(pythons, key=lambda each: (not each.startswith("3.11"), each))
        python = environments[version]
        packages = _packages(python, wheels[version])
        by_zig, row = _built_by_zig(source, pythons[version], folder)
        builds.append(row)
        starts = _starts(python, folder, turns)
        without = _without_compiler(python, by_zig, meshes, folder, turns)
        by_numba = compile_kernels(python, folder)
        first_run = _first_run(pythons[version], folder)
        builds.insert(0, {"what": "source distribution", "megabytes": source.stat().st_size / 1e6})
        limited = None if quick else _full_api(source, pythons[version], python, wheels[version], sizes, folder, turns)
    tables = {
        "Build": markdown_table(builds) + "\nProcessor seconds of ``pip wheel``, Cython's installation included.\n",
        "Each Python": markdown_table(versions)
        + "\nThe wheel, installed without a compiler, over a build by that Python from the source, whole commands.\n",
        "Limited API": markdown_table(limited or []) + "\nThe wheel over kernels compiled for one version of Python.\n",
        "Start": markdown_table(starts),
        "From a clone to a picture": markdown_table(first_run)
        + "\nIn an empty virtual environment; packages come from an index nearby.\n",
        "Without a C compiler": markdown_table(without)
        + "\nThe build takes ziglang from the package index, or kernels run as Python. Processor seconds.\n",
        "Kernels by numba": markdown_table(by_numba)
        + "\nSeconds in which numba's ``njit`` compiles functions of kernels, at the first call in each process.\n",
        "Packages": markdown_table(packages),
    }
    measured = {"builds": builds, "pythons": versions, "limited_api": limited, "starts": starts, "packages": packages}
    measured |= {"first_run": first_run, "without_compiler": without, "numba": by_numba}
    save_json(results / "installation.json", measured, packages=("ziglang",))
    save_markdown(results / "installation.md", "Installation", tables)


def _least(commands: Mapping[str, tuple[Sequence[str | Path], Mapping[str, str]]], turns: int) -> dict[str, float]:
    """Time commands in turns, after one that does not count, and take the least of each."""
    seconds: dict[str, list[float]] = {name: [] for name in commands}
    for turn in range(turns + 1):
        for name, (command, environment) in commands.items():
            taken = processor_seconds(command, **environment)
            if turn > 0:
                seconds[name].append(taken)
    return {name: min(each) for name, each in seconds.items()}


def _meshes(folder: Path, sizes: Sequence[int]) -> dict[str, Path]:
    """Write the dinosaur in each size."""
    paths = {}
    for n_vertices in sizes:
        mesh = make("dinosaur", n_vertices=n_vertices).mesh
        paths[f"{len(mesh.faces):,} faces"] = folder / f"{n_vertices}.ply"
        lbskel.write_mesh(folder / f"{n_vertices}.ply", mesh)
    return paths


def _installed(python: Path, what: Path, target: Path, **environment: str) -> dict[str, str]:
    """Install into a folder of its own; the variables with which Python finds it there first."""
    processor_seconds([python, "-m", "pip", "install", "--no-deps", "--target", target, what], **environment)
    return {"PYTHONPATH": str(target)}


def _skeleton(python: Path, mesh: Path) -> list[str | Path]:
    return [python, "-m", "lbskel", "skeletonize", mesh, "-o", mesh.with_suffix(".swc"), "--force"]


def _each_python(
    pythons: Mapping[str, Path], wheels: Mapping[str, Path], meshes: Mapping[str, Path], folder: Path, turns: int
) -> list[dict[str, Any]]:
    """Install the wheel with each Python, and compare it with a build from the source."""
    rows = []
    source = next((folder / "sdist").glob("*.tar.gz"))
    for version, python in pythons.items():
        processor_seconds([python, "-m", "pip", "install", wheels[version]], **NO_COMPILER)
        built = _installed(python, source, folder / f"built-{version}")
        row: dict[str, Any] = {"Python": version, "wheel": wheels[version].name.split("-", 2)[2]}
        for name, mesh in meshes.items():
            least = _least({"wheel": (_skeleton(python, mesh), {}), "source": (_skeleton(python, mesh), built)}, turns)
            row |= {f"{name}, seconds": least["wheel"], f"{name}, wheel / source": least["wheel"] / least["source"]}
        rows.append(row)
    return rows


def _full_api(
    source: Path, builder: Path, python: Path, wheel: Path, meshes: Mapping[str, Path], folder: Path, turns: int
) -> list[dict[str, Any]]:
    """Compare the wheel with kernels that are compiled for one version of Python."""
    with tarfile.open(source) as archive:
        archive.extractall(folder / "full", filter="data")
    [tree] = (folder / "full").iterdir()
    file = tree / "lbskel" / "_kernels" / "compiled_files.py"
    file.write_text(file.read_text(encoding="utf-8").replace("\nLIMITED_API = (", "\nLIMITED_API = False and ("))
    full = _installed(python, tree, folder / "full-installed")
    limited = _installed(python, wheel, folder / "limited-installed", **NO_COMPILER)
    rows = []
    for name, mesh in meshes.items():
        command = _skeleton(python, mesh)
        least = _least({"limited": (command, limited), "full": (command, full)}, turns)
        rows.append({"mesh": name, "limited API": least["limited"], "full API": least["full"]})
        rows[-1]["limited / full"] = least["limited"] / least["full"]
    return rows


def _packages(python: Path, wheel: Path) -> list[dict[str, Any]]:
    """Megabytes of lbskel, of what it needs, and of what each extra adds, as installed."""

    def sizes() -> dict[str, int]:
        done = subprocess.run([python, "-c", PACKAGE_SIZES], capture_output=True, text=True, check=True)
        found: dict[str, int] = json.loads(done.stdout)
        return {name: size for name, size in found.items() if name not in ("pip", "setuptools")}

    there = sizes()
    rows = [
        {"package": name, "megabytes": size / 1e6} for name, size in sorted(there.items(), key=lambda item: -item[1])
    ]
    rows.insert(0, {"package": "pip install lbskel, all of:", "megabytes": sum(there.values()) / 1e6})
    for added in (*EXTRAS, OTHER):
        processor_seconds([python, "-m", "pip", "install", f"{wheel}[{added}]" if added in EXTRAS else added])
        now = sizes()
        rows.append({"package": f"{added} adds", "megabytes": (sum(now.values()) - sum(there.values())) / 1e6})
        there = now
    return rows


def _starts(python: Path, folder: Path, turns: int) -> list[dict[str, Any]]:
    """Seconds to import lbskel, and of README's first command."""
    programs = ("pass", "import lbskel", "import lbskel; lbskel.skeletonize")
    commands: dict[str, Sequence[str | Path]] = {program: [python, "-c", program] for program in programs}
    commands["README's command"] = _readme_command(python, folder)
    least = _least({name: (command, {}) for name, command in commands.items()}, turns)
    return [{"what": name, "seconds": seconds} for name, seconds in least.items()]


def _readme_command(python: Path, folder: Path) -> list[str | Path]:
    mesh = folder / "dinosaur.ply"
    shutil.copy(ROOT / "meshes" / "dinosaur.ply", mesh)
    return [*_skeleton(python, mesh), "--picture", folder / "dinosaur.png"]


def _without_compiler(
    python: Path, by_zig: Path, meshes: Sequence[Path], folder: Path, turns: int
) -> list[dict[str, Any]]:
    """Seconds of README's command and of the meshes given, with kernels compiled by gcc, by zig, and as Python."""
    site = next(python.parent.parent.glob("lib/python*/site-packages"))
    uncompiled = folder / "uncompiled"
    shutil.copytree(site / "lbskel", uncompiled / "lbskel", ignore=shutil.ignore_patterns("*.so"))
    for path in (uncompiled / "lbskel" / "_kernels").glob("*.py"):
        with open(path, "a", encoding="utf-8") as file:
            file.write("# not the installed one, whose kernels would be taken\n")
    zig = _installed(python, by_zig, folder / "zig-installed", **NO_COMPILER)
    commands = {"README's command": _readme_command(python, folder)}
    for given in meshes:
        shutil.copy(given, folder / given.name)
        commands[given.name] = _skeleton(python, folder / given.name)
    rows = []
    for name, command in commands.items():
        quick = _least({"by the machine's compiler": (command, {}), "by zig": (command, zig)}, turns)
        slow = _least({"as Python": (command, {"PYTHONPATH": str(uncompiled)})}, 1)
        rows.append({"command": name, **quick, **slow})
    return rows


def _first_run(python: Path, folder: Path) -> list[dict[str, Any]]:
    """Seconds of a newcomer's way: clone, make an environment, run README's first command line."""
    clone, environment = folder / "first-clone", folder / "first-environment"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    install, command = next(line for line in readme.splitlines() if line.startswith("pip install")).split(" && ")
    activate = f". {environment}/bin/activate && cd {clone} && "
    steps: dict[str, Sequence[str | Path]] = {
        "git clone": ["git", "clone", "--quiet", ROOT, clone],
        "python -m venv": [python, "-m", "venv", environment],
        install: ["bash", "-c", activate + install],
        "lbskel skeletonize": ["bash", "-c", activate + command],
    }
    rows: list[dict[str, Any]] = []
    for name, step in steps.items():
        began = time.perf_counter()
        rows.append(
            {"step": name, "processor seconds": processor_seconds(step), "seconds": time.perf_counter() - began}
        )
    return [*rows, {"step": "in all", **{key: sum(row[key] for row in rows) for key in list(rows[0])[1:]}}]


def _built_by_zig(source: Path, python: Path, folder: Path) -> tuple[Path, dict[str, Any]]:
    """Build a wheel where no C compiler is found."""
    command: list[str | Path] = [python, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", folder / "zig", source]
    seconds = processor_seconds(command, CC="no-such-compiler")
    wheel = next((folder / "zig").glob("*.whl"))
    row = {"what": "wheel, by ziglang's compiler", "megabytes": wheel.stat().st_size / 1e6, "seconds": seconds}
    return wheel, row
