"""Which operator to take for which application: a page from the results of the other parts."""

from __future__ import annotations

__all__ = ["run", "table"]

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness import markdown_table

TITLES = {
    "smoothing": "Smoothing: distance to the clean surface, drift in a plane, and a step of mean curvature on a sphere",
    "editing": "Editing: a bent bar on good and on bad triangles",
    "geodesics": "Geodesic distances: mean error over the largest distance",
    "spectrum": "Spectrum: largest error of 25 eigenvalues of a sphere; rms error of a shape from 100 functions",
}
ADVICE = {
    "smoothing": "`cotangent`: it removes noise as well as any and does not let vertices drift along a surface. Flat "
    "triangles hardly matter to an implicit step, whose matrix has the areas too. `graph` smooths the triangles as "
    "well, so vertices drift; where triangles are even that does no harm, and with a step of its own it removes noise "
    "a little better ([applications_smoothing.md](applications_smoothing.md)). Weights of another unit need a time "
    "step of another unit.",
    "editing": "`robust`, the default: on good triangles all operators agree, and on needles and caps cotangents are "
    "so large that the surface is thrown off. Triangles that are long but not degenerate change the result of every "
    "operator whose edges are those of the mesh; `robust` and `intrinsic_delaunay` flip them.",
    "geodesics": "On thin triangles take `robust`, or `intrinsic_delaunay` where the mesh is a manifold: they alone "
    "flip edges. Mollification and clamping leave the triangles as thin as they were; needles in a mesh that is dense "
    "enough around them do no harm to any of the cotangent family. Weights without the geometry of the mesh (`graph`, "
    "`random_walk`) or of another unit (`inverse_distance`, `mean_value_symmetric`) give no distances.",
    "spectrum": "On good meshes the cotangent family agrees, and the best factor shows how much of the error is "
    "common, one of areas. `graph` and `random_walk` have no unit of area; their functions still hold a shape.",
}
NEAR = 1.05  # an operator is named with the best if its error is at most this many times the smallest
ROUNDING = 1e-9  # errors below are equal to zero


def table(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Tabulate, for each measure, the smallest error, the operators that reach it, and who refuses.

    The cotangent operator, the tufted one and the worst are told beside it.
    """
    lines = []
    for column in dict.fromkeys(key for row in rows for key in row if key != "operator"):
        numbers = {row["operator"]: row[column] for row in rows if isinstance(row.get(column), float)}
        best, worst = max(min(numbers.values()), ROUNDING), max(numbers, key=numbers.__getitem__)
        lines.append(
            {
                "case": column,
                "smallest error": min(numbers.values()),
                "by": ", ".join(name for name, error in numbers.items() if error <= NEAR * best),
                "`cotangent`": numbers.get("`cotangent`"),
                "`robust`": numbers.get("`robust`"),
                "largest error": f"{worst} {numbers[worst]:.3g}",
                "refused": ", ".join(row["operator"] for row in rows if row["operator"] not in numbers) or "none",
            }
        )
    return lines


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Write applications_study.md from the results that are there; nothing is measured, so peers change nothing."""
    parts = ["# Which operator to take for which application\n"]
    for name, title in TITLES.items():
        path = results / f"applications_{name}.json"
        if path.exists():
            measured = json.loads(path.read_text(encoding="utf-8"))
            parts.append(f"## {title}\n\n{ADVICE[name]}\n\n{markdown_table(table(measured['operators']))}")
            parts.append(f"From [applications_{name}.md](applications_{name}.md), {measured['machine']['date']}.\n")
    (results / "applications_study.md").write_text("\n".join(parts), encoding="utf-8")
