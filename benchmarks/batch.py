"""A batch of many small shapes, one in a hundred broken, whose worker process is killed half-way, and its second run.

Every input must have a record. The second run must repeat only the input whose process was killed. Throughput is that
of one process at a time, on one thread.
"""

from __future__ import annotations

__all__ = ["run"]

import os
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.pipeline.batch import BatchStatus, Record
from lbskel.shapes import capsule, make, torus

INPUTS, QUICK = 10_000, 60
BROKEN = 100  # one input in so many is a broken file
SEED = 0

BROKEN_FILES: Sequence[bytes] = (
    b"",
    b"OFF\n4 4 0\n0 0 0\n1 0",
    b"OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
    b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n",
    b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
)


def run(quick: bool, results: Path) -> None:
    """Measure, and write batch.json and batch.md."""
    n_inputs = QUICK if quick else INPUTS
    with tempfile.TemporaryDirectory() as folder:
        inputs, output = Path(folder) / "in", Path(folder) / "out"
        faces = _write_inputs(inputs, n_inputs)
        paths = sorted(inputs.iterdir())
        first = _timed(paths, output, kill_at=n_inputs // 2)
        second = _timed(paths, output)
    rows = [
        {
            "run": "first, a process killed half-way",
            "inputs": n_inputs,
            "faces of a shape": f"{min(faces)}-{max(faces)}",
        }
        | first,
        {"run": "again", "inputs": n_inputs} | second,
    ]
    save_json(results / "batch.json", {"rows": rows}, packages=("dask", "distributed"))
    save_markdown(results / "batch.md", "Many meshes", {"One process at a time": markdown_table(rows)})


def _write_inputs(folder: Path, n_inputs: int) -> list[int]:
    """Write randomly stretched shapes and broken files; return the numbers of faces of the shapes."""
    folder.mkdir()
    rng = np.random.default_rng(SEED)
    shapes = [
        make("tripod", n_vertices=400).mesh,
        torus(1.0, 0.25, 24, 12),
        capsule(3.0, 0.4, 14),
        capsule(2.0, 0.5, 16),
    ]
    for index in range(n_inputs):
        path = folder / f"{index:05d}.off"
        stretch = rng.uniform(0.8, 1.25, size=3)
        if index % BROKEN == BROKEN // 2:
            path.write_bytes(BROKEN_FILES[index // BROKEN % len(BROKEN_FILES)])
        else:
            shape = shapes[index % len(shapes)]
            lbskel.write_mesh(path, shape.with_vertices(shape.vertices * stretch))
    return [len(shape.faces) for shape in shapes]


def _timed(paths: list[Path], output: Path, kill_at: int | None = None) -> dict[str, Any]:
    """Run a batch with one worker, whose process is killed after ``kill_at`` records."""
    done: list[bool] = []

    def on_record(record: Record, is_old: bool) -> None:
        done.append(is_old)
        if len(done) == kill_at:
            for process in _children():
                os.kill(process, signal.SIGKILL)

    began = time.perf_counter()
    records = lbskel.skeletonize_many(paths, output, workers=1, on_record=on_record)
    seconds = time.perf_counter() - began
    n_made = done.count(False)
    return {
        "accounted for": len(records),
        **{outcome.value: Counter(record.outcome for record in records)[outcome] for outcome in BatchStatus},
        "not done again": done.count(True),
        "seconds": seconds,
        "a second": n_made / seconds,
    }


def _children() -> list[int]:
    """List the child processes of this process."""
    return [int(child) for path in Path("/proc/self/task").glob("*/children") for child in path.read_text().split()]
