"""``lbskel rig MESH -o OUT.glb``: a mesh with bones and weights, as binary glTF."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from pathlib import Path
from typing import Any

from lbskel.applications import rig
from lbskel.applications.rigging import MAX_BONES, MAX_INFLUENCES
from lbskel.cli.mesh_and_skeleton import add_input, mesh_and_skeleton
from lbskel.cli.options import add_command, add_force_option, refuse_existing
from lbskel.errors import FormatError
from lbskel.io.gltf_skin import UP_AXES, write_rig


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel rig``."""
    parser = add_command(
        subparsers,
        "rig",
        "make bones and weights for animation, as glTF",
        example="lbskel rig meshes/dinosaur.ply -o dinosaur.glb --up z --preset character",
    )
    parser.add_argument("-o", "--output", required=True, metavar="GLB", help="binary glTF to write")
    parser.add_argument(
        "--max-bones", type=int, default=MAX_BONES, metavar="N", help="largest number of bones (%(default)s)"
    )
    parser.add_argument(
        "--max-influences",
        type=int,
        default=MAX_INFLUENCES,
        metavar="N",
        help="largest number of bones that a vertex follows (%(default)s)",
    )
    parser.add_argument(
        "--up", default="y", choices=UP_AXES, metavar="AXIS", help="axis of the mesh that points up: y (default) or z"
    )
    add_force_option(parser)
    add_input(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Rig and write."""
    output = Path(arguments.output)
    if output.suffix.lower() != ".glb":
        raise FormatError(f"{output}: the name must end in .glb")
    refuse_existing([output], arguments.force)
    mesh, skeleton = mesh_and_skeleton(arguments)
    rigged = rig(mesh, skeleton, max_bones=arguments.max_bones, max_influences=arguments.max_influences)
    write_rig(output, rigged, up=arguments.up, force=arguments.force)
    print(f"{output}: {len(rigged.names)} bones: {', '.join(rigged.names)}")
    return 0
