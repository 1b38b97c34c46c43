"""Every command of the applications on every kind of damaged mesh: a result, or one line that says why not."""

from __future__ import annotations

__all__ = ["VERBS", "attempt", "run", "write_broken"]

import contextlib
import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.corruption import QUICK, SECONDS, UNDAMAGED, Worker, damage_sections
from benchmarks.damage import DAMAGE, SHAPES, Broken, damaged, undamaged
from benchmarks.harness import save_json, save_markdown
from lbskel.cli.main import main

# The arguments of each command after the mesh; names in capitals are files that it writes.
VERBS: dict[str, tuple[str, ...]] = {
    "smooth": ("-o", "OUT.ply"),
    "edit": ("-o", "OUT.ply", "--fix", "z:0:0.2", "--move", "z:0.8:1", "--angle", "20"),
    "quantize": ("-o", "OUT.ply"),
    "compress": ("-o", "OUT.ply", "-k", "20"),
    "spectrum": ("-k", "8", "-o", "OUT.json"),
    "geodesic": ("--source", "0", "-o", "OUT.csv"),
    "branches": ("-o", "OUT.csv"),
    "segment": ("-o", "OUT.ply", "--table", "OUT.csv"),
    "rig": ("-o", "OUT.glb"),
}
OUTCOMES = {
    "result": "files that other programs read, with finite numbers (geodesic: infinite where no path leads)",
    "refused": "one line that names the defect, and no file",
    "wrong": "numbers that are not finite, a partial file, or exit code and files that disagree",
    "unexplained": "an error out of the inside of the program",
    "crash": "the process ended",
    "hang": f"over {SECONDS:.0f} s",
}


def write_broken(broken: Broken, path: Path) -> Path:
    """Write a damaged mesh to a file, arrays as OFF text without loss, and return its path with the extension."""
    if broken.extension:
        file = path.with_suffix(f".{broken.extension}")
        file.write_bytes(broken.data)
        return file
    file = path.with_suffix(".off")
    V, F = np.asarray(broken.vertices).tolist(), np.asarray(broken.faces).tolist()
    lines = ["OFF", f"{len(V)} {len(F)} 0", *(" ".join(map(repr, v)) for v in V)]
    file.write_text("\n".join([*lines, *(f"3 {' '.join(map(repr, face))}" for face in F), ""]))
    return file


def attempt(given: tuple[str, Path, Path]) -> tuple[str, str]:
    """Run a command on a mesh with a folder for its outputs; one of OUTCOMES, and what it said."""
    verb, mesh, folder = given
    arguments = [str(folder / each) if each.startswith("OUT.") else each for each in VERBS[verb]]
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        code = main([verb, str(mesh), *arguments])
    lines = said.getvalue().strip().splitlines()
    message = lines[-1] if lines else ""
    files = sorted(folder.iterdir())
    expected = sorted(Path(each) for each in arguments if Path(each).parent == folder)
    try:
        if "internal error" in message:
            return "unexplained", message
        if code == 0:
            return ("result" if files == expected and all(map(_is_finite, files)) else "wrong"), message
        return ("refused" if code == 2 and not files and len(lines) == 1 else "wrong"), message
    finally:
        for file in files:
            file.unlink()


def _is_finite(path: Path) -> bool:
    """Whether another program reads the file, and its numbers are finite; an empty field of a table is no number."""
    if path.suffix == ".csv":
        import pandas

        table = pandas.read_csv(path)
        return (
            len(table) > 0
            and "nan" not in path.read_text()
            and ("distance" in table or not np.isinf(table).any(axis=None))
        )
    if path.suffix == ".json":
        values = next(iter(json.loads(path.read_text())["values"].values()))
    else:
        import trimesh

        loaded: Any = trimesh.load(path, process=False, force="mesh")
        values = loaded.vertices
    return len(values) > 0 and bool(np.isfinite(np.asarray(values)).all())


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write applications_damage.json and .md; there are no peers."""
    kinds = QUICK if quick else tuple(DAMAGE)
    rows = []
    with tempfile.TemporaryDirectory() as temporary, Worker(attempt) as worker:
        folder = Path(temporary, "outputs")
        for shape, mesh in {name: make() for name, make in list(SHAPES.items())[: 1 if quick else None]}.items():
            for kind in (UNDAMAGED, *kinds):
                broken = undamaged(mesh) if kind == UNDAMAGED else damaged(kind, mesh)
                of = "none" if kind == UNDAMAGED else "file" if broken.extension else "mesh"
                path = write_broken(broken, Path(temporary, "broken"))
                for verb in VERBS:
                    folder.mkdir(exist_ok=True)
                    answer = worker.ask((verb, path, folder))
                    outcome, said = answer.get("value", (answer.get("outcome"), answer.get("error", "")))
                    said = said.replace(str(temporary), "")
                    row = {"verb": verb, "damage": kind, "of": of, "shape": shape, "outcome": outcome, "said": said}
                    rows.append(row)
                path.unlink()
    save_json(results / "applications_damage.json", {"rows": rows}, packages=("trimesh", "pandas"))
    sections = damage_sections(rows, "verb", OUTCOMES)
    save_markdown(results / "applications_damage.md", "Commands of the applications on broken meshes", sections)
