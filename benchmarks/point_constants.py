"""Constants of point clouds, each moved alone: effects on skeletons of clouds, and on the cut loops that are found.

Each constant is multiplied by a smaller and a larger factor. Reconstruction is measured on the clouds of
:mod:`benchmarks.points` that are hard: shapes with limbs near each other, thin ones and loops, noisy, with outliers, or
half hidden. Loops are measured on the skeletons of those clouds whose graph is right: unchanged, so that no loop is
cut, and with one edge of a cycle left out.
"""

from __future__ import annotations

__all__ = ["run"]

from dataclasses import asdict
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.application_constants import swept
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.points import sample
from benchmarks.summaries import counts_of_right, means
from lbskel.shapes import Shape, Truth, make, marching_cubes, solid_of

SHAPES = ("knot", "hand", "octopus", "tree", "dumbbell", "ladder", "cube_frame")
KINDS = ("noise", "outliers", "views")
RECONSTRUCTION = (
    "preprocess/point_neighborhoods.py",
    "preprocess/outliers.py",
    "preprocess/dipole_tree.py",
    "preprocess/point_normals.py",
    "preprocess/reconstruction.py",
)
LOOPS = ("evaluation/point_loops.py",)
FACTORS = (0.7, 1.4)
N_CUTS = 4  # edges of the cycles of a skeleton that are left out, one at a time

N_HANDS = 12  # clouds of a hand, of a ball with four fingers

Cloud = tuple[Shape, NDArray[np.float64]]


def run(quick: bool, results: Path) -> None:
    """Measure, and write point_constants.json and point_constants.md."""
    clouds: list[Cloud] = []
    for name in SHAPES[:1] if quick else SHAPES:
        shape = make(name)
        clouds += [(shape, sample(shape, kind, np.random.default_rng(7))) for kind in KINDS[: 1 if quick else None]]
    as_it_is = {"constant": "all as they are", "factor": 1, "value": None}
    reconstructions = [{**as_it_is, **_skeletons(clouds)}]
    cases = _cases(clouds + [_hand(seed) for seed in range(1 if quick else N_HANDS)])
    loops = [{**as_it_is, **_told(cases)}]
    if not quick:
        reconstructions += swept(RECONSTRUCTION, lambda: _skeletons(clouds), FACTORS)
    loops += swept(LOOPS, lambda: _told(cases), FACTORS)
    save_json(results / "point_constants.json", {"reconstruction": reconstructions, "loops": loops})
    tables = {
        f"Reconstruction, {len(clouds)} clouds": markdown_table(reconstructions),
        "Cut loops": "Skeletons with one edge of a cycle left out that the score tells, and whole ones that it takes "
        "for cut.\n\n" + markdown_table(loops),
    }
    save_markdown(results / "point_constants.md", "Constants of point clouds", tables)


def _skeletons(clouds: list[Cloud]) -> dict[str, Any]:
    """Graphs and tips that are right, and mean distances in local radii."""
    rows = [
        asdict(lbskel.ground_truth_distances(lbskel.skeletonize(lbskel.PointCloud(points)), shape.truth))
        for shape, points in clouds
    ]
    return {**means(rows), **counts_of_right(rows)}


def _hand(seed: int) -> Cloud:
    """A hand with webs between its fingers."""
    angles = np.radians([-60.0, -20.0, 20.0, 60.0])
    fingers = [([np.zeros(3), 6 * np.array([np.sin(angle), 0, np.cos(angle)])], 0.5) for angle in angles]
    solid = solid_of([([[0, 0, 0]], 2.0), ([[0, 0, 0], [0, 0, -6]], 1.2), *fingers], blend=0.05)
    mesh = marching_cubes(solid, 0.15)
    nodes = np.concatenate([np.zeros((1, 3)), [[0, 0, -6]], [path[1] for path, _ in fingers]])
    truth = Truth(nodes, np.array([[0, row] for row in range(1, 6)]), np.array([2.0, 1.2, *4 * [0.5]]))
    shape = Shape(mesh, truth, "hand of a ball")
    return shape, sample(shape, "even", np.random.default_rng(seed))


def _cases(clouds: list[Cloud]) -> list[tuple[lbskel.Skeleton, lbskel.PointCloud, bool]]:
    """Skeletons with the right graph, their clouds, and whether a loop is cut."""
    cases = []
    for shape, points in clouds:
        cloud = lbskel.PointCloud(points)
        skeleton = lbskel.skeletonize(cloud)
        if not lbskel.ground_truth_distances(skeleton, shape.truth).is_topology_right:
            continue
        cases.append((skeleton, cloud, False))
        graph = nx.Graph(skeleton.edges.tolist())
        bridges = {tuple(sorted(edge)) for edge in nx.bridges(graph)}
        on_cycles = [row for row, edge in enumerate(skeleton.edges.tolist()) if tuple(sorted(edge)) not in bridges]
        for row in np.array(on_cycles)[np.linspace(0, len(on_cycles) - 1, N_CUTS).astype(int)] if on_cycles else ():
            cut = lbskel.Skeleton(skeleton.nodes, np.delete(skeleton.edges, row, axis=0), skeleton.radii)
            cases.append((cut, cloud, True))
    return cases


def _told(cases: list[tuple[lbskel.Skeleton, lbskel.PointCloud, bool]]) -> dict[str, Any]:
    """Cut skeletons that are told, and whole ones that are taken for cut."""
    is_told = [bool(lbskel.score(skeleton, cloud).tunnels_missed) for skeleton, cloud, _ in cases]
    is_cut = [each for *_, each in cases]
    return {
        "told": f"{sum(told for told, cut in zip(is_told, is_cut, strict=True) if cut)}/{sum(is_cut)}",
        "whole, taken for cut": f"{sum(told for told, cut in zip(is_told, is_cut, strict=True) if not cut)}/"
        f"{len(is_cut) - sum(is_cut)}",
    }
