"""Influence of operators, treatments of degenerate triangles, energies and weights on contraction and skeleton.

The meshes are shapes whose skeleton is known, the repository's dinosaur, and those of a folder given with --meshes.
Every case runs twice: with the roll-back that a user has, and without it, as published, to see where the steps
themselves break. First one choice after the other is varied on all meshes, then all combinations on a few. A run that
has broken amplifies rounding, so its later numbers differ from machine to machine.
"""

from __future__ import annotations

__all__ = ["run"]

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks import influence_claims, influence_factorial
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.influence_cases import OTHERS, WEIGHT_CASES, measure, prepared, ranking, tables
from benchmarks.influence_pictures import blow_up, curves, stages
from benchmarks.provenance import commit
from lbskel import ContractionSettings, Mesh, Skeleton, read_mesh
from lbskel.contraction.settings import DEGENERACY_STRATEGIES
from lbskel.pipeline.comparison import CASES
from lbskel.shapes import SHAPES, make

DINOSAUR = Path(__file__).parent.parent / "meshes" / "dinosaur.ply"
QUICK = ("hand", "dinosaur", "ladder")
FEW = ("hand", "ladder", "knot", "tripod")
CROSSED = ("hand", "ladder")  # genus 0 and 4; the dinosaur is added
MAX_FACES, MAX_CROSSED_FACES = 60_000, 2_000

Some = Mapping[str, tuple[Mesh, Skeleton | None]]


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write influence.json, influence.md and pictures; files are rewritten after each part."""
    n_vertices = 800 if quick else 1500
    made = {name: make(name, n_vertices=n_vertices) for name in (QUICK if quick else SHAPES)}
    shapes = prepared({name: (shape.mesh, shape.truth) for name, shape in made.items()}, MAX_FACES)
    real: Some = {}
    if not quick:
        real = prepared({path.name: (read_mesh(path), None) for path in (DINOSAUR, *meshes)}, MAX_FACES)
    few = {name: shapes[name] for name in (QUICK[:1] if quick else FEW)}
    measured: dict[str, Any] = {"quick": quick, "parts": {}}
    path = results / "influence.json"
    if path.exists():  # parts that are not measured again yet keep their rows, and the commit at which they were
        before = json.loads(path.read_text(encoding="utf-8"))
        header = before.pop("machine")
        measured = {"parts": dict.fromkeys(before, header["commit"]) | before.get("parts", {}), **before, **measured}
    sections: dict[str, str] = {}

    def save(name: str, rows: Any, text: str) -> None:
        measured[name] = rows
        measured["parts"][name] = commit()
        sections[name[0].upper() + name[1:]] = text
        save_json(path, measured, meshes=(DINOSAUR, *meshes))
        save_markdown(results / "influence.md", "What strategies, operators, energies and weights do", sections)

    strategies = measure(shapes, CASES)
    save("ranking", ranking(strategies), markdown_table(ranking(strategies)))
    save("strategies", strategies, tables(strategies))
    pictured = shapes["dinosaur"][0] if quick else real[DINOSAUR.name][0]
    curves(strategies, "dinosaur", results / "influence_curves.png")
    stages(pictured, _published(quick), results)
    exploding = {name: mesh for name, (mesh, _) in real.items() if name.startswith("dino")} or {"dinosaur": pictured}
    broken = blow_up(exploding, results)
    save("blow-up", broken, markdown_table(broken))
    weights = measure(few, dict(list(WEIGHT_CASES.items())[::2]) if quick else WEIGHT_CASES)
    save("weights", weights, tables(weights))
    claims = influence_claims.measure(few if quick else shapes, n_vertices)
    save("claims of Au et al. 2008", claims, influence_claims.tables(claims))
    if quick:
        return
    crossed = influence_factorial.measure(_crossed(shapes))
    save("all combinations", crossed, influence_factorial.tables(crossed))
    others = measure(few, OTHERS)
    save("other operators", others, tables(others))
    rows: list[dict[str, Any]] = []
    for name, given in sorted(real.items(), key=lambda item: len(item[1][0].faces)):
        rows += measure({name: given}, CASES)
        save("strategies, real meshes", rows, tables(rows))


def _published(quick: bool) -> dict[str, ContractionSettings]:
    """Return the settings of each strategy and each further operator with the published energy."""
    cases = {
        name: ContractionSettings(energy="least_squares", **changes) for name, changes in DEGENERACY_STRATEGIES.items()
    }
    if not quick:
        cases |= {
            str(settings.operator): settings for settings in OTHERS.values() if settings.energy == "least_squares"
        }
    return cases


def _crossed(shapes: Some) -> dict[str, tuple[Mesh, Skeleton]]:
    """Return a shape without handles, one with handles, and the dinosaur, simplified to one size."""
    some = {name: shapes[name] for name in CROSSED}
    some[DINOSAUR.name] = read_mesh(DINOSAUR), make("dinosaur").truth
    return {
        name: (mesh, truth) for name, (mesh, truth) in prepared(some, MAX_CROSSED_FACES).items() if truth is not None
    }
