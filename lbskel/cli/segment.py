"""``lbskel segment MESH -o PARTS.ply``: a mesh divided into its parts, each face with its part and a color."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from pathlib import Path
from typing import Any

from lbskel.applications import segment
from lbskel.applications.segmentation import THICKNESS, Segmentation
from lbskel.cli.html_option import add_html_option, refuse_page, write_page
from lbskel.cli.mesh_and_skeleton import add_input, mesh_and_skeleton
from lbskel.cli.options import add_command, add_force_option, refuse_unwritable
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.io.atomic_write import Content, write_all_safely
from lbskel.io.ply_parts import encode_ply_parts
from lbskel.visualization import Table


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel segment``."""
    parser = add_command(
        subparsers,
        "segment",
        "divide a mesh into its limbs and trunk",
        example="lbskel segment meshes/octopus.ply -o parts.ply --table parts.csv",
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="PARTS", help="ply to write: each face has its part and a color"
    )
    parser.add_argument("--table", metavar="CSV", help="write faces, area, volume, length and radius of each part")
    add_html_option(parser)
    parser.add_argument(
        "--thickness",
        default=THICKNESS[0],
        choices=THICKNESS,
        metavar="WHICH",
        help=f"what tells where the thickness jumps: {', '.join(THICKNESS)} (%(default)s)",
    )
    add_force_option(parser)
    add_input(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Divide and write."""
    refuse_unwritable(
        [(arguments.output, ("ply",)), (arguments.table, ("csv",))],
        arguments.force,
        [arguments.mesh, arguments.skeleton],
    )
    refuse_page(arguments.html, arguments.force)
    mesh, skeleton = mesh_and_skeleton(arguments)
    parts = segment(mesh, skeleton, thickness=arguments.thickness)
    contents: dict[Path, Content] = {Path(arguments.output): encode_ply_parts(mesh, parts.part_of_face)}
    if arguments.table:
        contents[Path(arguments.table)] = parts.to_csv()
    write_all_safely(contents, arguments.force)
    if arguments.html:
        shown = {"part_of_face": parts.part_of_face, "parts_name": "limbs and trunk", "parts_first": True}
        title = Path(arguments.mesh).name
        write_page(arguments.html, mesh, skeleton, arguments, title=title, tables=[_table(parts)], **shown)
    facts = {name: values.tolist() for name, values in parts.columns().items()}
    tell(arguments, f"{arguments.output}: {counted(len(parts), 'part')}", {"output": arguments.output, **facts})
    return 0


def _table(parts: Segmentation) -> Table:
    columns = parts.columns()
    rows = list(zip(*(values.tolist() for values in columns.values()), strict=True))
    return Table("Parts", [name.replace("_", " ") for name in columns], rows)
