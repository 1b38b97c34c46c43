"""Proxies of shapes with many thin parts: collapses of edges that are short in local radii, and quadric errors.

The shapes are trees of vessels, and the tubes around parts of the five tracings that navis ships, meshed by voxels that
are fine, as those of an electron microscope are. Other values of ``SHORT_EDGE`` are measured, and the proxies that
quadric errors make with as many faces as the default estimates. Seconds are processor seconds. The memory is the peak
of a run in a process of its own, without the libraries, and the estimate by which a run is refused.
"""

from __future__ import annotations

__all__ = ["run"]

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import igl
import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, peak_growth, run_in_subprocess, save_json, save_markdown
from benchmarks.neurons import PART_TIPS, QUICK_TIPS, hemibrain_neurons, remeshed, tube_row, tubes_around
from benchmarks.thin_tools import Answer
from benchmarks.vessels import TREES
from benchmarks.voxels import voxel_body
from lbskel.pipeline.memory import LIBRARIES, PER_MILLION_FACES, megabytes_needed
from lbskel.preprocess import proxy, simplify
from lbskel.shapes import Shape, vessel_tree

LENGTHS = (0.2, 0.25, 0.3, 0.375, 0.45, 0.55, 0.75)  # swept: SHORT_EDGE
QUADRICS = "quadric errors"
VOXEL = 0.25  # in median radii
MEANS = ("accuracy", "coverage", "mean radius error to the mesh", "tips found", "cpu seconds")


def run(quick: bool, results: Path) -> None:
    """Measure, and write proxies.json and proxies.md."""
    trees = [vessel_tree(n, min_radius=radius, seed=seed) for n, radius, seed in (TREES[:1] if quick else TREES[1:])]
    tracings = [tracing for _, _, tracing in hemibrain_neurons(1 if quick else 5)]
    tubes = [remeshed(tubes_around(tracing, QUICK_TIPS if quick else PART_TIPS)) for tracing in tracings]
    bodies = [voxel_body(shape, VOXEL) for shape in tubes]
    largest = max((body.mesh for body in bodies), key=lambda mesh: len(mesh.faces))
    large = [largest, lbskel.Mesh(*igl.upsample(largest.vertices, np.array(largest.faces), 1))]
    values: list[float | str] = [QUADRICS, *LENGTHS[-2:]] if quick else [QUADRICS, *LENGTHS]
    tables = {
        "Trees of vessels, means": [_row(trees, value) for value in values],
        "Voxels in tubes around tracings, means": [_row(bodies, value) for value in values],
        "Memory of the largest of these": [_row_of_memory(mesh, how) for mesh in large for how in PER_MILLION_FACES],
    }
    save_json(results / "proxies.json", tables, packages=("navis",))
    save_markdown(results / "proxies.md", "Proxies", {title: markdown_table(rows) for title, rows in tables.items()})


def _row(shapes: list[Shape], value: float | str) -> dict[str, Any]:
    """Measure the skeletons of shapes, and the faces that are contracted, with one kind of proxy."""
    with _proxies(value):
        rows = [tube_row(shape.name, "lbskel", shape, _answer(shape.mesh)) for shape in shapes]
        n_faces = [sum(len(body.proxy.mesh.faces) for body in lbskel.prepare(shape.mesh).bodies) for shape in shapes]
    counts = {key: np.array([[int(n) for n in row[key].split("/")] for row in rows]) for key in ("sections", "tips")}
    off = np.abs(counts["sections"][:, 0] / counts["sections"][:, 1] - 1)
    return {
        "SHORT_EDGE": value,
        "faces": int(np.mean([len(shape.mesh.faces) for shape in shapes])),
        "faces of the proxy": int(np.mean(n_faces)),
        **{key: "/".join(map(str, each.sum(axis=0))) for key, each in counts.items()},
        "sections off": float(off.mean()),
        "length error": float(np.mean([abs(row["length error"]) for row in rows])),
        **{key: _mean([row[key] for row in rows if row[key] is not None]) for key in MEANS},
        "failed": sum(row["verdict"] == "fail" for row in rows),
    }


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _row_of_memory(mesh: lbskel.Mesh, simplify: str) -> dict[str, Any]:
    result = run_in_subprocess(_megabytes, np.array(mesh.vertices), np.array(mesh.faces), simplify)
    return {
        "faces": len(mesh.faces),
        "simplify": simplify,
        "megabytes": result.get("value"),
        "estimate": megabytes_needed(len(mesh.faces), simplify) - LIBRARIES,
    }


def _megabytes(V: NDArray[np.float64], F: NDArray[np.int64], simplify: str) -> float | None:
    return peak_growth(lambda: lbskel.skeletonize((V, F), simplify=simplify))


def _answer(mesh: lbskel.Mesh) -> Answer:
    began = time.process_time()
    skeleton = lbskel.skeletonize((mesh.vertices, mesh.faces))
    return Answer(skeleton, time.process_time() - began, skeleton.report["score"]["verdict"])


@contextmanager
def _proxies(value: float | str) -> Iterator[None]:
    """Make proxies with another length of the edges that collapse, or by quadric errors."""

    def by_quadrics(mesh: lbskel.Mesh) -> Any:
        return simplify(mesh, target_faces=proxy.face_budget(mesh))

    name, other = ("_collapse_short_edges", by_quadrics) if value == QUADRICS else ("SHORT_EDGE", value)
    with mock.patch.object(proxy, name, other):
        yield
