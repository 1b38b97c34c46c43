"""``lbskel score SKELETON MESH``: the quality of a skeleton, measured on its mesh or its point cloud.

Exit codes: 0 pass or warn, 1 fail, 2 bad input.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

from lbskel.cli.options import add_command
from lbskel.cli.terminal import tell
from lbskel.errors import MeshError
from lbskel.io import as_shape, read_skeleton
from lbskel.pipeline.evaluation import score


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel score``."""
    parser = add_command(
        subparsers,
        "score",
        "measure the quality of a skeleton on its mesh or its point cloud",
        details="Exit code 0 for pass and warn, 1 for fail, 2 for bad input.",
        example="lbskel score dinosaur.swc meshes/dinosaur.ply",
    )
    parser.add_argument("skeleton", metavar="SKELETON")
    parser.add_argument(
        "mesh", metavar="MESH", help="the mesh or cloud that the skeleton was made from, in the same coordinates"
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure and print; 1 if a measure fails."""
    skeleton, mesh = read_skeleton(arguments.skeleton), as_shape(arguments.mesh)
    try:
        found = score(skeleton, mesh)
    except MeshError as error:
        raise MeshError(f"{arguments.skeleton} on {arguments.mesh}: {error}") from None
    names = {"skeleton": str(arguments.skeleton), "mesh": str(arguments.mesh)}
    tell(arguments, str(found), {**names, **found.report()})
    return 0 if found.passed else 1
