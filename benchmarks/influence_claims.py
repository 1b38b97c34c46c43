"""Claims of Au et al. 2008 about their skeletons, measured: steps, noise, rotation, pose, homotopy, thin regions first.

Distances between skeletons are means in units of the true local radius.
"""

from __future__ import annotations

__all__ = ["measure", "tables"]

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.stats import spearmanr

from benchmarks.harness import markdown_table
from lbskel import PRESETS, Mesh, Skeleton, contract, ground_truth_distances, skeletonize
from lbskel.shapes import Shape, make
from lbskel.skeleton.edge_sampling import sample_edges

BEND = np.radians(60)  # turning angle along the whole length of the shape
VARIED = 1.1  # largest over smallest radius, below which no region counts as thin; a guess
COLLAPSED = 0.2  # distance to the axis over that at the start, below which a vertex has collapsed; a guess
PRESETS_MEASURED = ("curvature_flow", "least_squares", "au2008", "au2008_demo")


def bent(points: NDArray[np.float64], axis: Mesh) -> NDArray[np.float64]:
    """Bend points in the plane of the shape's two longest sides by the angle ``BEND``.

    The longest side becomes an arc of equal length; distances from that arc are kept.
    """
    low, high = axis.vertices.min(axis=0), axis.vertices.max(axis=0)
    long, across = np.argsort(high - low)[::-1][:2]
    R = (high - low)[long] / BEND
    angle = (points[:, long] - low[long]) / R - BEND / 2
    away = R + points[:, across] - high[across]
    result = np.array(points)
    result[:, long], result[:, across] = away * np.sin(angle), away * np.cos(angle) - R
    return result


def _rotation() -> NDArray[np.float64]:
    """Return a rotation about an axis in general position."""
    Q = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    return Q * np.sign(np.linalg.det(Q))


def _moved(skeleton: Skeleton, nodes: NDArray[np.float64]) -> Skeleton:
    return Skeleton(nodes, skeleton.edges, skeleton.radii)


def _spread(truth: Skeleton) -> float:
    """Return the ratio of the largest to the smallest radius."""
    return float(truth.radii.max() / truth.radii.min())


def _thin_first(mesh: Mesh, truth: Skeleton, preset: str) -> float | None:
    """Compute the rank correlation of local radius and step of collapse: 1 if thin regions collapse first."""
    if _spread(truth) < VARIED:
        return None
    axis, radii = sample_edges(truth, truth.length / 5000)
    tree = cKDTree(axis)
    first, nearest = tree.query(mesh.vertices)
    when = np.full(len(mesh.vertices), np.inf)

    def watch(step: Any, now: Mesh) -> None:
        watched.append(tree.query(now.vertices * mesh.diameter_bound + mesh.centroid)[0])

    watched: list[NDArray[np.float64]] = []
    contract(mesh, PRESETS[preset], on_step=watch)
    for number, distance in reversed(list(enumerate(watched, 1))):
        when[distance < COLLAPSED * first] = number
    drawn_in = np.isfinite(when)
    return float(spearmanr(radii[nearest[drawn_in]], when[drawn_in]).statistic)


def _row(shape: Shape, preset: str, noisy: Mesh) -> dict[str, Any]:
    """Measure all claims on one shape."""
    mesh, truth, Q = shape.mesh, shape.truth, _rotation()
    skeleton = skeletonize(mesh, preset=preset)
    turned = skeletonize(mesh.with_vertices(mesh.vertices @ Q.T), preset=preset)
    posed = skeletonize(mesh.with_vertices(bent(mesh.vertices, mesh)), preset=preset)
    bent_truth = Skeleton(bent(truth.nodes, mesh), truth.edges, truth.radii)
    measured = ground_truth_distances(skeleton, truth)
    part = skeleton.report["components"][0]
    return {
        "shape": shape.name,
        "preset": preset,
        "steps": len(part["steps"]),
        "accuracy": measured.accuracy,
        "accuracy, noisy": ground_truth_distances(skeletonize(noisy, preset=preset), truth).accuracy,
        "turned, apart": ground_truth_distances(_moved(turned, turned.nodes @ Q), truth).accuracy - measured.accuracy,
        "accuracy, bent": ground_truth_distances(posed, bent_truth).accuracy,
        "bent, tips alike": len(posed.tips) == len(skeleton.tips),
        "homotopic": measured.is_topology_right,
        "radii, largest over smallest": _spread(truth),
        "thin first": _thin_first(mesh, truth, preset),
    }


def measure(names: Iterable[str], n_vertices: int) -> list[dict[str, Any]]:
    """Measure each preset on each shape, one row each."""
    rows: list[dict[str, Any]] = []
    for name in names:
        shape, noisy = make(name, n_vertices=n_vertices), make(name, n_vertices=n_vertices, noise=0.25).mesh
        rows.extend(_row(shape, preset, noisy) for preset in PRESETS_MEASURED)
    return rows


def tables(rows: list[dict[str, Any]]) -> str:
    """Tabulate each preset over all shapes, then every row."""
    lines: list[dict[str, Any]] = []
    for preset in PRESETS_MEASURED:
        own = [row for row in rows if row["preset"] == preset]

        def over(key: str, how: Callable[[list[float]], float], own: list[dict[str, Any]] = own) -> float:
            return float(how([row[key] for row in own if row[key] is not None]))

        lines.append(
            {
                "preset": preset,
                "most steps": over("steps", max),
                "accuracy": over("accuracy", np.mean),
                "noisy": over("accuracy, noisy", np.mean),
                "bent": over("accuracy, bent", np.mean),
                "tips alike when bent": f"{sum(row['bent, tips alike'] for row in own)}/{len(own)}",
                "turned, largest difference": max(abs(row["turned, apart"]) for row in own),
                "homotopic": f"{sum(row['homotopic'] for row in own)}/{len(own)}",
                "thin first, rank correlation": over("thin first", np.median),
            }
        )
    return f"{markdown_table(lines)}\n{markdown_table(rows)}"
