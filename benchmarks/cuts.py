"""Cuts: skeletons of cropped and cut tubes, and of trees without some faces, with other bounds on open ends."""

from __future__ import annotations

__all__ = ["run"]

from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.preprocess import simplify
from lbskel.shapes import cylinder, solid_of, vessel_tree
from lbskel.shapes.isosurface import marching_cubes

LENGTH, FIRST, LAST = 12.0, 2.0, 10.0  # of a cropped tube, and the planes beyond which its faces are left out, in radii
STEPS = (0.2, 0.25, 0.3)  # of its mesh, in radii
N_DIRECTIONS, N_TREES, N_FORKS = 30, 4, 12
ANGLES = (0.0, 30.0, 45.0, 60.0, 70.0)  # of oblique cuts, in degrees
FLARES = (1.25, 1.5, 2.0, 2.5)  # radii of ends over that of the tube
MISSING = (0.005, 0.02, 0.05)  # shares of the faces of decimated trees
DECIMATED = 0.08  # share of their faces that is left
SHORT = 2.0  # radii before a true end from which it is lost

BOUNDS: dict[str, dict[str, float]] = {
    "as they are": {},
    **{f"MIN_CUT_SHARE {value:g}": {"open_ends.MIN_CUT_SHARE": value} for value in (0.0, 0.25, 0.35, 0.7)},
    **{f"RIM_RATIO {value:g}": {"open_ends.RIM_RATIO": value} for value in (0.0, 1.0, 1.25, 1.5, 2.0, 3.0)},
    **{f"MAX_CUT_RATIO {value:g}": {"open_ends.MAX_CUT_RATIO": value} for value in (1.0, 1.5, 2.0, 4.0)},
}


def run(quick: bool, results: Path) -> None:
    """Measure, and write cuts.json and cuts.md."""
    cases = [*_tubes(3 if quick else N_DIRECTIONS)]
    trees = [*_trees(1 if quick else N_TREES)]
    rows = [_row(name, cases, trees) for name in [*BOUNDS][: 2 if quick else None]]
    save_json(results / "cuts.json", {"bounds": rows})
    save_markdown(results / "cuts.md", "Cuts", {"Tubes and ends that are right": markdown_table(rows)})


def _tubes(n_directions: int) -> Iterator[tuple[str, lbskel.Mesh, NDArray[np.float64]]]:
    """Make open tubes: what was done to each, its mesh, and the centers of its two cuts."""
    generator = np.random.default_rng(0)
    for axis in generator.normal(size=(n_directions, 3)):
        axis /= np.linalg.norm(axis)
        for step in STEPS:
            solid = solid_of([(np.stack([0 * axis, LENGTH * axis]), np.ones(2))])
            whole = marching_cubes(solid, step)
            along = whole.vertices[whole.faces].mean(axis=1) @ axis
            kept = whole.faces[(along > FIRST) & (along < LAST)]
            yield "cropped", lbskel.Mesh(whole.vertices, kept), np.stack([FIRST * axis, LAST * axis])
    tube = cylinder(1.0, LENGTH, 24, 60)
    x, y, z = tube.vertices.T
    ends = np.array([[0, 0, -LENGTH / 2], [0, 0, LENGTH / 2]])
    for angle in ANGLES:
        shear = 2 * z / LENGTH * np.tan(np.radians(angle)) * x
        yield "oblique", tube.with_vertices(np.stack([x, y, z + shear], axis=1)), ends
    for flare in FLARES:
        widths = 1 + (flare - 1) * np.clip(np.abs(z) - (LENGTH / 2 - 2), 0, 2) / 2
        yield "flared", tube.with_vertices(np.stack([widths * x, widths * y, z], axis=1)), ends


def _trees(n_trees: int) -> Iterator[tuple[lbskel.Mesh, lbskel.Skeleton]]:
    """Make decimated trees of vessels some of whose faces are missing, with their axes."""
    for seed in range(n_trees):
        shape = vessel_tree(N_FORKS, seed=seed)
        coarse = simplify(shape.mesh, target_faces=int(DECIMATED * len(shape.mesh.faces))).mesh
        generator = np.random.default_rng(seed)
        for share in MISSING:
            is_kept = generator.random(len(coarse.faces)) > share
            yield lbskel.Mesh(coarse.vertices, coarse.faces[is_kept]), shape.truth


def _row(
    name: str,
    tubes: list[tuple[str, lbskel.Mesh, NDArray[np.float64]]],
    trees: list[tuple[lbskel.Mesh, lbskel.Skeleton]],
) -> dict[str, Any]:
    """Count what is right with some bounds."""
    right, total = Counter[str](), Counter[str]()
    failed, ends, lost = 0, 0, 0
    with ExitStack() as bounds:
        for target, value in BOUNDS[name].items():
            bounds.enter_context(mock.patch(f"lbskel.refinement.{target}", value))
        for kind, mesh, centers in tubes:
            skeleton = lbskel.skeletonize(mesh)
            tips = skeleton.nodes[skeleton.tips]
            off = cKDTree(tips).query(centers)[0].max() if len(tips) else np.inf
            total[kind] += 1
            right[kind] += len(tips) == 2 and off < 0.5
            failed += skeleton.report["score"]["verdict"] == "fail"
        for mesh, truth in trees:
            skeleton = lbskel.skeletonize(mesh)
            off = cKDTree(skeleton.nodes).query(truth.nodes[truth.tips])[0] / truth.radii[truth.tips]
            ends, lost = ends + len(off), lost + int((off > SHORT).sum())
    counts = {kind: f"{right[kind]}/{total[kind]}" for kind in total}
    return {"bounds": name, **counts, "tubes failed": failed, "ends of trees lost": f"{lost}/{ends}"}
