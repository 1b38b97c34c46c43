"""How far skeletons move when the mesh changes but not the shape: noise, rotation, other samplings, other poses.

Distances are in local radii: from the changed skeleton to that of the unchanged mesh and back, the larger mean and the
larger 95th percentile of the two directions. A shape in another pose has another skeleton, so there they are distances
to its true axis. Noise is uniform along the normals; its height is in per cent of the diagonal of the bounding box. A
limb has a radius of two to four per cent.

Limits of the mean: noise may move a skeleton by a fifth of a radius, a rotation by rounding only, another sampling of
the surface by a tenth, and in another pose it may be a quarter from the true axis. The number of tips and the topology
must stay. The 95th percentile is reported without a limit.

Bounds of refinement are swept on shapes that the ablation of ``refinement`` does not have: hands in other poses, and
one with so few vertices that its fingers are fused; beside them, the hard shapes and the creatures.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import igl
import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.refinement import CREATURES, HELD_OUT, TUNED, measured
from lbskel.shapes import SHAPES, Shape, Solid, creature, make, mesh_solid
from lbskel.shapes.hard import HARD_SHAPES
from lbskel.visualization import Panel, render

NAMES, QUICK = ("limbs", "octopus", "hand", "spiked_ring", "ladder", "dinosaur"), ("limbs",)
VERTICES = 4000
NOISES = (0.5, 1.0, 2.0, 3.0)
FACTORS = (0.25, 0.5, 2.0, 4.0)
BENDS = (45.0, 75.0)  # degrees from one end of the shape to the other; by 90 two fingers of the hand grow together

FUSED = 1895  # vertices of a hand with which the gaps between its fingers are narrower than its edges
POSES = [(degrees, n) for degrees in (30.0, 45.0, 60.0, 75.0) for n in (2500, 3900, 6000)]  # of hands, and vertices
SWEPT = {
    "junctions.MAX_MERGE_LENGTH": (2.0, 3.0, 4.0, 6.0),
    "junctions.MAX_SINE": (0.2, 0.3, 0.36, 0.44, 0.7),
    "junctions.MAX_TRUNK_LENGTH": (4.0, 6.0, 8.0, 100.0),
    "trunks.MAX_SINE": (0.3, 0.36, 0.44, 0.5),
    "trunks.MIN_THICKNESS": (0.4, 0.6, 0.8),
    "trunks.MAX_REACH": (0.0, 1.0, 2.0, 4.0, 100.0),
}

MIN_VISIBLE = 0.01  # distance in radii that a picture shows; a guess

# mean distance in radii that a change may move a skeleton by: what the project asks of itself
LIMITS = {"noise": 0.2, "turn": 1e-6, "sampling": 0.1, "pose": 0.25}


class Case(NamedTuple):
    """A changed mesh, the limit for its skeleton, and the true skeleton; None to compare with the unchanged mesh."""

    kind: str
    change: str
    limit: float
    mesh: lbskel.Mesh
    turn: NDArray[np.float64]
    truth: lbskel.Skeleton | None = None


def run(quick: bool, results: Path) -> None:
    """Measure, and write robustness.json, robustness.md and a picture of the worst of each kind."""
    rows: list[dict[str, Any]] = []
    worst: dict[str, tuple[float, Panel]] = {}
    for name in QUICK if quick else NAMES:
        solid = SHAPES[name]()
        mesh = mesh_solid(solid, n_vertices=1000 if quick else VERTICES)
        reference = lbskel.skeletonize(mesh)
        for case in _cases(solid, mesh):
            row, skeleton = _row(name, case, reference)
            rows.append(row)
            if skeleton is not None and row["moved, 95 %"] > worst.get(case.kind, (MIN_VISIBLE,))[0]:
                worst[case.kind] = row["moved, 95 %"], Panel(case.mesh, skeleton, f"{name}, {case.change}")
    shapes = _swept_shapes(quick)
    swept = [_swept_row(shapes, name, value) for name, values in SWEPT.items() for value in values]
    save_json(
        results / "robustness.json",
        {"limits": LIMITS, "rows": rows, "swept": swept},
        packages=("pymeshlab",),
    )
    save_markdown(
        results / "robustness.md",
        "Robustness",
        {
            "By change, over the shapes": markdown_table(_summary(rows)),
            "Each shape": markdown_table(rows),
            "Bounds of refinement": markdown_table(swept),
        },
    )
    for kind, (_, panel) in worst.items():
        render([panel], results / f"robustness_{kind}.png", force=True)


def _swept_shapes(quick: bool) -> tuple[Shape, dict[str, list[Shape]]]:
    """Make a hand with few vertices; and hands in other poses, the hard shapes and the creatures, by name."""
    solid = SHAPES["hand"]()
    bent = [(replace(solid, centers=_bent(solid.centers, np.radians(degrees))), n) for degrees, n in POSES]
    poses = [Shape(mesh_solid(each, n_vertices=n), each.truth, "hand") for each, n in (bent[:1] if quick else bent)]
    named = [(name, kwargs) for shapes in (TUNED, HELD_OUT) for name, kwargs in shapes.items()]
    hard = [HARD_SHAPES[name](**kwargs) for name, kwargs in (named[:1] if quick else named)]
    creatures = [creature(seed) for seed in (CREATURES[:1] if quick else CREATURES)]
    return make("hand", n_vertices=FUSED), {"bent hands": poses, "hard shapes": hard, "creatures": creatures}


def _swept_row(shapes: tuple[Shape, dict[str, list[Shape]]], name: str, value: float) -> dict[str, Any]:
    """Measure skeletons with another value of a bound of refinement."""
    fused, others = shapes
    with mock.patch(f"lbskel.refinement.{name}", value):
        hand = measured(lbskel.skeletonize(fused.mesh), fused.truth)
        rows = {
            of: [measured(lbskel.skeletonize(shape.mesh), shape.truth) for shape in each] for of, each in others.items()
        }
    row: dict[str, Any] = {"bound": name, "value": value, "hand of few vertices, accuracy": hand["accuracy"]}
    for of, own in rows.items():
        row[f"{of}, accuracy"] = float(np.mean([each["accuracy"] for each in own]))
        row[f"{of}, graphs right"] = f"{sum(each['graph right'] for each in own)}/{len(own)}"
    return row


def _cases(solid: Solid, mesh: lbskel.Mesh) -> Iterator[Case]:
    """Generate every change of a shape."""
    still = np.eye(3)
    normals = igl.per_vertex_normals(mesh.vertices, mesh.faces)
    for per_cent in NOISES:
        heights = np.random.default_rng(0).uniform(-1, 1, size=len(normals)) * per_cent / 100 * mesh.diagonal
        noisy = mesh.with_vertices(mesh.vertices + heights[:, None] * normals)
        yield Case("noise", f"noise {per_cent:g} %", LIMITS["noise"], noisy, still)
    for axis in range(3):
        turn = _turn(axis, np.radians(45))
        yield Case(
            "turn", f"45 degrees about {'xyz'[axis]}", LIMITS["turn"], mesh.with_vertices(mesh.vertices @ turn.T), turn
        )
    for factor in FACTORS:
        yield Case("sampling", f"x {factor:g} vertices", LIMITS["sampling"], _resampled(solid, mesh, factor), still)
    for degrees in BENDS:
        bent = replace(solid, centers=_bent(solid.centers, np.radians(degrees)))
        mesh_bent = mesh_solid(bent, n_vertices=len(mesh.vertices))
        yield Case("pose", f"bent by {degrees:g}", LIMITS["pose"], mesh_bent, still, bent.truth)


def _resampled(solid: Solid, mesh: lbskel.Mesh, factor: float) -> lbskel.Mesh:
    """Sample the surface with more vertices, or collapse edges of the mesh: thin limbs keep the remesher from fewer."""
    if factor > 1:
        return mesh_solid(solid, n_vertices=int(factor * len(mesh.vertices)))
    V, F, *_ = igl.decimate(mesh.vertices, mesh.faces, int(factor * len(mesh.faces)), True)
    return lbskel.Mesh(V, F)


def _turn(axis: int, angle: float) -> NDArray[np.float64]:
    """Return the matrix of a rotation about an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    return turn


