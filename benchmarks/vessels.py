"""Skeletons of coils and trees of vessels with known axes, the thinnest radius 0.0005 to 0.0245 of the diagonal.

Distances are in units of the true local radius. A tip is found if the skeleton has one within two of its radii.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.thin_tools import OURS, TOOLS, Answer, ask
from lbskel.shapes import Shape, coil, vessel_tree

COILS = (5, 20, 30, 60, 150, 300)  # turns
# Forks, least radius and seed, for which the thinnest radius is 0.0044, 0.0013 and 0.0007 of the diagonal.
TREES = ((10, 0.33, 1), (40, 0.13, 0), (80, 0.075, 0))
QUICK: tuple[tuple[int, ...], tuple[tuple[int, float, int], ...]] = ((2,), ((3, 0.4, 1),))
TIP_DISTANCE = 2.0  # local radii within which a tip is found

COLUMNS = ("accuracy", "accuracy_95", "coverage", "coverage_95", "length_error", "radius_error")


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write vessels.json and vessels.md."""
    coils, trees = QUICK if quick else (COILS, TREES)
    families: dict[str, dict[str, Callable[[], Shape]]] = {
        "coils": {f"coil of {turns} turns": partial(coil, turns) for turns in coils},
        "trees": {
            f"tree of {forks} forks": partial(vessel_tree, forks, min_radius=radius, seed=seed)
            for forks, radius, seed in trees
        },
    }
    rows = []
    for shapes in families.values():
        late: set[str] = set()  # tools that ran out of time on a smaller shape
        for name, make in shapes.items():
            shape = make()
            for tool in TOOLS if peers else OURS:
                answer = "out of time on a smaller shape" if tool in late else ask(tool, shape.mesh)
                rows.append(_row(name, tool, shape, answer))
                if isinstance(answer, str) and answer.startswith("over "):
                    late.add(tool)
    save_json(results / "vessels.json", {"rows": rows}, packages=("skeletor", "PyGEL3D", "CGAL"))
    tables = {tool: [row for row in rows if row["tool"] == tool] for tool in TOOLS}
    save_markdown(
        results / "vessels.md",
        "Vessels",
        {
            "Coils and trees, each tool": markdown_table(rows),
            **{tool: markdown_table(own) for tool, own in tables.items() if own and tool in OURS and peers},
        },
    )


def _row(name: str, tool: str, shape: Shape, answer: Answer | str) -> dict[str, Any]:
    """Compare an answer with the truth of its shape."""
    extent = float(np.linalg.norm(np.ptp(shape.mesh.vertices, axis=0)))
    row: dict[str, Any] = {
        "shape": name,
        "tool": tool,
        "faces": len(shape.mesh.faces),
        "thinnest / diagonal": float(shape.truth.radii.min()) / extent,
    }
    if isinstance(answer, str):
        return {**row, "error": answer}
    compared = lbskel.ground_truth_distances(answer.skeleton, shape.truth)
    measured = {key: float(getattr(compared, key)) for key in COLUMNS}
    return {
        **row,
        **{key: value if np.isfinite(value) else None for key, value in measured.items()},
        "topology right": compared.is_topology_right,
        "tips": f"{compared.n_tips}/{compared.n_true_tips}",
        "tips found": tips_found(answer.skeleton, shape.truth),
        "verdict": answer.verdict,
        "cpu seconds": answer.seconds,
    }


def tips_found(skeleton: lbskel.Skeleton, truth: lbskel.Skeleton, distance: float | None = None) -> float:
    """Compute the share of true tips with a tip of the skeleton within a distance, by default two local radii."""
    true_tips, tips = truth.tips, skeleton.nodes[skeleton.tips]
    if len(tips) == 0:
        return 0.0
    limit = TIP_DISTANCE * truth.radii[true_tips] if distance is None else distance
    return float((cKDTree(tips).query(truth.nodes[true_tips])[0] <= limit).mean())
