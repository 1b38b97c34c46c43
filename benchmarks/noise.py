"""Skeletons of surfaces with noise, smoothed before contraction or not: where smoothing begins to help."""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.refinement import EXTENSIONS, measured, n_tips_lost
from benchmarks.summaries import means
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.roughness import evenness, roughness
from lbskel.shapes import SHAPES, Shape, make, with_local_noise

MESHES = Path(__file__).parent.parent / "meshes"
DEVIATIONS = (0.1, 0.15, 0.2, 0.3)  # of noise, in edge lengths
ITERATIONS = (0, 20, 60)  # of smoothing


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write noise.json and noise.md."""
    paths = [path for path in (*sorted(MESHES.iterdir()), *meshes) if path.suffix[1:] in EXTENSIONS]
    read = [lbskel.read_mesh(path) for path in paths[: 1 if quick else None]]
    clean = [lbskel.skeletonize(mesh) for mesh in read]
    tubes = [make(name) for name in SHAPES]
    rows = [
        _row(deviation, iterations, tubes, read, clean)
        for deviation in (DEVIATIONS[:1] if quick else DEVIATIONS)
        for iterations in (ITERATIONS[:1] if quick else ITERATIONS)
    ]
    save_json(results / "noise.json", {"rows": rows}, meshes=paths)
    heading = f"Noise, smoothed or not: thirteen tubes, and {len(read)} meshes"
    save_markdown(results / "noise.md", "Noise", {heading: markdown_table(rows)})


def _row(
    deviation: float,
    iterations: int,
    shapes: Sequence[Shape],
    meshes: Sequence[Mesh],
    clean: Sequence[lbskel.Skeleton],
) -> dict[str, Any]:
    """Measure skeletons with noise that is smoothed by some iterations, or not by 0."""
    with (
        mock.patch("lbskel.preprocess.automatic.ROUGHNESS_LIMIT", 0.0 if iterations else np.inf),
        mock.patch("lbskel.preprocess.automatic.N_SMOOTHING_ITERATIONS", iterations),
    ):
        noisy_meshes = [with_local_noise(mesh, deviation) for mesh in meshes]
        noisy = [lbskel.skeletonize(mesh) for mesh in noisy_meshes]
        tubes = [measured(lbskel.skeletonize(with_local_noise(shape.mesh, deviation)), shape.truth) for shape in shapes]
    return {
        "noise, edges": deviation,
        "roughness, median": float(np.median([roughness(mesh) for mesh in noisy_meshes])),
        "evenness, least": min(map(_median_evenness, noisy_meshes)),
        "iterations": iterations,
        **{f"tubes, {key}": value for key, value in means(tubes).items()},
        "tubes, graphs right": f"{sum(row['graph right'] for row in tubes)}/{len(tubes)}",
        "tips lost": sum(map(n_tips_lost, noisy, clean)),
        "tips added": sum(map(n_tips_lost, clean, noisy)),
        "most tips added to one mesh": max(map(n_tips_lost, clean, noisy)),
        "extremities missed": sum(skeleton.report["score"]["measures"]["extremities_missed"] for skeleton in noisy),
        "fail": sum(skeleton.report["score"]["verdict"] == "fail" for skeleton in noisy),
    }


def _median_evenness(mesh: Mesh) -> float:
    """Compute the median over the vertices of a mesh."""
    return float(np.median(evenness(mesh.edges, mesh.edge_lengths, len(mesh.vertices))[mesh.used_vertices]))
