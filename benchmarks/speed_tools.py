"""What the speed benchmark runs in a process each: a mesh's path in, seconds, memory and a score out.

Seconds are the processor's, which others that run on the machine do not count in.
"""

from __future__ import annotations

__all__ = ["LIMITS", "TOOLS"]

import importlib
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.cgal import cgal_seconds
from benchmarks.peers import Graph, pygel_separators, skeletor_edge_collapse

SCORED = {  # measures of lbskel.score by their names in the results, where coverage is that of the known axis
    "inside_fraction": "inside_fraction",
    "centeredness_error": "centeredness_error",
    "surface_coverage": "coverage",
}
MOST_SCORED = 400_000  # faces of a mesh that skeletons of others are scored on, since that takes longer than they do


def _peak() -> float:
    """Megabytes that this process has held at most; getrusage would count what it was forked from."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    kilobytes = next(line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kilobytes) * 1024 / 1e6


def _lbskel(mesh: Path, **options: Any) -> dict[str, Any]:
    """Reading included, which is told apart."""
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
        **_beside_truth(skeleton, mesh),
    }


def _beside_truth(skeleton: lbskel.Skeleton, mesh: Path) -> dict[str, Any]:
    """Distances to the known axis, if that lies beside the mesh in a file."""
    if not mesh.with_suffix(".npz").exists():
        return {}
    comparison = lbskel.ground_truth_distances(skeleton, lbskel.read_skeleton(mesh.with_suffix(".npz")))
    return {"accuracy": comparison.accuracy, "coverage": comparison.coverage}


def _peer(tool: Callable[..., Graph], mesh: Path) -> dict[str, Any]:
    """The mesh is read by lbskel; scored afterwards, which does not count."""
    began = time.process_time()
    read = lbskel.read_mesh(mesh)
    reading = time.process_time() - began
    nodes, edges = tool(np.array(read.vertices), np.array(read.faces))
    seconds, megabytes = time.process_time() - began, _peak()
    return {"seconds": seconds, "read": reading, "megabytes": megabytes, **_scored(nodes, edges, read, mesh)}


def _cgal(kind: str, mesh: Path) -> dict[str, Any]:
    """The seconds that the driver tells, and the memory of its process."""
    read = lbskel.read_mesh(mesh)
    (nodes, edges), (reading, seconds, megabytes) = cgal_seconds(read.vertices, read.faces, kind)
    return {"seconds": reading + seconds, "read": reading, "megabytes": megabytes, **_scored(nodes, edges, read, mesh)}


def _scored(nodes: np.ndarray, edges: np.ndarray, mesh: lbskel.Mesh, path: Path) -> dict[str, Any]:
    """The score of a bare graph: each vertex belongs to the nearest node, radii are inscribed."""
    from scipy.spatial import cKDTree

    from lbskel.geometry.surface_queries import Surface
    from lbskel.refinement.radii import inscribed_radii

    graph = lbskel.Skeleton(nodes, edges, np.zeros(len(nodes)))
    told = {"nodes": len(graph.nodes), "cycles": graph.cycle_rank, **_beside_truth(graph, path)}
    if len(mesh.faces) > MOST_SCORED or len(edges) == 0:
        return told
    mapped = lbskel.Skeleton(nodes, edges, np.zeros(len(nodes)), cKDTree(nodes).query(mesh.vertices)[1])
    scored = lbskel.score(inscribed_radii(mapped, Surface(mesh)), mesh).report()
    return {**told, **{name: scored["measures"][measure] for name, measure in SCORED.items()}}


def _reading(mesh: Path) -> dict[str, Any]:
    """Reading alone."""
    began = time.process_time()
    lbskel.read_mesh(mesh)
    seconds = time.process_time() - began
    return {"seconds": seconds, "read": seconds, "megabytes": _peak()}


def _simplifying(mesh: Path) -> dict[str, Any]:
    """Reading and simplifying to what the default contracts, with all checks of it."""
    from lbskel.preprocess import simplify_to_proxy

    began = time.process_time()
    read = lbskel.read_mesh(mesh)
    reading = time.process_time() - began
    simplify_to_proxy(read)
    return {"seconds": time.process_time() - began, "read": reading, "megabytes": _peak()}


def _factorising(mesh: Path) -> dict[str, Any]:
    """What the factorisations of a full contraction that merges nothing take by themselves."""
    from dataclasses import replace

    contraction: Any = importlib.import_module("lbskel.contraction.flow")  # its factorize is replaced by a timed one

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