def _bent(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Bend space along the longest side of the points' bounding box, so that its ends turn against each other."""
    along, aside = np.argsort(-np.ptp(points, axis=0), kind="stable")[:2]
    bent = np.array(points)
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    radius = np.ptp(points[:, along]) / angle
    at, height = (points[:, along] - middle[along]) / radius, points[:, aside] - middle[aside]
    bent[:, along] = middle[along] + (radius + height) * np.sin(at)
    bent[:, aside] = middle[aside] + (radius + height) * np.cos(at) - radius
    return bent


def _row(name: str, case: Case, reference: lbskel.Skeleton) -> tuple[dict[str, Any], lbskel.Skeleton | None]:
    """Compare the changed skeleton with its reference."""
    row: dict[str, Any] = {"kind": case.kind, "change": case.change, "shape": name, "vertices": len(case.mesh.vertices)}
    row["limit"] = case.limit
    try:
        skeleton = lbskel.skeletonize(case.mesh)
    except lbskel.LbskelError as error:
        return {**row, "error": f"{type(error).__name__}: {error}"}, None
    turned_back = replace(skeleton, nodes=skeleton.nodes @ case.turn)
    found = lbskel.ground_truth_distances(turned_back, case.truth if case.truth is not None else reference)
    moved = max(found.accuracy, found.coverage), max(found.accuracy_95, found.coverage_95)
    return {
        **row,
        "moved": moved[0],
        "moved, 95 %": moved[1],
        "within": moved[0] <= case.limit,
        "topology same": found.is_topology_right,
        "tips": found.n_tips,
        "tips before": found.n_true_tips,
        "score": skeleton.report["score"]["verdict"],
    }, skeleton


def _summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Summarize each change in a row: the mean and the worst over the shapes."""
    summary = []
    for change in dict.fromkeys(row["change"] for row in rows):
        own = [row for row in rows if row["change"] == change]
        done = [row for row in own if "error" not in row]
        moved, moved_95 = ([row[key] for row in done] for key in ("moved", "moved, 95 %"))
        summary.append(
            {
                "change": change,
                "limit": f"{own[0]['limit']:g}",
                "moved, mean": float(np.mean(moved)) if done else None,
                "moved, 95 %, mean": float(np.mean(moved_95)) if done else None,
                "moved, 95 %, worst": max(moved_95, default=None),
                "within": f"{sum(row['within'] for row in done)}/{len(own)}",
                "topology same": f"{sum(row['topology same'] for row in done)}/{len(own)}",
                "tips same": f"{sum(row['tips'] == row['tips before'] for row in done)}/{len(own)}",
            }
        )
    return summary
