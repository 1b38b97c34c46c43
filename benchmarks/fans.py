"""Fans: time and memory of applications that square the Laplacian, where a vertex has thousands of neighbors.

The mesh is a tube whose two ends are closed by fans, as caps of CAD models are. Each call has a process of its own.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from lbskel.preprocess.holes import close_holes
from lbskel.shapes import cylinder

SIDES = (500, 1000, 2000, 4000)  # of the tube: triangles of each fan
RINGS = 6


def run(quick: bool, results: Path) -> None:
    """Measure, and write fans.json and fans.md."""
    rows = [_row(sides, name) for sides in SIDES[: 1 if quick else None] for name in CALLS]
    save_json(results / "fans.json", {"fans": rows})
    save_markdown(results / "fans.md", "Fans", {"Time and memory": markdown_table(rows)})


def _closed_tube(sides: int) -> lbskel.Mesh:
    """Mesh a tube whose ends are fans around a vertex each."""
    return close_holes(cylinder(1.0, 2.0, sides, RINGS), max_perimeter=10.0).mesh


def _smooth(sides: int, method: str) -> None:
    lbskel.smooth(_closed_tube(sides), method=method)


def _edit(sides: int, method: str) -> None:
    mesh = _closed_tube(sides)
    z = mesh.vertices[:, 2]
    turn = lbskel.rigid_motion(axis=[0, 0, 1], angle_deg=20)
    lbskel.edit(mesh, [np.flatnonzero(z < -0.9), np.flatnonzero(z > 0.9)], [np.eye(4), turn], method=method)


def _quantize(sides: int, _: str) -> None:
    lbskel.quantize_deltas(_closed_tube(sides))


CALLS: dict[str, tuple[Callable[[int, str], None], str]] = {
    "smooth, bilaplacian": (_smooth, "bilaplacian"),
    "smooth, implicit": (_smooth, "implicit"),
    "edit, rotated": (_edit, "rotated"),
    "edit, harmonic": (_edit, "harmonic"),
    "quantize": (_quantize, ""),
}


def _row(sides: int, name: str) -> dict[str, Any]:
    """Measure one call."""
    call, method = CALLS[name]
    answer = run_in_subprocess(call, sides, method)
    row: dict[str, Any] = {"triangles of a fan": sides, "call": name, "seconds": answer["seconds"]}
    if "error" in answer:
        return {**row, "error": answer["error"]}
    # of both fans: what a larger one takes follows from it
    return {**row, "megabytes": answer["megabytes"], "bytes / square": 1e6 * answer["megabytes"] / (2 * sides**2)}
