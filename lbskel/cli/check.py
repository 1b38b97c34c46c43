"""``lbskel check MESH``: the defects of a mesh, and how lbskel will treat them.

Exit code 1 where contraction is not advised.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from typing import Any

from lbskel.cli.options import add_command
from lbskel.io import read_mesh
from lbskel.preprocess import check


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel check``."""
    parser = add_command(
        subparsers,
        "check",
        "report the defects of a mesh and how lbskel will treat them",
        details="Exit code 1 where contraction is not advised.",
        example="lbskel check scan.stl",
    )
    parser.add_argument("mesh", metavar="MESH")
    parser.add_argument("--json", action="store_true", help="print all measures as JSON")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the report; 1 where contraction is not advised."""
    report = check(read_mesh(arguments.mesh))
    print(json.dumps(report.as_dict()) if arguments.json else f"{arguments.mesh}: {report}")
    return 0 if report.is_advised else 1
