"""Processor seconds, memory and score of whole skeletons from 5,000 to 5 million faces, in one run.

Each run is a process of its own that reads the mesh from a file; start-up and imports do not count. Runs of one size
are taken in turns, tool by tool. A failure or a run over the time limit is a row that says so, and a tool that reached
the time limit is not run at larger sizes. The shape at every size is followed by the meshes of a folder given with
--meshes. The last rows of each mesh are lower bounds: the time to read the file, to simplify the mesh too, and to
factorize the systems of the steps.
"""

from __future__ import annotations

__all__ = ["run"]

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import fast_simplification
import igl
import numpy as np

import lbskel
from benchmarks.cgal import driver
from benchmarks.harness import machine, markdown_table, run_in_subprocess, save_json, save_markdown, save_picture
from benchmarks.speed_tools import LIMITS, SCORED, TOOLS
from lbskel.shapes import make

SIZES = (5_000, 50_000, 90_000, 350_000, 1_400_000, 5_000_000)
QUICK = (2_000, 5_000)
SHAPE = "dinosaur"  # its name in the catalog
ALLOWED = 150.0  # wall seconds for one run; a guess
TURNS = {5_000: 3}  # runs by number of faces; one for larger sizes
DIRECT = 50_000  # faces up to which the shape is meshed directly; larger meshes are subdivided and simplified
REPORTED = ("nodes", "cycles", "accuracy", "coverage", *SCORED)


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write speed.json, speed.md and speed.png."""
    rows: list[dict[str, Any]] = []
    late: set[str] = set()
    try:
        driver()
    except RuntimeError as error:
        print(error, file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        for n_faces in QUICK if quick else SIZES:
            mesh = Path(folder) / f"{n_faces}.ply"
            _write_shape(mesh, n_faces)
            rows += _rows(mesh, SHAPE, n_faces, 1 if quick else TURNS.get(n_faces, 1), late)
            late |= {row["tool"] for row in rows if "over" in str(row.get("error"))}
            mesh.unlink()
            _write(rows, results, meshes)
    for mesh in meshes:
        n_faces = len(lbskel.read_mesh(mesh).faces)
        rows += _rows(mesh, mesh.name, n_faces, 1 if quick or n_faces > DIRECT else 3, set())
        _write(rows, results, meshes)


def _write_shape(path: Path, n_faces: int) -> None:
    """Write the mesh, and a file with its known axis next to it."""
    shape = make(SHAPE, n_vertices=min(n_faces, DIRECT) // 2)
    V, F = np.array(shape.mesh.vertices), np.array(shape.mesh.faces)
    while len(F) < 0.9 * n_faces:
        V, F = igl.loop(V, F)
    if len(F) > 1.2 * n_faces:
        V, F = fast_simplification.simplify(V, F, target_count=n_faces)
    lbskel.write_mesh(path, lbskel.Mesh(V, F))
    lbskel.write_skeleton(path.with_suffix(".npz"), shape.truth)


def _rows(mesh: Path, name: str, n_faces: int, turns: int, late: set[str]) -> list[dict[str, Any]]:
    """Run all tools on one mesh, in turns."""
    tools = {**TOOLS, **LIMITS}
    answers: dict[str, list[dict[str, Any]]] = {tool: [] for tool in tools if tool not in late}
    for _ in range(turns):
        for tool, taken in answers.items():
            if not any("error" in answer for answer in taken):
                taken.append(run_in_subprocess(tools[tool], mesh, timeout=ALLOWED))
                print(
                    f"{n_faces:>9,} faces  {tool:<16} {taken[-1].get('error') or taken[-1]['seconds']}", file=sys.stderr
                )
    rows: list[dict[str, Any]] = []
    for tool in tools:
        row: dict[str, Any] = {"mesh": name, "faces": n_faces, "tool": tool}
        if tool in late:
            rows.append({**row, "error": f"over {ALLOWED:g} s at a smaller size"})
        elif failed := [answer for answer in answers[tool] if "error" in answer]:
            rows.append({**row, "error": failed[0]["error"]})
        else:
            values = [answer["value"] for answer in answers[tool]]
            rows.append(
                row
                | {name: float(np.median([value[name] for value in values])) for name in ("seconds", "read")}
                | {"megabytes": max(value["megabytes"] for value in values), "turns": turns}
                | {name: values[0].get(name) for name in REPORTED}
            )
    return rows


def _exponents(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Fit p of seconds ~ faces^p for each tool, over the sizes from 50,000 faces that it managed."""
    found = []
    for tool in (*TOOLS, *LIMITS):
        own = [row for row in _of_shape(rows, tool) if row["faces"] >= 50_000]
        if len(own) >= 2:
            slope = np.polyfit(np.log([row["faces"] for row in own]), np.log([row["seconds"] for row in own]), 1)[0]
            found.append({"tool": tool, "sizes": len(own), "exponent": float(slope)})
    return found


def _of_shape(rows: list[dict[str, Any]], tool: str) -> list[dict[str, Any]]:
    """Select the rows of a tool on the shape that is measured at every size."""
    return [row for row in rows if row["tool"] == tool and row["mesh"] == SHAPE and "seconds" in row]


def _ratios(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Compute the seconds of each tool over those of lbskel at the same size."""
    seconds = {(row["mesh"], row["faces"], row["tool"]): row.get("seconds") for row in rows}
    table = []
    for mesh, faces in dict.fromkeys((row["mesh"], row["faces"]) for row in rows):
        for ours in ("lbskel", "lbskel full"):
            own = seconds.get((mesh, faces, ours))
            others = {tool: seconds.get((mesh, faces, tool)) for tool in TOOLS if not tool.startswith("lbskel")}
            ratios = {
                f"{tool} / {ours}"[: len(tool)]: taken / own if own and taken else None
                for tool, taken in others.items()
            }
            table.append({"mesh": mesh, "faces": faces, "reference": ours, **ratios})
    return table


def _write(rows: list[dict[str, Any]], results: Path, meshes: Sequence[Path]) -> None:
    """Write what is measured so far."""
    save_json(
        results / "speed.json",
        {"rows": rows, "exponents": _exponents(rows), "ratios": _ratios(rows)},
        packages=("skeletor", "PyGEL3D", "CGAL"),
        meshes=meshes,
    )
    save_markdown(
        results / "speed.md",
        "Speed",
        {
            "Seconds of others over those of lbskel": markdown_table(_ratios(rows)),
            "Medians; processor seconds with reading, without the start of the process": markdown_table(rows),
            "Fitted exponents: seconds ~ faces^p": markdown_table(_exponents(rows)),
        },
    )
    save_picture(results / "speed.png", lambda figure: _plot(figure, rows))


def _plot(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    for tool in (*TOOLS, *LIMITS):
        own = _of_shape(rows, tool)
        style = "--" if tool in LIMITS else "-"
        width = 2.5 if tool.startswith("lbskel") else 1.2
        axes.loglog([row["faces"] for row in own], [row["seconds"] for row in own], f"o{style}", label=tool, lw=width)
    axes.set(xlabel="faces", ylabel="processor seconds", title=f"One skeleton, {machine()['processor']}, one thread")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=8)
