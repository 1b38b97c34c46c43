"""The study of Laplacians, degenerate triangles, weights and solvers, written from the results of other benchmarks.

Every figure comes from influence.json or solvers.json; nothing is measured.
"""

from __future__ import annotations

__all__ = ["run"]

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from benchmarks import influence_factorial, solvers_ordinary
from benchmarks.harness import markdown_table
from benchmarks.influence_cases import FAR, STOPS, box_before, breaks, is_sound, ranking
from benchmarks.solvers_trials import ITERATIONS
from lbskel.pipeline.comparison import CASES

Rows: TypeAlias = Sequence[Mapping[str, Any]]

PUBLISHED, OWN = STOPS
DEFAULT, PAPER = "curvature_flow", "au2008"
PLAIN, CLAMPED = "none; least squares", "clamped cotangents; least squares"
ZERO, HELD = "identity row, right-hand side zero; least squares", "identity row, held; least squares"
SUMS, DELAUNAY = "clamped row sums; least squares", "intrinsic Delaunay; least squares"
STRATEGIES = (
    *(case for case in CASES if case.endswith("; least squares") and "to scale" not in case),
    "none; curvature flow",
    PAPER,
    "au2008_demo",
    "cao2010_meshes",
    "least_squares",
    DEFAULT,
)
FEW_STEPS = 10  # "usually fewer than ten iterations", Au et al. 2008
PAGE = """# Influence of Laplacians, degenerate triangles, weights and solvers on the skeleton

Every figure on this page is written by `python -m benchmarks study` from [influence.md](influence.md) ({influence}) and
[solvers.md](solvers.md) ({solvers}), which have every row; `python -m benchmarks influence solvers study
--meshes FOLDER` repeats all of it. {older}{n_shapes} shapes with a known axis and {n_meshes} other meshes
({meshes}) were contracted by every case twice: *free*, as published, where each step is solved once for the positions
and always accepted; and *with roll-back*, as `skeletonize` runs. Distances are in local radii, displacements and boxes
in diameter bounds.

## Which contractions break, where, and what prevents it

A free run *breaks* at the step after which its area or its bounding box has grown. Each count says down to which stop
it holds: {published} of the volume, the published one, or {own}, lbskel's (on open meshes a share of the area). A case
is *sound* on a shape if the free run does not break above {published}, the run with roll-back reaches its target, and
the coverage of the axis is at most {far:g} times that of the default. Steps, accuracy and coverage are medians, with
roll-back.

{strategies}
![dino.off: plain cotangents and literal identity rows next to what prevents their failure](influence_blow_up_dino.png)
![dinosaur.ply: the same](influence_blow_up_dinosaur.png)

{bullets}
**What follows a break is chaos.** A broken step amplifies rounding errors, so how far it throws the surface is another
figure on another machine, with another compiler or order of vertices. Here boxes grew to up to {chaos} times that at
the start; only the step of the break, and what comes before it, repeats.

Mesh, one step, more steps (to 5 % of the area, or the first that breaks) and skeleton are in
`influence_dinosaur_*.png` for each operator, for example [none](influence_dinosaur_none.png),
[clamped](influence_dinosaur_clamped_cotangents.png), [mean value](influence_dinosaur_mean_value.png),
[graph](influence_dinosaur_graph.png), [robust](influence_dinosaur_robust.png). Area and box by step:

![area and bounding box by step](influence_curves.png)

## The energy, and the weights

{energies}
{weights}
## All combinations

{combinations}
## Solvers

![error by iteration and by seconds](solvers.png)

CHOLMOD's seconds and error, and of the others the multiple of that time and the error; *fails*: the error that
{iterations} iterations leave.

{solver_table}
{solver_sentences}
## Claims of Au et al. 2008

{claims}"""


def run(quick: bool, results: Path) -> None:
    """Write study.md from influence.json and solvers.json."""
    influence, solvers = (json.loads((results / f"{name}.json").read_text()) for name in ("influence", "solvers"))
    shapes, real = influence["strategies"], influence.get("strategies, real meshes", [])
    meshes, ordinary = _names(real, "mesh"), solvers.get("ordinary", [])
    text = PAGE.format(
        older=_older(influence),
        influence=_when(influence),
        solvers=_when(solvers),
        n_shapes=len({row["mesh"] for row in shapes}),
        n_meshes=len(meshes),
        meshes=", ".join(f"`{mesh}`" for mesh in meshes) or "none",
        published=f"{PUBLISHED:g}",
        own=f"{OWN:g}",
        far=FAR,
        strategies=markdown_table([_strategy(shapes, real, case) for case in STRATEGIES]),
        bullets=_bullets(shapes, real),
        chaos=_chaos([*shapes, *real]),
        energies=_energies(shapes),
        weights=_weights(influence["weights"]),
        combinations=_combinations(influence.get("all combinations", [])),
        solver_table=markdown_table(solvers_ordinary.table(ordinary)) if ordinary else "Not measured at this commit.",
        solver_sentences=solvers_ordinary.sentences(ordinary) if ordinary else "",
        iterations=ITERATIONS,
        claims=_claims(influence["claims of Au et al. 2008"]),
    )
    (results / "study.md").write_text(text, encoding="utf-8")


