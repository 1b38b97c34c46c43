"""Skeletons of one shape contracted in other steps, turned and mirrored: how far they depend on these."""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.refinement import EXTENSIONS, HELD_OUT, TUNED, means_and_graphs, measured, n_tips_lost
from lbskel.refinement import blunt_ends
from lbskel.shapes import Shape
from lbskel.shapes.hard import HARD_SHAPES

MESHES = Path(__file__).parent.parent / "meshes"
TURNED, MIRRORED = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix(), np.diag([-1.0, 1, 1])
# factor on the contraction weight after each step, and orthogonal matrix
VARIANTS = {
    "as it is": (2.0, np.eye(3)),
    **{f"growth {growth:g}": (growth, np.eye(3)) for growth in (1.5, 1.7, 2.3, 3.0)},
    "turned": (2.0, TURNED),
    "mirrored": (2.0, MIRRORED),
}

LENGTHS = (0.0, 0.75, 1.0, 1.25, 1.5)  # swept: of an end branch, in mean distances of its surface from it
SAME_TIP = 0.035  # distance within which tips of two variants are the same, in diagonals of the mesh; a guess


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write stability.json and stability.md."""
    paths = [path for path in (*sorted(MESHES.iterdir()), *meshes) if path.suffix[1:] in EXTENSIONS]
    read = [lbskel.read_mesh(path) for path in paths[: 1 if quick else None]]
    hard = [HARD_SHAPES[name](**given) for parameters in (TUNED, HELD_OUT) for name, given in parameters.items()]
    first = [_skeleton(mesh, *VARIANTS["as it is"]) for mesh in read]
    rows = [_row(name, hard[: 1 if quick else None], read, first) for name in VARIANTS]
    lengths = [_length_row(length, read) for length in LENGTHS]
    save_json(results / "stability.json", {"rows": rows, "lengths": lengths}, meshes=paths)
    heading = f"{len(hard)} hard shapes against their axes, and {len(read)} meshes against their skeletons as they are"
    by_length = "Tips that all variants of a mesh have, and that some have, by the least length of an end"
    tables = {heading: markdown_table(rows), by_length: markdown_table(lengths)}
    save_markdown(results / "stability.md", "Stability", tables)


def _row(
    name: str, shapes: Sequence[Shape], meshes: Sequence[lbskel.Mesh], first: Sequence[lbskel.Skeleton]
) -> dict[str, Any]:
    """Measure one variant."""
    others = [_skeleton(mesh, *VARIANTS[name]) for mesh in meshes]
    return {
        "variant": name,
        **means_and_graphs([measured(_skeleton(shape.mesh, *VARIANTS[name]), shape.truth) for shape in shapes]),
        "meshes": len(meshes),
        "tips": sum(len(skeleton.tips) for skeleton in others),
        "tips lost": sum(map(n_tips_lost, others, first)),
        "tips added": sum(map(n_tips_lost, first, others)),
        "meshes with other tips": sum(
            n_tips_lost(a, b) + n_tips_lost(b, a) > 0 for a, b in zip(others, first, strict=True)
        ),
        "meshes with other cycles": sum(a.cycle_rank != b.cycle_rank for a, b in zip(others, first, strict=True)),
        "fail": sum(skeleton.report["score"]["verdict"] == "fail" for skeleton in others),
    }


def _length_row(length: float, meshes: Sequence[lbskel.Mesh]) -> dict[str, Any]:
    """Count the tips of meshes in all variants, with another least length of ends."""
    n_variants, n_first = [], 0
    with mock.patch.object(blunt_ends, "MIN_LENGTH", length):
        for mesh in meshes:
            skeletons = [_skeleton(mesh, *variant) for variant in VARIANTS.values()]
            n_variants += _n_variants_of_tips([s.nodes[s.tips] for s in skeletons], SAME_TIP * mesh.diagonal)
            n_first += len(skeletons[0].tips)
    stable = n_variants.count(len(VARIANTS))
    return {"length": length, "tips": n_first, "in all variants": stable, "in some": len(n_variants) - stable}


def _n_variants_of_tips(tips: list[NDArray[np.float64]], reach: float) -> list[int]:
    """Count, for each tip that any variant has, the variants that have it: those with a tip that near, each once."""
    counts = []
    while any(map(len, tips)):
        tip = next(points[0] for points in tips if len(points))
        count = 0
        for variant, points in enumerate(tips):
            distances = np.linalg.norm(points - tip, axis=1)
            if (distances <= reach).any():
                count += 1
                tips[variant] = np.delete(points, distances.argmin(), axis=0)
        counts.append(count)
    return counts


def _skeleton(mesh: lbskel.Mesh, growth: float, matrix: NDArray[np.float64]) -> lbskel.Skeleton:
    """Make the skeleton of a mesh under an orthogonal matrix, and bring it back."""
    faces = mesh.faces if np.linalg.det(matrix) > 0 else mesh.faces[:, ::-1]
    moved = lbskel.Mesh(mesh.vertices @ matrix.T, faces)
    skeleton = lbskel.skeletonize(moved, preset=lbskel.ContractionSettings(contraction_growth=growth))
    return replace(skeleton, nodes=skeleton.nodes @ matrix)
