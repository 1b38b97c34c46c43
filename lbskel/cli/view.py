"""``lbskel view MESH -o PAGE.html``: an interactive page of a mesh, its skeleton, and how one became the other."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from pathlib import Path
from typing import Any

from lbskel.cli.html_option import refuse_page, write_page
from lbskel.cli.mesh_and_skeleton import add_input, skeleton_of
from lbskel.cli.options import add_command, add_force_option
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.io import as_shape


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel view``."""
    parser = add_command(
        subparsers,
        "view",
        "show a mesh or a point cloud and its skeleton on an interactive page",
        details="One HTML file, below 8 MB, that any browser opens without a network: mesh, skeleton, every step of "
        "the contraction, inscribed balls, parts, branch table, report and score.",
        example="lbskel view meshes/dinosaur.ply -o dinosaur.html",
    )
    parser.add_argument("-o", "--output", required=True, metavar="PAGE", help="html to write")
    add_force_option(parser)
    add_input(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Read or make the skeleton, and write the page."""
    refuse_page(arguments.output, arguments.force)
    shape = as_shape(arguments.mesh)
    skeleton = skeleton_of(shape, arguments, is_shown=True)
    arguments.on_stage("page")
    write_page(arguments.output, shape, skeleton, arguments, title=Path(arguments.mesh).name)
    numbers = {"node": len(skeleton.nodes), "tip": len(skeleton.tips), "cycle": skeleton.cycle_rank}
    counts = ", ".join(counted(n, noun) for noun, n in numbers.items())
    tell(arguments, f"{arguments.output}: {counts}", {"output": arguments.output, **skeleton.report})
    return 0
