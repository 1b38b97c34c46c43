"""Operators, treatments of degenerate triangles, energies and weights: what each does to the contraction and skeleton.

Shapes whose skeleton is known, the repository's dinosaur, and the meshes of a folder given with --meshes. Every case
runs twice, with the guard as a user has it, and without, as published, to see where the steps themselves break.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks import influence_claims
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.influence_cases import OTHERS, WEIGHT_CASES, measure, prepared, ranking, tables
from benchmarks.influence_pictures import blow_up, curves, stages
from lbskel import read_mesh
from lbskel.comparison import CASES
from lbskel.shapes import SHAPES, make

DINOSAUR = Path(__file__).parent.parent / "meshes" / "dinosaur.ply"
QUICK = ("hand", "dinosaur", "ladder")
FEW = ("hand", "ladder", "knot", "tripod")


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write influence.json, influence.md and pictures."""
    n_vertices = 800 if quick else 1500
    shapes = {}
    for name in QUICK if quick else SHAPES:
        shape = make(name, n_vertices=n_vertices)
        shapes[name] = shape.mesh, shape.truth
    read = {path.name: (read_mesh(path), None) for path in (() if quick else (DINOSAUR, *meshes))}
    real = prepared(read)
    pictured = shapes["dinosaur"][0] if quick else real[DINOSAUR.name][0]
    few = {name: shapes[name] for name in (QUICK[:1] if quick else FEW)}
    rows: dict[str, list[dict[str, Any]]] = {
        "strategies": measure(shapes, CASES),
        "strategies, real meshes": measure(real, CASES),
        "other operators": measure(few, {} if quick else OTHERS),
        "weights": measure(few, dict(list(WEIGHT_CASES.items())[::2]) if quick else WEIGHT_CASES),
    }
    exploding = {name: mesh for name, (mesh, _) in real.items() if name.startswith("dino")} or {"dinosaur": pictured}
    broken = blow_up(exploding, results)
    stages(pictured, results)
    curves(rows["strategies"], "dinosaur", results / "influence_curves.png")
    claims = influence_claims.measure(few, n_vertices)
    save_json(results / "influence.json", {"quick": quick, **rows, "blow-up": broken, "claims": claims})
    save_markdown(
        results / "influence.md",
        "What strategies, operators, energies and weights do",
        {
            "Ranking": markdown_table(ranking(rows["strategies"])),
            **{name.capitalize(): tables(some) for name, some in rows.items() if some},
            "Blow-up": markdown_table(broken),
            "Claims of Au et al. 2008": influence_claims.tables(claims),
        },
    )
