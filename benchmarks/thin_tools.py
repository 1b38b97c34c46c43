"""Tools that make skeletons of neurons and vessels, each in a process of its own, timed in processor seconds.

A tool is called once on a small mesh before the clock starts, so that imports and compilation are not in its seconds.
"""

from __future__ import annotations

__all__ = ["OURS", "TOOLS", "Answer", "ask"]

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.cgal import Graph, cgal_seconds
from benchmarks.harness import run_in_subprocess
from benchmarks.peers import pygel_separators, skeletor_edge_collapse, swc_graph
from lbskel.shapes import tube

TIME_LIMIT = 200.0  # seconds for a tool on one mesh
# Distance that TEASAR takes out around each path, in mean radii 2 V / A; a guess: its documentation names no default.
INVALIDATED = 5.0


@dataclass(frozen=True, eq=False)
class Answer:
    """A skeleton, and what the tool said of it.

    ``seconds`` are of the processor; ``verdict`` is None and the radii are NaN where a tool has none.
    """

    skeleton: lbskel.Skeleton
    seconds: float
    verdict: str | None = None


def _lbskel(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Answer:
    began = time.process_time()
    skeleton = lbskel.skeletonize((vertices, faces))
    return Answer(skeleton, time.process_time() - began, skeleton.report["score"]["verdict"])


def _timed(tool: Callable[..., Graph]) -> Callable[..., Answer]:
    """Make a tool of a function that returns nodes and edges."""

    def call(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Answer:
        began = time.process_time()
        graph = tool(vertices, faces)
        return Answer(_bare(graph), time.process_time() - began)

    return call


def _cgal(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Answer:
    """Call CGAL's driver, which times itself."""
    graph, (reading, seconds, _) = cgal_seconds(vertices, faces, "medial")
    return Answer(_bare(graph), reading + seconds)


def _bare(graph: Graph) -> lbskel.Skeleton:
    """Build a skeleton without radii of a graph, without nodes at no place."""
    nodes, edges = np.asarray(graph[0], dtype=np.float64), np.asarray(graph[1], dtype=np.int64).reshape(-1, 2)
    finite = np.asarray(np.isfinite(nodes).all(axis=1))
    row = np.cumsum(finite) - 1
    kept = row[edges[finite[edges].all(axis=1)]]
    return lbskel.Skeleton(nodes[finite], kept, np.full(finite.sum(), np.nan))


def _skeletor(method: str, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Fix the mesh as skeletor's documentation shows for neurons, and make a skeleton by waves or by TEASAR."""
    import skeletor
    import trimesh

    mesh = skeletor.pre.fix_mesh(trimesh.Trimesh(vertices, faces, process=False), remove_disconnected=5, inplace=False)
    if method == "wavefront":
        skeleton = skeletor.skeletonize.by_wavefront(mesh, waves=1, step_size=1, progress=False)
    else:
        thickness = 2 * abs(mesh.volume) / mesh.area
        skeleton = skeletor.skeletonize.by_teasar(mesh, inv_dist=INVALIDATED * thickness, progress=False)
    return swc_graph(skeleton.swc)


def _skeletor_wavefront(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    return _skeletor("wavefront", vertices, faces)


def _skeletor_teasar(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    return _skeletor("TEASAR", vertices, faces)


TOOLS: dict[str, Callable[[NDArray[np.float64], NDArray[np.int64]], Answer]] = {
    "lbskel": _lbskel,
    "PyGEL3D MSLS": _timed(pygel_separators),
    "skeletor wavefront": _timed(_skeletor_wavefront),
    "skeletor contraction": _timed(skeletor_edge_collapse),
    "skeletor TEASAR": _timed(_skeletor_teasar),
    "CGAL": _cgal,
}

OURS = ("lbskel",)


def _call(name: str, vertices: NDArray[np.float64], faces: NDArray[np.int64], n_calls: int) -> Answer:
    """Call a tool, first on a small mesh: the answer of the fastest call."""
    small = tube(np.linspace([0.0, 0, 0], [0, 0, 9], 40), 1.0, sides=12, rounded=True)
    with suppress(Exception):
        TOOLS[name](np.array(small.vertices), np.array(small.faces))
    answers = [TOOLS[name](vertices, faces) for _ in range(n_calls)]
    return min(answers, key=lambda answer: answer.seconds)


def ask(name: str, mesh: lbskel.Mesh, time_limit: float = TIME_LIMIT, n_calls: int = 1) -> Answer | str:
    """Call a tool in a process of its own: its answer, or its error.

    Parameters
    ----------
    name : str
        A key of TOOLS.
    mesh : Mesh
    time_limit : float
        Seconds after which the process is ended.
    n_calls : int
        Calls, of which the fastest counts.
    """
    arguments: tuple[Any, ...] = (name, np.array(mesh.vertices), np.array(mesh.faces), n_calls)
    result = run_in_subprocess(_call, *arguments, timeout=time_limit)
    if "error" in result:
        return str(result["error"])
    answer: Answer = result["value"]
    return answer if len(answer.skeleton.edges) else "no edges"
