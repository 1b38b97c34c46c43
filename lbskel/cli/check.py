"""``lbskel check MESH``: the defects of a mesh or a point cloud, and how lbskel will treat them.

Exit code 1 where contraction is not advised.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

from lbskel.cli.options import add_command
from lbskel.cli.terminal import tell
from lbskel.geometry.mesh import PointCloud
from lbskel.io import as_shape
from lbskel.preprocess import check
from lbskel.preprocess.point_diagnostics import check_points


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel check``."""
    parser = add_command(
        subparsers,
        "check",
        "report the defects of a mesh or a point cloud and how lbskel will treat them",
        details="Exit code 1 where contraction is not advised.",
        example="lbskel check scan.stl",
        json="print all measures as JSON",
    )
    parser.add_argument("mesh", metavar="MESH")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the report; 1 where contraction is not advised."""
    shape = as_shape(arguments.mesh)
    report = check_points(shape) if isinstance(shape, PointCloud) else check(shape)
    tell(arguments, f"{arguments.mesh}: {report}", report.as_dict())
    return 0 if report.is_advised else 1
