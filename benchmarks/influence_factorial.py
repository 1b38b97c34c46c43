"""Full factorial of operators, treatments of degenerate rows, energies and weights, on a few meshes.

Meaningless combinations are left out. Treatments of degenerate rows do not go with the curvature-flow energy, which has
no such rows, with operators whose weights do not depend on the shapes of triangles, or with the operator that replaces
rows itself; nor does the curvature-flow energy with operators that are not symmetric. Operators with the stiffness of
another are left out too. Operators whose weights have a unit are normalized by area, because the rules for the initial
weight assume weights without a unit.
"""

from __future__ import annotations

__all__ = ["FACTORS", "by_combination", "combinations", "crossed", "explained", "measure", "tables"]

from collections.abc import Mapping, Sequence
from itertools import combinations as pairs_of
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import markdown_table
from benchmarks.influence_cases import FAR, is_sound
from lbskel import OPERATORS, ContractionSettings, Skeleton
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.weights import WEIGHTS
from lbskel.geometry.mesh import Mesh
from lbskel.pipeline.comparison import FREE_VOLUME_RATIO, AreaNormalized, record, run_case

# lbskel's, those of the paper, and those of its program: with six of them, weights explained 1 % of the variance
CROSSED = {name: WEIGHTS[name] for name in ("local_radius", "au2008", "au2008_demo")}
FACTORS = ("operator", "energy and rows", "weights")
DEFAULT = ("intrinsic_delaunay", "curvature flow", "local_radius")
NOT_SYMMETRIC = ("mean_value",)
SAME = ("random_walk",)  # equal to graph but for the mass, which no energy uses
UNTREATED = ("graph", "heat_kernel", "cotangent_identity")
WITH_A_UNIT = ("inverse_distance", "mean_value", "mean_value_symmetric")
KEPT = (  # keys of a record that rows keep
    "error",
    "steps",
    "contracted",
    "accuracy",
    "coverage",
    "topology right",
    "tips right",
    "inside",
    "seconds",
    "broke at",
    "how",
    "free steps",
    "largest box",
)
SHOWN = 8  # how many of the best and of the worst combinations are tabulated


def combinations(operators: Sequence[str] = tuple(OPERATORS)) -> dict[tuple[Any, ...], ContractionSettings]:
    """Return settings by operator, energy with row treatment, and weights."""
    found = {}
    for operator in operators:
        if operator in SAME:
            continue
        chosen = AreaNormalized(operator) if operator in WITH_A_UNIT else operator
        for energy in ENERGIES:
            if energy == "curvature_flow" and operator in NOT_SYMMETRIC:
                continue
            has_rows = energy == "least_squares" and operator not in UNTREATED
            for rows in ROW_TREATMENTS if has_rows else ("none",):
                name = energy.replace("_", " ") + (f", {rows}" if rows != "none" else "")
                for weights, changes in CROSSED.items():
                    found[operator, name, weights] = ContractionSettings(
                        operator=chosen, energy=energy, degenerate_rows=rows, **changes
                    )
    return found


def measure(
    meshes: Mapping[str, tuple[Mesh, Skeleton]], operators: Sequence[str] = tuple(OPERATORS)
) -> list[dict[str, Any]]:
    """Measure each combination on each mesh, one row each, with whether it is sound."""
    rows = []
    for name, (mesh, truth) in meshes.items():
        own = []
        for levels, settings in combinations(operators).items():
            row = record(run_case(mesh, settings), truth=truth)
            kept = {key: row[key] for key in KEPT if key in row}
            own.append({"mesh": name, **dict(zip(FACTORS, levels, strict=True)), **kept})
        (default,) = (row for row in own if _levels(row) == DEFAULT)
        rows += [{**row, "sound": is_sound(row, FAR * default["coverage"])} for row in own]
    return rows


def _levels(row: Mapping[str, Any]) -> tuple[Any, ...]:
    return tuple(row[factor] for factor in FACTORS)


def _mean(rows: Sequence[Mapping[str, Any]], key: str) -> float | None:
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(np.mean(values)) if values else None


