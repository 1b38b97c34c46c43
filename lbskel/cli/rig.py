"""``lbskel rig MESH -o OUT.glb``: a mesh with bones and weights, as binary glTF."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.applications import rig
from lbskel.applications.rigging import MAX_BONES, MAX_INFLUENCES
from lbskel.cli.html_option import add_html_option, refuse_page, write_page
from lbskel.cli.mesh_and_skeleton import add_input, mesh_and_skeleton
from lbskel.cli.options import add_command, add_force_option, refuse_unwritable
from lbskel.cli.terminal import tell
from lbskel.errors import FormatError, counted, first_few
from lbskel.io.gltf_skin import UP_AXES, write_rig
from lbskel.io.obj import read_obj_texture
from lbskel.skeleton.armature import Rig
from lbskel.visualization import Table


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel rig``."""
    parser = add_command(
        subparsers,
        "rig",
        "make bones and weights for animation, as glTF",
        details="The GLB has the texture coordinates of an obj, and no images or materials.",
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
    add_html_option(parser)
    add_force_option(parser)
    add_input(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Rig and write."""
    output = Path(arguments.output)
    refuse_unwritable([(output, ("glb",))], arguments.force, [arguments.mesh])
    refuse_page(arguments.html, arguments.force)
    mesh, skeleton = mesh_and_skeleton(arguments)
    rigged = rig(mesh, skeleton, max_bones=arguments.max_bones, max_influences=arguments.max_influences)
    if len(roots := [rigged.names[bone] for bone in np.flatnonzero(rigged.parents < 0).tolist()]) > 1:
        print(
            f"lbskel: warning: the skeleton has {len(roots)} components, and {first_few(roots[1:])} hangs on no bone: "
            f"what follows it stays where it is when {roots[0]} moves; --join all makes one skeleton",
            file=sys.stderr,
        )
    texture, notes = None, list(rigged.notes)
    if Path(arguments.mesh).suffix.lower() == ".obj":
        try:
            texture = read_obj_texture(Path(arguments.mesh), mesh)
        except FormatError as error:
            notes.append(f"no texture coordinates were written: {error}")
    write_rig(output, rigged, up=arguments.up, texture=texture, force=arguments.force)
    if arguments.html:
        bone_of_face = rigged.weights[mesh.faces].sum(axis=1).argmax(axis=1)
        shown = {"part_of_face": bone_of_face, "parts_name": "parts by strongest bone", "parts_first": True}
        title = Path(arguments.mesh).name
        write_page(arguments.html, mesh, skeleton, arguments, title=title, tables=[_table(rigged)], **shown)
    bones = f"{output}: {counted(len(rigged.names), 'bone')}: {', '.join(rigged.names)}"
    facts = {"output": str(output), "bones": list(rigged.names), "parents": rigged.parents.tolist()}
    facts["notes"] = notes
    tell(arguments, "\n".join([bones, *(f"  note      {note}" for note in notes)]), facts)
    return 0


def _table(rigged: Rig) -> Table:
    lengths = np.linalg.norm(rigged.tails - rigged.heads, axis=1).tolist()
    parents = [rigged.names[parent] if parent >= 0 else None for parent in rigged.parents.tolist()]
    return Table("Bones", ["bone", "hangs on", "length"], list(zip(rigged.names, parents, lengths, strict=True)))
