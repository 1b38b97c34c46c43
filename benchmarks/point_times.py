"""Time and memory of skeletons of clouds of up to a million points, beside the mesh with the same vertices.

Both are timed one after the other, each in its own process, so that other load affects both alike; processor seconds do
not count the work of others. The first time in a process includes imports; the least of further times in the same
process does not, and its ratio to that of the mesh is measured on several shapes.
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
SHAPES = ("limbs", "tree", "octopus", "knot", "ladder", "hand", "dumbbell")  # with the first size of limbs
N_AGAIN = 3  # further times in a process, one of clouds of more than the first size


def run(quick: bool, results: Path) -> None:
    """Measure, and write point_times.json and point_times.md."""
    rows = [row for n in list(SIZES)[: 1 if quick else None] for row in _times(n)]
    ratios = [_ratios(name) for name in SHAPES[: 1 if quick else None]]
    values = [row["ratio again"] for row in ratios if "ratio again" in row]
    ratios.append({"shape": "median", "ratio again": float(np.median(values)) if values else None})
    save_json(results / "point_times.json", {"times": rows, "shapes": ratios})
    tables = {"Limbs": markdown_table(rows), "Cloud beside mesh, 10,000 vertices": markdown_table(ratios)}
    save_markdown(results / "point_times.md", "Time of point clouds", tables)


def _ratios(name: str) -> dict[str, Any]:
    """Processor seconds of the vertices of a shape and of their mesh, the first time in a process and again."""
    cloud, mesh = _times(10_000, name)
    row = {"shape": name, "vertices": cloud["vertices"]}
    if "error" in cloud or "error" in mesh:
        return {**row, "error": cloud.get("error", mesh.get("error"))}
    again = {"cloud again": cloud["again"], "mesh again": mesh["again"], "ratio again": cloud["again"] / mesh["again"]}
    return {**row, "ratio first": cloud["processor seconds"] / mesh["processor seconds"], **again}


def _times(n: int, name: str = "limbs") -> list[dict[str, Any]]:
    """Time lbskel on the vertices of a shape and on their mesh, each in a process of its own."""
    import igl

    n_vertices, n_times = SIZES[n]
    mesh = make(name, n_vertices=n_vertices).mesh
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
    shape = _shape(data)
    cpu, wall = time.process_time(), time.perf_counter()
    skeleton = lbskel.skeletonize(shape)
    row = {
        "processor seconds": time.process_time() - cpu,
        "wall seconds": time.perf_counter() - wall,
        "GB at most": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        "tips": len(skeleton.tips),
    }
    again = []
    for _ in range(N_AGAIN if len(skeleton.node_of_vertex) <= 10_000 else 1):
        shape = _shape(data)  # as new, without what is kept for the next call
        cpu = time.process_time()
        lbskel.skeletonize(shape)
        again.append(time.process_time() - cpu)
    return {**row, "again": min(again)}


def _shape(data: Any) -> lbskel.PointCloud | lbskel.Mesh:
    """Cloud of points, or mesh of vertices and faces."""
    return lbskel.PointCloud(data) if isinstance(data, np.ndarray) else lbskel.Mesh(*data)