def _when(result: Mapping[str, Any]) -> str:
    return f"commit {result['machine']['commit']}, {result['machine']['date']}"


def _older(influence: Mapping[str, Any]) -> str:
    """Name the parts that were not measured again at the commit of the others."""
    last = influence["machine"]["commit"]
    older = {name: at for name, at in influence.get("parts", {}).items() if at != last and name != "quick"}
    told = "; ".join(f"*{name}* at commit {at}" for name, at in older.items())
    return f"Measured at another commit: {told}. " if older else ""


def _of(rows: Rows, case: str) -> list[Mapping[str, Any]]:
    return [row for row in rows if row["case"] == case]


def _count(rows: Rows, stop: float) -> str:
    """Count the free runs that break above a stop."""
    free = [row for row in rows if "free steps" in row]
    return f"{sum(breaks(row, stop) for row in free)}/{len(free)}"


def _first(rows: Rows) -> int | None:
    return min((row["broke at"] for row in rows if row.get("broke at")), default=None)


def _median(rows: Rows, key: str) -> float | None:
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(np.median(values)) if values else None


def _reached(rows: Rows) -> str:
    return f"{sum(bool(row.get('contracted')) for row in rows)} of {len(rows)}"


def _displacement(rows: Rows) -> float | None:
    """Compute the largest displacement of a treated vertex in a step, up to the first that breaks."""
    values = [
        value
        for row in rows
        for value in row.get("max_displacement", [])[: row["broke at"]]
        if value is not None and row["treated"]
    ]
    return max(values, default=None)


def _strategy(shapes: Rows, real: Rows, case: str) -> dict[str, Any]:
    """Summarize a case."""
    own, others = _of(shapes, case), _of(real, case)
    (line,) = (line for line in ranking([dict(row) for row in shapes]) if line["case"] == case)
    free = [row for row in own if "free steps" in row]
    return {
        "case": case,
        "sound on": line["sound on"],
        **{f"breaks above {stop:g}: shapes, meshes": f"{_count(own, stop)}, {_count(others, stop)}" for stop in STOPS},
        "first at step": _first([*own, *others]),
        "largest box until then": max(map(box_before, free), default=None),
        "reaches its target": _reached(own),
        **{key: _median(own, key) for key in ("steps", "accuracy", "coverage")},
    }


def _bullets(shapes: Rows, real: Rows) -> str:
    """Tell the figures of each treatment of degenerate triangles in a sentence."""

    def told(case: str) -> str:
        own = _of(shapes, case)
        first = _first([*own, *_of(real, case)])
        others = _of(real, case)
        return (
            f"break on {_count(own, PUBLISHED)} shapes above {PUBLISHED:g} of the volume and on {_count(own, OWN)} "
            f"above {OWN:g}, on {_count(others, PUBLISHED)} and {_count(others, OWN)} meshes"
            + (f", first at step {first}" if first else "")
            + f"; with roll-back they reach their target on {_reached(own)} shapes"
        )

    moved = {case: _displacement([*_of(shapes, case), *_of(real, case)]) for case in (CLAMPED, ZERO, HELD)}
    enough = {row["mesh"]: FAR * row["coverage"] for row in _of(shapes, DEFAULT)}
    always = [
        case
        for case in STRATEGIES
        if all(is_sound(row, enough[row["mesh"]]) for row in _of(shapes, case))
        and not any(breaks(row, PUBLISHED) for row in _of(real, case))
    ]
    lines = [
        f"**Plain cotangents** {told(PLAIN)}.",
        f"**Clamped cotangents** {told(CLAMPED)}. A clamped row does not vanish on a plane, so it moves vertices along "
        f"the surface: by up to {moved[CLAMPED]:.2g} in one step.",
        "**Identity rows with zero on the right-hand side** ask for v = 0, the center of the mesh. They "
        f"{told(ZERO)}; their vertices move by up to {moved[ZERO]:.2g} in one step, with W_L v on the right-hand side "
        f"by {moved[HELD]:.2g}.",
        f"**Clamped row sums**, the authors' own remedy, {told(SUMS)}.",
        f"**The paper as printed** (`{PAPER}`: plain cotangents, its weights, no clamp): these steps {told(PAPER)}.",
        "**Sound on every shape, and unbroken on every mesh**: " + ", ".join(f"*{case}*" for case in always) + ".",
    ]
    return "".join(f"- {line}\n" for line in lines)


def _chaos(rows: Rows) -> str:
    """Tell the largest box after a break."""
    boxes = [row["largest box"] for row in rows if row.get("broke at") and row["largest box"] is not None]
    return f"{max(boxes, default=1.0):.1g}"


