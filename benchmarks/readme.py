"""Write tables and paragraphs of README.md from the results, between ``<!-- name -->`` and ``<!-- end -->``."""

from __future__ import annotations

__all__ = ["measures_table", "run"]

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import markdown_table
from benchmarks.operators_convergence import SCALED
from benchmarks.peers import PEERS
from benchmarks.readme_paragraphs import PARAGRAPHS, paragraph
from lbskel import MEASURES
from lbskel.shapes import VARIANTS

README = Path(__file__).parent.parent / "README.md"
PROPERTIES = ("symmetric", "local", "linear", "positive", "semidefinite")


def run(quick: bool, results: Path) -> None:
    """Fill every table and paragraph; a quick run changes nothing."""
    if quick:
        return
    text = README.read_text(encoding="utf-8")
    rows = {"skeletons": _skeletons, "hard": _hard, "speed": _speed, "operators": _operators}
    tables = {name: markdown_table(table(results)) for name, table in rows.items()}
    paragraphs = {name: paragraph(name, results) for name in PARAGRAPHS}
    for name, table in {"measures": measures_table(), **tables, **paragraphs}.items():
        pattern = re.compile(rf"(?<=<!-- {name} -->\n).*?(?=<!-- end -->)", re.S)
        before, after = pattern.split(text, maxsplit=1)
        text = before + table + after
    README.write_text(text, encoding="utf-8")


def measures_table() -> str:
    """Tabulate the measures of the score with their thresholds."""
    rows = []
    for name, measure in MEASURES.items():
        passes, fails = (">=", "<=") if measure.passes > measure.fails else ("<=", ">=")
        rows.append(
            {
                "measure": f"`{name}`",
                "passes": f"{passes} {measure.passes:g}",
                "fails": f"{fails} {measure.fails:g}" if np.isfinite(measure.fails) else "never",
                "what it measures": measure.text,
            }
        )
    return markdown_table(rows)


def _rows(path: Path, key: str = "rows") -> list[dict[str, Any]]:
    return json.loads(path.read_text(encoding="utf-8"))[key]


def _skeletons(results: Path) -> list[dict[str, Any]]:
    """Compute means over the shapes that gave a skeleton, and counts over all."""
    rows = _rows(results / "skeletons.json", "shapes")
    table = []
    pairs = dict.fromkeys((row["variant"], row["tool"]) for row in rows)
    for variant, tool in sorted(pairs, key=lambda pair: list(PEERS).index(pair[1])):
        own = [row for row in rows if (row["variant"], row["tool"]) == (variant, tool)]
        done = [row for row in own if "error" not in row]
        means = {key: np.mean([row[key] for row in done]) if done else np.nan for key in ("accuracy", "coverage")}
        worst = {key: np.mean([row[f"{key}_95"] for row in done]) if done else np.nan for key in means}
        table.append(
            {
                "": variant,
                "tool": tool,
                "accuracy": f"{means['accuracy']:.3f}",
                "its worst 5 %": f"{worst['accuracy']:.3f}",
                "coverage": f"{means['coverage']:.3f}",
                "its worst 5 % ": f"{worst['coverage']:.3f}",
                "topology": f"{sum(row.get('is_topology_right', False) for row in own)}/{len(own)}",
                "tips": f"{sum('n_tips' in row and row['n_tips'] == row['n_true_tips'] for row in own)}/{len(own)}",
            }
        )
    order = {variant: k for k, variant in enumerate(VARIANTS)}
    return sorted(table, key=lambda row: order[row[""]])


def _hard(results: Path) -> list[dict[str, Any]]:
    """List the means over hard shapes and creatures."""
    shown = {
        "accuracy": "accuracy",
        "accuracy_95": "its worst 5 %",
        "coverage": "coverage",
        "coverage_95": "its worst 5 % ",
    }
    return [
        {
            "": row["set"] if row["set"] == "creatures" else f"{row['set']} parameters",
            "tool": row["tool"],
            **{title: "-" if row[key] is None else f"{row[key]:.3f}" for key, title in shown.items()},
            "graphs right": row["graphs right"],
        }
        for row in _rows(results / "refinement.json", "summary")
    ]


def _speed(results: Path) -> list[dict[str, Any]]:
    """Compute processor seconds of other tools over those of lbskel, by default and with every vertex contracted."""
    ratios = _rows(results / "speed.json", "ratios")
    by_size = {(row["mesh"], row["faces"], row["reference"]): row for row in ratios}

    def shown(ratio: float | None) -> str:
        return "-" if ratio is None else f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}"

    return [
        {
            "mesh": mesh,
            "faces": f"{faces:,}",
            **{tool: shown(row.get(tool)) for tool in ("CGAL medial", "PyGEL3D", "skeletor")},
            "CGAL medial, of full resolution": shown(by_size[mesh, faces, "lbskel full"].get("CGAL medial")),
        }
        for (mesh, faces, reference), row in by_size.items()
        if reference == "lbskel" and any(row.get(tool) for tool in ("CGAL medial", "PyGEL3D", "skeletor"))
    ]


def _operators(results: Path) -> list[dict[str, Any]]:
    """List orders of convergence, properties kept on every shape, and the time on the largest mesh."""
    orders = {
        (row["case"], row["operator"].split(" (")[0], row["error"]): row["order"]
        for row in _rows(results / "operators_convergence.json")
    }
    costs = _rows(results / "operators_speed.json")
    largest = max(row["faces"] for row in costs)
    ratios = {row["call"]: row.get("ratio to libigl") for row in costs if row["faces"] == largest}
    shapes = _rows(results / "operators_properties.json")
    table = []
    for operator in dict.fromkeys(row["operator"] for row in shapes):
        passed = [row["passed"] for row in shapes if row["operator"] == operator and row.get("passed")]
        kept = [name for name in PROPERTIES if all(each.get(name) is not False for each in passed)]
        table.append(
            {
                "operator": f"`{operator}`" + (", after the best factor" if operator in SCALED else ""),
                "spectrum of a sphere": f"{orders['sphere spectrum', operator, 'eigenvalues']:.2f}",
                "of a flat torus": f"{orders['torus spectrum', operator, 'eigenvalues']:.2f}",
                "Poisson": f"{orders['sphere Poisson', operator, 'L2']:.2f}",
                "Poisson, 15 % of edges flipped": f"{orders['flipped Poisson', operator, 'L2']:.2f}",
                "keeps": ", ".join(kept),
                "time": f"{ratios[operator]:.2g}",
            }
        )
    return table
