"""Time and memory of skeletons of clouds of up to a million points, beside the mesh with the same vertices.

Both are timed one after the other, in a process each, so that what else the machine does weighs on both alike; seconds
of the processor do not count what others do.
"""

from __future__ import annotations

__all__ = ["run"]

import resource
import time
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from lbskel.shapes import make

SIZES = {10_000: (9_700, 0), 100_000: (6_250, 2), 1_000_000: (3_910, 4)}  # vertices of limbs, and times subdivided


def run(quick: bool, results: Path) -> None:
    """Measure, and write point_times.json and point_times.md."""
    rows = [row for n in list(SIZES)[: 1 if quick else None] for row in _times(n)]
    save_json(results / "point_times.json", {"times": rows})
    save_markdown(results / "point_times.md", "Time of point clouds", {"Limbs": markdown_table(rows)})


def _times(n: int) -> list[dict[str, Any]]:
    """Time lbskel on the vertices of a shape and on their mesh, each in a process of its own."""
    import igl

    n_vertices, n_times = SIZES[n]
    mesh = make("limbs", n_vertices=n_vertices).mesh
    V, F = np.array(mesh.vertices), np.array(mesh.faces)
    for _ in range(n_times):
        V, F = igl.upsample(V, F)
    rows = []
    for kind, data in (("cloud", V), ("mesh", (V, F))):
        answer = run_in_subprocess(_timed, data, timeout=1200)
        if "error" in answer:
            rows.append({"vertices": len(V), "kind": kind, "error": answer["error"]})
        else:
            rows.append({"vertices": len(V), "kind": kind, **answer["value"]})
    return rows


def _timed(data: Any) -> dict[str, float]:
    """Seconds of the processor and of the wall clock, memory, and tips."""
    shape = lbskel.PointCloud(data) if isinstance(data, np.ndarray) else lbskel.Mesh(*data)
    cpu, wall = time.process_time(), time.perf_counter()
    skeleton = lbskel.skeletonize(shape)
    return {
        "processor seconds": time.process_time() - cpu,
        "wall seconds": time.perf_counter() - wall,
        "GB at most": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        "tips": len(skeleton.tips),
    }