def _energies(shapes: Rows) -> str:
    """Compare the two energies on the same operator."""
    lines = [
        {
            "energy, intrinsic Delaunay": case.split("; ")[-1],
            **{key: _median(_of(shapes, case), key) for key in ("steps", "accuracy", "coverage")},
            **{key: _right(_of(shapes, case), key) for key in ("topology right", "tips right")},
        }
        for case in ("intrinsic Delaunay; curvature flow", DELAUNAY)
    ]
    plain = _of(shapes, "none; curvature flow")
    return (
        f"{markdown_table(lines)}\nWith plain cotangents the curvature flow breaks on {_count(plain, PUBLISHED)} "
        f"shapes above {PUBLISHED:g} of the volume, the least-squares energy, which squares L, on "
        f"{_count(_of(shapes, PLAIN), PUBLISHED)}.\n"
    )


def _right(rows: Rows, key: str) -> str:
    return f"{sum(bool(row.get(key)) for row in rows)}/{len(rows)}"


def _weights(rows: Rows) -> str:
    """Tabulate each choice of weights by energy and growth: median steps and coverage."""
    lines: dict[str, dict[str, Any]] = {}
    for case in dict.fromkeys(row["case"] for row in rows):
        name, growth, energy = case.replace("; ", ", ").split(", ")
        own = _of(rows, case)
        steps, coverage = _median(own, "steps"), _median(own, "coverage")
        told = "no skeleton" if coverage is None else f"{steps:g} steps, {coverage:.2g}, {_reached(own)}"
        lines.setdefault(name, {"weights": f"`{name}`"})[f"{energy}, {growth}"] = told
    n_meshes = len({row["mesh"] for row in rows})
    note = f"Median steps and coverage on {n_meshes} shapes, and on how many of them the target is reached."
    return f"{markdown_table(list(lines.values()))}\n{note}\n"


def _combinations(rows: Rows) -> str:
    """Summarize the factorial: shares that are sound, shares of variance, the best and the worst."""
    if not rows:
        return "Not measured in this run.\n"
    one, two, three = influence_factorial.FACTORS
    parts = [influence_factorial.crossed(rows, factor, two) for factor in (one, three)]
    shares = influence_factorial.explained(rows)
    best, worst = (influence_factorial.by_combination(rows)[k] for k in (0, -1))
    n = len({(row[one], row[two], row[three]) for row in rows})
    meshes = ", ".join(dict.fromkeys(row["mesh"] for row in rows))
    told = ", ".join(f"{line['what']} {100 * line['share']:.0f} %" for line in shares[:5])

    def named(line: Mapping[str, Any]) -> str:
        coverage = "no skeleton" if line["coverage"] is None else f"coverage {line['coverage']:.2g}"
        return f"{line[one]}, {line[two]}, {line[three]} ({line['sound on']}, {coverage})"

    return (
        f"{n} combinations that mean something, on {meshes}, each simplified: the share of the runs that is sound.\n\n"
        + "\n".join(parts)
        + f"\nShares of the variance of soundness: {told}. Best: {named(best)}. Worst: {named(worst)}.\n"
    )


def _claims(rows: Rows) -> str:
    """Tabulate what was measured of each claim, by preset."""
    told: dict[str, Callable[[Rows], str]] = {
        f"fewer than {FEW_STEPS} iterations": lambda own: (
            f"{sum(row['steps'] < FEW_STEPS for row in own)}/{len(own)}, {_span(own, 'steps')}"
        ),
        "insensitive to noise: mean accuracy, clean and noisy": lambda own: _pair(own, "accuracy", "accuracy, noisy"),
        "to rotation: largest change of accuracy": lambda own: f"{max(abs(row['turned, apart']) for row in own):.0e}",
        "to pose: mean accuracy, straight and bent": lambda own: _pair(own, "accuracy", "accuracy, bent"),
        "to pose: as many tips": lambda own: _right(own, "bent, tips alike"),
        "homotopic": lambda own: _right(own, "homotopic"),
        "thin regions first: median rank correlation": lambda own: f"{_median(own, 'thin first'):.2f}",
    }
    by_preset = {preset: [row for row in rows if row["preset"] == preset] for preset in _names(rows, "preset")}
    return markdown_table(
        [{"claim": claim} | {f"`{name}`": tell(own) for name, own in by_preset.items()} for claim, tell in told.items()]
    )


def _names(rows: Rows, key: str) -> list[str]:
    return list(dict.fromkeys(row[key] for row in rows))


def _span(rows: Rows, key: str) -> str:
    values = [row[key] for row in rows]
    return f"{min(values)} to {max(values)}"


def _pair(rows: Rows, one: str, other: str) -> str:
    return " and ".join(f"{np.mean([row[key] for row in rows]):.3f}" for key in (one, other))
