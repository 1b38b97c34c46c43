"""Skeletons of one shape contracted in other steps, turned and mirrored: how far they depend on these."""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.refinement import EXTENSIONS, HELD_OUT, TUNED, means_and_graphs, measured, n_tips_lost
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


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write stability.json and stability.md."""
    paths = [path for path in (*sorted(MESHES.iterdir()), *meshes) if path.suffix[1:] in EXTENSIONS]
    read = [lbskel.read_mesh(path) for path in paths[: 1 if quick else None]]
    hard = [HARD_SHAPES[name](**given) for parameters in (TUNED, HELD_OUT) for name, given in parameters.items()]
    first = [_skeleton(mesh, *VARIANTS["as it is"]) for mesh in read]
    rows = [_row(name, hard[: 1 if quick else None], read, first) for name in VARIANTS]
    save_json(results / "stability.json", {"rows": rows}, meshes=paths)
    heading = f"{len(hard)} hard shapes against their axes, and {len(read)} meshes against their skeletons as they are"
    save_markdown(results / "stability.md", "Stability", {heading: markdown_table(rows)})


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


def _skeleton(mesh: lbskel.Mesh, growth: float, matrix: NDArray[np.float64]) -> lbskel.Skeleton:
    """Make the skeleton of a mesh under an orthogonal matrix, and bring it back."""
    faces = mesh.faces if np.linalg.det(matrix) > 0 else mesh.faces[:, ::-1]
    moved = lbskel.Mesh(mesh.vertices @ matrix.T, faces)
    skeleton = lbskel.skeletonize(moved, preset=lbskel.ContractionSettings(contraction_growth=growth))
    return replace(skeleton, nodes=skeleton.nodes @ matrix)
