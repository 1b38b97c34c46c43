"""Skeletons of point clouds sampled from shapes with a known axis: clean, uneven, noisy, with outliers, half hidden.

Distances are in units of the true local radius. Each shape is sampled by 10,000 points; with peers, the multi-scale
local separators of PyGEL3D run on the graph of the 8 nearest neighbors of the same points.
"""

from __future__ import annotations

__all__ = ["run"]

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from benchmarks.summaries import counts_of_right, means
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import SHAPES, Shape, make
from lbskel.skeleton.edge_distances import nearest_on_edges

KINDS = ("uniform", "density", "noise", "outliers", "views")
QUICK = ("limbs", "knot", "cube_frame")
N_POINTS, N_NEIGHBORS = 10_000, 8
DENSITY, NOISE, OUTLIERS = 10.0, 0.1, 0.02  # ratio of densities, in local radii, share of the points
MARGIN = 0.1  # by which the box of outliers is larger than that of the shape, on each side
MIN_COSINE = 0.1  # of the angle between normal and view from which on a scanner sees a point

Graph = tuple[NDArray[np.float64], NDArray[np.int64]]


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write points.json and points.md."""
    tools = {"lbskel": _ours, **({"PyGEL3D": _separators} if peers else {})}
    rows = []
    for name in QUICK if quick else SHAPES:
        shape = make(name)
        for kind in KINDS:
            points = sample(shape, kind, np.random.default_rng(7))
            rows += [_row(tool, function, name, kind, points, shape) for tool, function in tools.items()]
    save_json(results / "points.json", {"clouds": rows}, packages=("PyGEL3D",))
    summary = [_summary(rows, tool, kind) for kind in KINDS for tool in tools]
    tables = {"Means over the shapes": markdown_table(summary), "Each cloud": markdown_table(rows)}
    save_markdown(results / "points.md", "Point clouds", tables)


def sample(shape: Shape, kind: str, rng: np.random.Generator) -> NDArray[np.float64]:
    """Sample points of a shape in one of the ways of KINDS."""
    mesh, low = shape.mesh, shape.mesh.vertices.min(axis=0)
    sides = mesh.vertices.max(axis=0) - low
    weights = np.array(mesh.face_areas)
    if kind == "density":
        axis = int(np.argmax(sides))
        weights *= DENSITY ** -((mesh.vertices[mesh.faces].mean(axis=1)[:, axis] - low[axis]) / sides[axis])
    n = N_POINTS * (12 if kind == "views" else 1)
    faces = rng.choice(len(weights), n, p=weights / weights.sum())
    share = rng.dirichlet(np.ones(3), n)
    points: NDArray[np.float64] = np.einsum("nk,nki->ni", share, mesh.vertices[mesh.faces[faces]])
    if kind == "views":
        return points[rng.permutation(np.flatnonzero(_is_seen(mesh, faces, points, rng)))[:N_POINTS]]
    if kind == "noise":
        radii = nearest_on_edges(shape.truth, points)[2]
        points += rng.normal(size=points.shape) * NOISE * radii[:, None]
    if kind == "outliers":
        box = low - MARGIN * sides + rng.random((int(OUTLIERS * n), 3)) * (1 + 2 * MARGIN) * sides
        points[: len(box)] = box
    return points


def _is_seen(
    mesh: lbskel.Mesh, faces: NDArray[np.int64], points: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Tell which points are seen from far away in three directions at right angles."""
    A, B, C = mesh.vertices[mesh.faces[faces]].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    is_seen = np.zeros(len(points), dtype=bool)
    for view in np.linalg.qr(rng.normal(size=(3, 3)))[0]:
        front = np.flatnonzero(normals @ view > MIN_COSINE)
        above = points[front] + 1e-3 * mesh.diagonal * normals[front]
        hits = Surface(mesh).ray_distance(above, np.tile(view, (len(front), 1)))
        is_seen[front[~np.isfinite(hits)]] = True
    return is_seen


def _ours(points: NDArray[np.float64]) -> Graph:
    skeleton = lbskel.skeletonize(lbskel.PointCloud(points))
    return np.array(skeleton.nodes), np.array(skeleton.edges)


def _separators(points: NDArray[np.float64]) -> Graph:
    from pygel3d import graph

    neighbors = cKDTree(points).query(points, k=N_NEIGHBORS + 1)[1]
    links = {(min(i, j), max(i, j)) for i, row in enumerate(neighbors.tolist()) for j in row[1:]}
    given = graph.Graph()
    for point in points:
        given.add_node(point)
    for i, j in sorted(links):
        given.connect_nodes(i, j)
    skeleton = graph.MSLS_skeleton(given)
    nodes = skeleton.nodes()
    number = {node: index for index, node in enumerate(nodes)}
    edges = {(number[i], number[j]) for i in nodes for j in skeleton.neighbors(i) if i < j}
    return np.array(skeleton.positions())[list(nodes)], np.array(sorted(edges), dtype=np.int64).reshape(-1, 2)


def _row(tool: str, function: Any, name: str, kind: str, points: NDArray[np.float64], shape: Shape) -> dict[str, Any]:
    """Measure one tool on one cloud."""
    row: dict[str, Any] = {"tool": tool, "shape": name, "kind": kind}
    answer = run_in_subprocess(function, points, timeout=120)
    row["seconds"] = answer["seconds"]
    if "error" in answer:
        return {**row, "error": answer["error"]}
    nodes, edges = answer["value"]
    if len(edges) == 0:
        return {**row, "error": "no edges"}
    return {
        **row,
        **asdict(lbskel.ground_truth_distances(lbskel.Skeleton(nodes, edges, np.zeros(len(nodes))), shape.truth)),
    }


def _summary(rows: list[dict[str, Any]], tool: str, kind: str) -> dict[str, Any]:
    """Compute means over the clouds that gave a skeleton, and counts over all."""
    own = [row for row in rows if row["tool"] == tool and row["kind"] == kind]
    done = [row for row in own if "error" not in row]
    return {
        "kind": kind,
        "tool": tool,
        **means(own),
        **counts_of_right(own),
        "median seconds": float(np.median([row["seconds"] for row in done])) if done else None,
    }
