"""``lbskel quantize MESH -o OUT``: a mesh from rounded differential coordinates, and its rate and error."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

import numpy as np

from lbskel.applications import quantize_deltas
from lbskel.applications.quantization import round_to_bits
from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_mesh_and_output,
    add_operator_option,
    read_mesh_to_write,
)
from lbskel.cli.terminal import tell
from lbskel.errors import MeshError, counted
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.io import write_mesh

TEXT = "error {relative_error:.2g} of the diagonal, normals off by {normals_error_deg:.2g} degrees"


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel quantize``."""
    parser = add_command(
        subparsers,
        "quantize",
        "round the differential coordinates of a mesh and reconstruct it",
        details="The error is compared with that of positions rounded to as many bits.",
        example="lbskel quantize meshes/hand.ply -o rounded.ply --bits 7 --anchors 20",
    )
    add_mesh_and_output(parser)
    parser.add_argument("--bits", type=int, default=8, metavar="N", help="of each coordinate (%(default)s)")
    parser.add_argument(
        "--anchors",
        dest="n_anchors",
        type=int,
        default=20,
        metavar="N",
        help="vertices stored with their positions (%(default)s)",
    )
    add_operator_option(parser, "graph", note="only graph follows from the connectivity")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Round, reconstruct, write and print the rate and the errors."""
    mesh = read_mesh_to_write(arguments)
    scaled, exponent = unit_scale(mesh.vertices)  # areas of tiny meshes vanish
    unit = mesh.with_vertices(scaled)
    if not unit.area > 0:
        raise MeshError(f"{arguments.mesh}: the mesh has no area: every face is degenerate, so normals have no error")
    result = quantize_deltas(mesh, bits=arguments.bits, n_anchors=arguments.n_anchors, operator=arguments.operator)
    write_mesh(arguments.output, result.mesh, force=arguments.force)
    errors = _errors(unit.with_vertices(np.ldexp(result.mesh.vertices, -exponent)), unit)
    rounded = _errors(unit.with_vertices(round_to_bits(scaled, arguments.bits)[1]), unit)
    text = (
        f"{arguments.mesh}: {counted(len(mesh.vertices), 'vertex')}, {counted(len(mesh.faces), 'face')}\n"
        f"{arguments.output}: {result.bits_per_vertex:.3g} bits per vertex, {counted(len(result.anchors), 'anchor')}, "
        f"{TEXT.format(**errors)}\n"
        f"positions of {counted(arguments.bits, 'bit')}: {TEXT.format(**rounded)}"
    )
    facts = {
        "output": arguments.output,
        "bits_per_vertex": result.bits_per_vertex,
        "n_anchors": len(result.anchors),
        **errors,
        "rounded_positions": rounded,
    }
    tell(arguments, text, facts)
    return 0


def _errors(mesh: Mesh, given: Mesh) -> dict[str, float]:
    """Measure the root mean square error of the positions, and the mean one of the normals."""
    error = np.sqrt(((mesh.vertices - given.vertices) ** 2).sum(axis=1).mean()) / given.diagonal
    cosines = np.einsum("mx,mx->m", mesh.face_normals, given.face_normals)
    angle = np.degrees(np.arccos(cosines[given.face_areas > 0].clip(-1, 1)).mean())
    return {"relative_error": float(error), "normals_error_deg": float(angle)}