def _dummies(rows: Sequence[Mapping[str, Any]], *factors: str) -> NDArray[np.float64]:
    """Build (n, levels) indicator columns, one for each level or combination of levels that occurs."""
    levels = [tuple(row[factor] for factor in factors) for row in rows]
    number = {level: column for column, level in enumerate(dict.fromkeys(levels))}
    return np.eye(len(number))[[number[level] for level in levels]]


def _fit(y: NDArray[np.float64], *columns: NDArray[np.float64]) -> float:
    """Return the share of the variance of y that a linear model of the columns explains."""
    X = np.hstack(columns)
    residual = y - X @ np.linalg.lstsq(X, y)[0]
    return 1 - float(residual @ residual) / float(((y - y.mean()) ** 2).sum())


def explained(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Compute which share of the variance of soundness each factor, and each interaction, explains in addition."""
    y = np.array([row["sound"] for row in rows], dtype=np.float64)
    if y.min() == y.max():
        return []
    single = {factor: _dummies(rows, factor) for factor in (*FACTORS, "mesh")}
    together = _fit(y, *single.values())
    lines = [
        {"what": factor, "share": together - _fit(y, *(X for other, X in single.items() if other != factor))}
        for factor in single
    ]
    lines += [
        {"what": f"{one} with {other}", "share": _fit(y, *single.values(), _dummies(rows, one, other)) - together}
        for one, other in pairs_of(single, 2)
    ]
    return sorted(lines, key=lambda line: -line["share"])


def _level_line(rows: Sequence[Mapping[str, Any]], factor: str, level: Any) -> dict[str, Any]:
    own = [row for row in rows if row[factor] == level]
    return {
        "factor": factor,
        "level": level,
        "runs": len(own),
        "sound": _mean(own, "sound"),
        f"breaks above {FREE_VOLUME_RATIO:g} of the volume": float(
            np.mean([row.get("broke at") is not None for row in own])
        ),
        "contracted": float(np.mean([bool(row.get("contracted")) for row in own])),
        "coverage": _mean(own, "coverage"),
        "accuracy": _mean(own, "accuracy"),
        "steps": _mean(own, "steps"),
        "seconds": _mean(own, "seconds"),
    }


def crossed(rows: Sequence[Mapping[str, Any]], one: str, other: str) -> str:
    """Tabulate the share that is sound by two factors."""
    lines = []
    for level in dict.fromkeys(row[one] for row in rows):
        own = [row for row in rows if row[one] == level]
        cells = {
            str(across): _mean([row for row in own if row[other] == across], "sound")
            for across in dict.fromkeys(row[other] for row in rows)
        }
        lines.append({one: level, **cells})
    return markdown_table(lines)


def by_combination(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Summarize each combination over all meshes: the best first, those without a skeleton last."""
    lines = []
    for levels in dict.fromkeys(_levels(row) for row in rows):
        own = [row for row in rows if _levels(row) == levels]
        measured = {key: _mean(own, key) for key in ("coverage", "accuracy", "steps", "seconds")}
        count = sum(row["sound"] for row in own)
        lines.append({**dict(zip(FACTORS, levels, strict=True)), "sound on": f"{count}/{len(own)}", **measured})

    def order(line: dict[str, Any]) -> tuple[int, float]:
        return -int(line["sound on"].split("/")[0]), np.inf if line["coverage"] is None else line["coverage"]

    return sorted(lines, key=order)


def tables(rows: Sequence[Mapping[str, Any]]) -> str:
    """Tabulate main effects, shares of variance, every pair of factors, the best and the worst combinations."""
    levels = [
        _level_line(rows, factor, level) for factor in FACTORS for level in dict.fromkeys(row[factor] for row in rows)
    ]
    lines = by_combination(rows)
    parts = {
        "Each level over all the others": markdown_table(levels),
        "Share of the variance of soundness": markdown_table(explained(rows)),
        **{f"Share sound, {one} by {other}": crossed(rows, one, other) for one, other in pairs_of(FACTORS, 2)},
        f"The best {SHOWN} of {len(lines)}": markdown_table(lines[:SHOWN]),
        f"The worst {SHOWN}": markdown_table(lines[-SHOWN:]),
    }
    return "\n".join(f"### {title}\n\n{text}" for title, text in parts.items())
