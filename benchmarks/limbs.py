"""Growth of limbs, and balls in fitted tubes: without a part of it or with other bounds; rows of ``refinement``."""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Sequence
from pathlib import Path

import lbskel
from benchmarks import refinement
from benchmarks.harness import markdown_table, save_json, save_markdown

PARTS = ("limbs", "rings", "ball share")
NAMES = ("none", *(name for name in refinement.PASSES | refinement.BOUNDS if any(part in name for part in PARTS)))


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write limbs.json and limbs.md; ``meshes`` are more real ones."""
    paths = refinement.real_meshes(meshes)
    real = [lbskel.read_mesh(path) for path in paths[: 1 if quick else None]]
    hard, creatures = refinement.hard_shapes(quick), refinement.creatures_of(quick)
    title, rows = refinement.replace_each(
        NAMES[:2] if quick else NAMES, quick, [*hard.values()], [*creatures.values()], real
    )
    save_json(results / "limbs.json", {"ablation": rows}, meshes=paths)
    save_markdown(results / "limbs.md", "Growth of limbs, and balls in fitted tubes", {title: markdown_table(rows)})
