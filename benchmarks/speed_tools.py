"""Runs of the speed benchmark, each in a process of its own: from the path of a mesh to seconds, memory and score.

Seconds are processor seconds, which other load on the machine does not count in.
"""

from __future__ import annotations

__all__ = ["LIMITS", "TOOLS"]

import importlib
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.cgal import cgal_seconds
from benchmarks.peers import Graph, pygel_separators, skeletor_edge_collapse
from lbskel.shapes import torus

SCORED = {  # measures of lbskel.score by their names in the results, where "coverage" is that of the known axis
    "inside_fraction": "inside_fraction",
    "centeredness_error": "centeredness_error",
    "surface_coverage": "coverage",
}
# Faces of a mesh on which skeletons of other tools are scored: on larger ones the score takes longer than the tool
MAX_SCORED_FACES = 400_000


def _peak() -> float:
    """Return the peak memory of this process in megabytes; getrusage would include its parent's."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    kilobytes = next(line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kilobytes) * 1024 / 1e6


def _warm(mesh: Path, call: Callable[[lbskel.Mesh], Any]) -> None:
    """Read a small mesh of the same format and call once: packages are imported when they are first used."""
    importlib.import_module("fast_simplification")  # which no small mesh needs
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"small{mesh.suffix}"
        lbskel.write_mesh(path, torus(1.0, 0.3, 24, 12))
        with suppress(Exception):  # of a tool that makes nothing of it
            call(lbskel.read_mesh(path))


def _lbskel(mesh: Path, **options: Any) -> dict[str, Any]:
    """Measure lbskel, with the time of reading apart."""
    _warm(mesh, lambda small: lbskel.skeletonize(small, **options))
    began = time.process_time()
    read = lbskel.read_mesh(mesh)
    reading = time.process_time() - began
    skeleton = lbskel.skeletonize(read, **options)
    seconds = time.process_time() - began
    report = skeleton.report
    return {
        "seconds": seconds,
        "read": reading,
        "megabytes": _peak(),
        "nodes": len(skeleton.nodes),
        "cycles": skeleton.cycle_rank,
        **{name: report["score"]["measures"][measure] for name, measure in SCORED.items()},
        **_distances_to_truth(skeleton, mesh),
    }


def _distances_to_truth(skeleton: lbskel.Skeleton, mesh: Path) -> dict[str, Any]:
    """Measure distances to the known axis, if there is a file of it next to the mesh."""
    if not mesh.with_suffix(".npz").exists():
        return {}
    comparison = lbskel.ground_truth_distances(skeleton, lbskel.read_skeleton(mesh.with_suffix(".npz")))
    return {"accuracy": comparison.accuracy, "coverage": comparison.coverage}


def _peer(tool: Callable[..., Graph], mesh: Path) -> dict[str, Any]:
    """Measure another tool on a mesh read by lbskel; its score is not timed."""
    _warm(mesh, lambda small: tool(np.array(small.vertices), np.array(small.faces)))
    began = time.process_time()
    read = lbskel.read_mesh(mesh)
    reading = time.process_time() - began
    nodes, edges = tool(np.array(read.vertices), np.array(read.faces))
    seconds, megabytes = time.process_time() - began, _peak()
    return {"seconds": seconds, "read": reading, "megabytes": megabytes, **_scored(nodes, edges, read, mesh)}


def _cgal(kind: str, mesh: Path) -> dict[str, Any]:
    """Measure CGAL by the seconds that the driver reports and the memory of its process."""
    read = lbskel.read_mesh(mesh)
    (nodes, edges), (reading, seconds, megabytes) = cgal_seconds(read.vertices, read.faces, kind)
    return {"seconds": reading + seconds, "read": reading, "megabytes": megabytes, **_scored(nodes, edges, read, mesh)}


def _scored(nodes: np.ndarray, edges: np.ndarray, mesh: lbskel.Mesh, path: Path) -> dict[str, Any]:
    """Score a bare graph: each vertex is mapped to the nearest node, radii are inscribed."""
    from scipy.spatial import cKDTree

    from lbskel.geometry.surface_queries import Surface
    from lbskel.refinement.radii import inscribed_radii

    graph = lbskel.Skeleton(nodes, edges, np.zeros(len(nodes)))
    row = {"nodes": len(graph.nodes), "cycles": graph.cycle_rank, **_distances_to_truth(graph, path)}
    if len(mesh.faces) > MAX_SCORED_FACES or len(edges) == 0:
        return row
    mapped = lbskel.Skeleton(nodes, edges, np.zeros(len(nodes)), cKDTree(nodes).query(mesh.vertices)[1])
    scored = lbskel.score(inscribed_radii(mapped, Surface(mesh)), mesh).report()
    return {**row, **{name: scored["measures"][measure] for name, measure in SCORED.items()}}


def _reading(mesh: Path) -> dict[str, Any]:
    """Time reading alone."""
    _warm(mesh, lambda small: None)
    began = time.process_time()
    lbskel.read_mesh(mesh)
    seconds = time.process_time() - began
    return {"seconds": seconds, "read": seconds, "megabytes": _peak()}


def _simplifying(mesh: Path) -> dict[str, Any]:
    """Time reading and simplification to the proxy, with its checks."""
    from lbskel.preprocess import simplify_to_proxy

    _warm(mesh, simplify_to_proxy)
    began = time.process_time()
    read = lbskel.read_mesh(mesh)
    reading = time.process_time() - began
    simplify_to_proxy(read)
    return {"seconds": time.process_time() - began, "read": reading, "megabytes": _peak()}


def _factorising(mesh: Path) -> dict[str, Any]:
    """Time the factorizations alone of a contraction of every vertex without edge collapses."""
    from dataclasses import replace

    contraction: Any = importlib.import_module("lbskel.contraction.flow")  # whose factorize is replaced by a timed one

    seconds = 0.0
    factorize = contraction.factorize

    def timed(*arguments: Any, **options: Any) -> Any:
        nonlocal seconds
        began = time.process_time()
        made = factorize(*arguments, **options)
        seconds += time.process_time() - began
        return made

    contraction.factorize = timed
    lbskel.contract(lbskel.read_mesh(mesh), replace(lbskel.PRESETS["curvature_flow"], collapse_length=0.0))
    return {"seconds": seconds, "read": 0.0, "megabytes": _peak()}


Tool = Callable[[Path], dict[str, Any]]

TOOLS: dict[str, Tool] = {
    "lbskel": _lbskel,
    "lbskel full": partial(_lbskel, simplify="none"),
    "lbskel least_squares": partial(_lbskel, preset="least_squares"),
    "CGAL medial": partial(_cgal, "medial"),
    "PyGEL3D": partial(_peer, pygel_separators),
    "skeletor": partial(_peer, skeletor_edge_collapse),
}

LIMITS: dict[str, Tool] = {
    "reading": _reading,
    "and simplifying": _simplifying,
    "factorisations": _factorising,
}
