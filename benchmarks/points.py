"""Skeletons of point clouds sampled from shapes with a known axis: clean, uneven, noisy, with outliers, half hidden.

Distances are in units of the true local radius. Each shape is sampled by 10,000 points; with peers, other tools run on
the same points, the slow ones on a few clouds (:mod:`benchmarks.point_tools`). Times of up to a million
points are in :mod:`benchmarks.point_times`.
"""

from __future__ import annotations

__all__ = ["run"]

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from benchmarks.point_tools import FAST, PACKAGES, TOOLS
from benchmarks.summaries import counts_of_right, means
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import SHAPES, Shape, make
from lbskel.skeleton.edge_distances import nearest_on_edges

KINDS = ("uniform", "density", "noise", "outliers", "views")
QUICK = ("limbs", "knot", "cube_frame")
N_POINTS = 10_000
DENSITY, NOISE, OUTLIERS = 10.0, 0.1, 0.02  # ratio of densities, in local radii, share of the points
MARGIN = 0.1  # by which the box of outliers is larger than that of the shape, on each side
SLOW = (("knot", "uniform"),)  # cloud of the tools that take up to two minutes
MEDIUM = ("limbs", "octopus", "knot", "ladder")  # shapes of PyGEL3D
MIN_COSINE = 0.1  # of the angle between normal and view from which on a scanner sees a point


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write points.json and points.md."""
    rows = []
    for name in QUICK if quick else SHAPES:
        shape = make(name)
        for kind in KINDS:
            points = sample(shape, kind, np.random.default_rng(7))
            tools = _tools(name, kind) if peers else ["lbskel"]
            rows += [_row(tool, name, kind, points, shape) for tool in tools]
    save_json(results / "points.json", {"clouds": rows}, packages=PACKAGES)
    groups = [(kind, tool) for kind in KINDS for tool in TOOLS if any(_is_of(row, kind, tool) for row in rows)]
    tables = {
        "Means over the shapes": markdown_table([_summary(rows, tool, kind) for kind, tool in groups]),
        "Each cloud": markdown_table(rows),
    }
    save_markdown(results / "points.md", "Point clouds", tables)


def _tools(name: str, kind: str) -> list[str]:
    """List the tools that run on a cloud."""
    if (name, kind) in SLOW:
        return list(TOOLS)
    return list(FAST if name in MEDIUM else FAST[:1])


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


def _is_of(row: dict[str, Any], kind: str, tool: str) -> bool:
    return bool(row["kind"] == kind and row["tool"] == tool)


def _row(tool: str, name: str, kind: str, points: NDArray[np.float64], shape: Shape) -> dict[str, Any]:
    """Measure one tool on one cloud."""
    row: dict[str, Any] = {"tool": tool, "shape": name, "kind": kind}
    answer = run_in_subprocess(TOOLS[tool], points, shape, timeout=240)
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
    own = [row for row in rows if _is_of(row, kind, tool)]
    done = [row for row in own if "error" not in row]
    return {
        "kind": kind,
        "tool": tool,
        "clouds": len(own),
        **means(own),
        **counts_of_right(own),
        "median seconds": float(np.median([row["seconds"] for row in done])) if done else None,
    }
