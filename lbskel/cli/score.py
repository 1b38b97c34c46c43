"""``lbskel score SKELETON MESH``: how good a skeleton is, measured on its mesh.

Exit codes: 0 pass or warn, 1 fail, 2 bad input.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from dataclasses import asdict
from typing import Any

from lbskel.errors import MeshError
from lbskel.evaluation.scoring import MEASURES, Score
from lbskel.io import read_mesh, read_skeleton
from lbskel.pipeline.judging import score


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser("score", help="measure a skeleton on its mesh", description=__doc__)
    parser.add_argument("skeleton")
    parser.add_argument("mesh", help="the mesh that the skeleton was made from, in the same coordinates")
    parser.add_argument("--json", action="store_true", help="print as JSON")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure and print; 1 where a measure fails."""
    skeleton, mesh = read_skeleton(arguments.skeleton), read_mesh(arguments.mesh)
    try:
        found = score(skeleton, mesh)
    except MeshError as error:
        raise MeshError(f"{arguments.skeleton} on {arguments.mesh}: {error}") from None
    if arguments.json:
        names = {"skeleton": str(arguments.skeleton), "mesh": str(arguments.mesh)}
        print(json.dumps({**names, **found.report()}))
    else:
        print(_table(found))
    return 0 if found.passed else 1


def _table(found: Score) -> str:
    """A line for each measure: its name, value, verdict and what it tells."""
    values = asdict(found)
    lines = [
        f"{name.replace('_', ' '):18} {_text(values[name]):>8}  {verdict:12}  {MEASURES[name].text}"
        for name, verdict in found.verdicts.items()
    ]
    return "\n".join([*lines, f"verdict: {found.verdict}; the shape has {found.extremities} extremities"])


def _text(value: float | None) -> str:
    """A measure as a person reads it."""
    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.3f}"
