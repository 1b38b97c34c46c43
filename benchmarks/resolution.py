"""Skeletons of fine shapes with a known axis: contraction of a simplified proxy, the default, or of every vertex.

The size of the proxy follows from the local radii. A second table has the skeletons and the time of the radii for rays
from every face, every second one, and so on; a third has a tube by marching cubes, whose slivers have normals along the
surface when noise moves its vertices.

Distances are in units of the true local radius; seconds are processor seconds.
"""

from __future__ import annotations

__all__ = ["run"]

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.geometry import shape_diameter
from lbskel.pipeline.preparation import SIMPLIFY
from lbskel.shapes import SHAPES, Shape, make, marching_cubes, solid_of

VERTICES = (18_000, 28_000, 45_000)  # so that there are more than 16,000 faces, above which the default simplifies
QUICK = ("limbs", "knot")
STRIDES = (1, 2, 3, 6, 12)  # of the faces from which rays are cast, at most
NOISES = (0.0, 0.05, 0.1, 0.15, 0.2)  # standard deviations of the vertices, in steps of the grid
STEPS = (0.16, 0.08, 0.04)  # of the grid, in radii of the tube
ALIGNMENTS = (-1.0, 0.0, 0.3, 0.5)  # lower bounds on the cosine between a face with a ray and the surface around it
DISTANCES = ("accuracy", "accuracy_95", "coverage", "coverage_95")


def run(quick: bool, results: Path) -> None:
    """Measure, and write resolution.json and resolution.md."""
    rows, strides = [], []
    for name in QUICK if quick else SHAPES:
        for n_vertices in (9_000,) if quick else VERTICES:
            shape = make(name, n_vertices=n_vertices)
            rows += [_row(name, shape, simplify) for simplify in SIMPLIFY]
        strides += [_row_of_stride(name, shape, stride) for stride in STRIDES]
    noisy = [_row_of_noise(step, noise) for step in STEPS[: 1 if quick else None] for noise in NOISES]
    tables = {"rows": rows, "strides": strides, "noise": noisy}
    save_json(results / "resolution.json", tables)
    means = [_means(rows, simplify) for simplify in SIMPLIFY]
    shapes = [
        {"shape": name}
        | {
            f"{distance}, {simplify}": _mean(rows, distance, shape=name, simplify=simplify)
            for distance in ("accuracy", "coverage")
            for simplify in SIMPLIFY
        }
        for name in dict.fromkeys(row["shape"] for row in rows)
    ]
    sizes = f"{min(row['faces'] for row in rows):,} to {max(row['faces'] for row in rows):,} faces"
    save_markdown(
        results / "resolution.md",
        "Resolution",
        {
            f"Means over shapes of {sizes}": markdown_table(means),
            "Local radii by rays from every n-th face": markdown_table([_means_of_stride(strides, n) for n in STRIDES]),
            "A noisy tube by marching cubes, of radius 1 and length 6": markdown_table(noisy),
            "Each shape, over its sizes": markdown_table(shapes),
        },
    )


def _row(name: str, shape: Shape, simplify: str) -> dict[str, Any]:
    """One shape, with a proxy or without."""
    began = time.process_time()
    skeleton = lbskel.skeletonize(shape.mesh, simplify=simplify)
    seconds = time.process_time() - began
    comparison = lbskel.ground_truth_distances(skeleton, shape.truth)
    return {
        "shape": name,
        "faces": len(shape.mesh.faces),
        "simplify": simplify,
        **{distance: getattr(comparison, distance) for distance in DISTANCES},
        "topology right": comparison.is_topology_right,
        "tips right": comparison.n_tips == comparison.n_true_tips,
        "seconds": seconds,
    }


def _row_of_noise(step: float, noise: float) -> dict[str, Any]:
    """A fine tube with noise along its whole surface."""
    exact = marching_cubes(solid_of([([[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 1.0)]), step)
    offsets = np.random.default_rng(0).normal(size=exact.vertices.shape)
    mesh = lbskel.Mesh(exact.vertices + noise * step * offsets, exact.faces)
    (body,) = lbskel.prepare(mesh).bodies
    skeleton = lbskel.skeletonize(mesh)
    return {
        "step": step,
        "faces": len(mesh.faces),
        "noise": noise,
        "median local radius": _median_radius(mesh, shape_diameter.MIN_ALIGNMENT),
        **{f"of faces from {alignment:g}": _median_radius(mesh, alignment) for alignment in ALIGNMENTS},
        "faces of the proxy": len(body.proxy.mesh.faces),
        "tips": len(skeleton.tips),
        "distance from the axis": float(np.linalg.norm(skeleton.nodes[:, 1:], axis=1).max()),
        "verdict": skeleton.report["score"]["verdict"],
    }


def _median_radius(mesh: lbskel.Mesh, alignment: float) -> float:
    with mock.patch.object(shape_diameter, "MIN_ALIGNMENT", alignment):
        return float(np.median(shape_diameter.local_radii(lbskel.Mesh(mesh.vertices, mesh.faces))))


@contextmanager
def _at_most(stride: int) -> Iterator[None]:
    """Cast rays from every so many faces of a large mesh at most."""
    usual = shape_diameter.MAX_STRIDE
    shape_diameter.MAX_STRIDE = stride
    try:
        yield
    finally:
        shape_diameter.MAX_STRIDE = usual


def _row_of_stride(name: str, shape: Shape, stride: int) -> dict[str, Any]:
    """One shape, with rays from every so many faces."""
    with _at_most(1):
        exact = shape_diameter.local_radii(shape.mesh.with_vertices(shape.mesh.vertices))  # which knows no radii yet
    mesh = shape.mesh.with_vertices(shape.mesh.vertices)
    with _at_most(stride):
        began = time.process_time()
        radii = shape_diameter.local_radii(mesh)
        seconds = time.process_time() - began
        skeleton = lbskel.skeletonize(mesh)
    comparison = lbskel.ground_truth_distances(skeleton, shape.truth)
    error, error_99 = np.percentile(np.abs(radii / exact - 1), [50, 99])
    return {"shape": name, "stride": stride, "seconds": seconds, "error": error, "error_99": error_99} | {
        distance: getattr(comparison, distance) for distance in DISTANCES
    }


def _means_of_stride(rows: list[dict[str, Any]], stride: int) -> dict[str, Any]:
    return (
        {
            "stride": stride,
            "median error of radii": _mean(rows, "error", stride=stride),
            "99th percentile of it": _mean(rows, "error_99", stride=stride),
        }
        | {distance: _mean(rows, distance, stride=stride) for distance in DISTANCES}
        | {"seconds": _mean(rows, "seconds", stride=stride)}
    )


def _mean(rows: list[dict[str, Any]], what: str, **where: Any) -> float:
    return float(np.mean([row[what] for row in rows if all(row[key] == value for key, value in where.items())]))


def _means(rows: list[dict[str, Any]], simplify: str) -> dict[str, Any]:
    own = [row for row in rows if row["simplify"] == simplify]
    return (
        {"simplify": simplify}
        | {distance: _mean(own, distance) for distance in DISTANCES}
        | {what: f"{sum(row[what] for row in own)}/{len(own)}" for what in ("topology right", "tips right")}
        | {"median seconds": float(np.median([row["seconds"] for row in own]))}
    )
