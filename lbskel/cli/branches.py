"""``lbskel branches MESH -o TABLE``: the branches of a mesh's skeleton as a table."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from pathlib import Path
from typing import Any

from lbskel.applications import branch_table
from lbskel.cli.mesh_and_skeleton import add_input, mesh_and_skeleton
from lbskel.cli.options import add_command, add_force_option, add_tree_and_units, refuse_unwritable
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.geometry.scaling import require_scale
from lbskel.io import write_safely
from lbskel.skeleton.spanning_tree import to_tree


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel branches``."""
    parser = add_command(
        subparsers,
        "branches",
        "measure the branches of a mesh: ends, order, length, radii, sections, volume, angles",
        details="One row for each branch, in the units of the mesh or those of --scale. Branches lead away from the "
        "first node of the skeleton: that at --root, else the soma, else the thickest tip. Without -o the table is "
        "printed as CSV.",
        example="lbskel branches meshes/tree.stl -o tree_branches.csv --scale 10 --units mm",
    )
    parser.add_argument("-o", "--output", metavar="TABLE", help="table to write: csv or json")
    add_force_option(parser)
    add_tree_and_units(
        parser, "the lengths and positions in the table, areas by its square, volumes by its cube", "of lengths"
    )
    add_input(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure and write or print the table."""
    output = Path(arguments.output) if arguments.output else None
    refuse_unwritable([(output, ("csv", "json"))], arguments.force, [arguments.skeleton])
    require_scale(arguments.scale)
    mesh, skeleton = mesh_and_skeleton(arguments)
    table = branch_table(
        to_tree(skeleton) if arguments.tree else skeleton, mesh, scale=arguments.scale, units=arguments.units
    )
    if output is None:
        tell(arguments, table.to_csv().rstrip("\n"), json.loads(table.to_json()))
    else:
        write_safely(
            output, table.to_json() if output.suffix.lower() == ".json" else table.to_csv(), force=arguments.force
        )
        lengths = f", lengths in {table.units}" if table.units else ""
        facts = {"output": str(output), "n_branches": len(table)}
        tell(arguments, f"{output}: {counted(len(table), 'branch')}{lengths}", facts)
    return 0
