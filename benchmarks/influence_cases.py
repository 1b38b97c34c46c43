"""Cases of the influence benchmark: settings by name, the result of each on each mesh, and their tables."""

from __future__ import annotations

__all__ = [
    "FAR",
    "OTHERS",
    "STOPS",
    "WEIGHT_CASES",
    "box_before",
    "breaks",
    "is_sound",
    "measure",
    "prepared",
    "ranking",
    "tables",
]

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from benchmarks.harness import markdown_table
from lbskel import OPERATORS, ContractionSettings, Skeleton
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.settings import DEGENERACY_STRATEGIES
from lbskel.contraction.weights import WEIGHTS
from lbskel.geometry.mesh import Mesh
from lbskel.pipeline.comparison import CASES, FREE_VOLUME_RATIO, record, representative, run_case

_COMPARED = {changes["operator"] for changes in DEGENERACY_STRATEGIES.values()}
OTHERS = {
    f"{operator}; {energy.replace('_', ' ')}": ContractionSettings(operator=operator, energy=energy)
    for operator in OPERATORS
    if operator not in _COMPARED
    for energy in ENERGIES
}
WEIGHT_CASES = {
    f"{name}, growth {growth:g}; {energy.replace('_', ' ')}": ContractionSettings(
        energy=energy, **{**weights, "contraction_growth": growth}
    )
    for energy in ENERGIES
    for name, weights in WEIGHTS.items()
    for growth in (2.0, 3.0)
}


OWN = ContractionSettings()
# shares of the volume, or of the area of an open mesh, at which a contraction may stop: as published, and as by default
STOPS = {FREE_VOLUME_RATIO: 0.0, OWN.volume_ratio: OWN.area_ratio}


def breaks(row: Mapping[str, Any], volume_ratio: float) -> bool:
    """Whether a run without roll-back breaks before it gets to a stop, a key of STOPS."""
    if row["broke at"] is None:
        return False
    before = slice(0, row["broke at"] - 1)
    volumes, areas = row["volumes"][before], row["areas"][before]
    if None in volumes:  # an open mesh
        return not any(area <= STOPS[volume_ratio] for area in areas)
    return not any(volume <= volume_ratio for volume in volumes)


def box_before(row: Mapping[str, Any]) -> float:
    """Compute the largest bounding box, over that at the start, of the steps before a run breaks."""
    end = len(row["boxes"]) if row["broke at"] is None else row["broke at"] - 1
    return max(row["boxes"][:end], default=1.0)


def measure(
    meshes: Mapping[str, tuple[Mesh, Skeleton | None]], cases: Mapping[str, ContractionSettings]
) -> list[dict[str, Any]]:
    """Measure each case on each mesh, one row each."""
    rows = []
    for name, (mesh, truth) in meshes.items():
        default = run_case(mesh, CASES["curvature_flow"])
        for case, settings in cases.items():
            result = default if settings == CASES["curvature_flow"] else run_case(mesh, settings)
            row = record(result, truth=truth, reference=default.skeleton)
            rows.append({"mesh": name, "vertices": len(mesh.vertices), "case": case, **row})
    return rows


def prepared(
    meshes: Mapping[str, tuple[Mesh, Skeleton | None]], max_faces: int
) -> dict[str, tuple[Mesh, Skeleton | None]]:
    """Return the largest component of each mesh, simplified if it has more faces."""
    return {name: (representative(mesh, most_faces=max_faces), truth) for name, (mesh, truth) in meshes.items()}


def _share(rows: Iterable[Mapping[str, Any]], key: str) -> str:
    """Count the rows where a value is true, out of those that have it."""
    known = [row[key] for row in rows if row.get(key) is not None]
    return f"{sum(map(bool, known))}/{len(known)}" if known else "-"


def _median(rows: Iterable[Mapping[str, Any]], key: str) -> float | None:
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(np.median(values)) if values else None


def summary(rows: list[dict[str, Any]], case: str) -> dict[str, Any]:
    """Summarize a case over all meshes: the steps without roll-back first, then the results with it."""
    own = [row for row in rows if row["case"] == case]
    free = [row for row in own if "free steps" in row]
    broken = [row for row in free if row["broke at"] is not None]
    after = [row["largest box"] for row in broken if row["largest box"] is not None]
    return {
        "case": case,
        **{
            f"breaks above {stop:g} of the volume": f"{sum(breaks(row, stop) for row in free)}/{len(free)}"
            if free
            else "-"
            for stop in STOPS
        },
        "first at step": min((row["broke at"] for row in broken), default=None),
        "largest box until then": max(map(box_before, free), default=None),
        "after that, chaos": max(after, default=None),
        "steps": _median(own, "steps"),
        "contracted": _share(own, "contracted"),
        "accuracy": _median(own, "accuracy"),
        "coverage": _median(own, "coverage"),
        "topology": _share(own, "topology right"),
        "tips": _share(own, "tips right"),
        "inside": _median(own, "inside"),
        "from default": _median(own, "from default"),
        "seconds": _median(own, "seconds"),
    }


FAR = 2.0  # coverage over the default's on the same mesh, above which parts are missing; a guess
RANKS = {1: "sound on most meshes", 2: "not sound on most", 3: "no skeleton"}


def is_sound(row: Mapping[str, Any], enough: float) -> bool:
    """Whether no step breaks, the contraction with roll-back reaches its target, and the coverage is good enough."""
    return (
        row.get("coverage") is not None
        and "broke at" in row
        and row["broke at"] is None
        and bool(row["contracted"])
        and row["coverage"] <= enough
    )


def ranking(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rank the cases by the number of meshes with a known skeleton on which they are sound, best first.

    A contraction is sound if without roll-back it breaks nowhere down to a millionth of the volume, with roll-back it
    reaches its target, and the coverage of its skeleton is at most twice that of the default.
    """
    enough = {row["mesh"]: FAR * row["coverage"] for row in rows if row["case"] == "curvature_flow"}
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        own = [row for row in rows if row["case"] == case]
        is_made = any(row.get("coverage") is not None for row in own)
        sound = [row for row in own if is_sound(row, enough[row["mesh"]])]
        rank = 3 if not is_made else 1 if 2 * len(sound) > len(own) else 2
        measured = {key: _median(own, key) for key in ("coverage", "accuracy", "steps")}
        lines.append(
            {"rank": rank, "what it is": RANKS[rank], "case": case, "sound on": f"{len(sound)}/{len(own)}", **measured}
        )
    return sorted(lines, key=lambda line: line["rank"])


def tables(rows: list[dict[str, Any]]) -> str:
    """Tabulate one line for each case, in the order of the rows."""
    return markdown_table([summary(rows, case) for case in dict.fromkeys(row["case"] for row in rows)])
