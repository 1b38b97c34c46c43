"""``lbskel smooth MESH -o OUT``: a mesh smoothed by a Laplacian, and how far its vertices, area and volume moved."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

import numpy as np

from lbskel.applications import SMOOTHING_METHODS, smooth
from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_mesh_and_output,
    add_operator_option,
    read_mesh_to_write,
)
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.io import write_mesh


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel smooth``."""
    parser = add_command(
        subparsers,
        "smooth",
        "smooth a mesh by a discrete Laplacian",
        details="The vertices keep their order.",
        example="lbskel smooth scan.ply -o smooth.ply --keep-volume",
    )
    add_mesh_and_output(parser)
    parser.add_argument(
        "--method",
        default="bilaplacian",
        choices=SMOOTHING_METHODS,
        metavar="NAME",
        help=f"{', '.join(SMOOTHING_METHODS)} (%(default)s)",
    )
    parser.add_argument(
        "--time-step", type=float, metavar="AREA", help="of each iteration, in squared units of the mesh"
    )
    parser.add_argument("--iterations", type=int, metavar="N", help="number of time steps")
    add_operator_option(parser, "cotangent")
    parser.add_argument("--keep-volume", action="store_true", help="keep the volume of each component")
    parser.add_argument("--free-boundary", action="store_true", help="move vertices on the boundary too")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Smooth, write and print what has changed."""
    mesh = read_mesh_to_write(arguments)
    result = smooth(
        mesh,
        method=arguments.method,
        time_step=arguments.time_step,
        iterations=arguments.iterations,
        operator=arguments.operator,
        fix_boundary=not arguments.free_boundary,
        keep_volume=arguments.keep_volume,
    )
    write_mesh(arguments.output, result, force=arguments.force)
    changes = _changes(mesh, result)
    text = (
        f"{arguments.mesh}: {counted(len(mesh.vertices), 'vertex')}, {counted(len(mesh.faces), 'face')}\n"
        f"{arguments.output}: {counted(int(changes['n_moved']), 'vertex')} moved by "
        f"{changes['mean_displacement']:.3g} edge lengths on average, {changes['max_displacement']:.3g} at most"
    )
    text += f"; area {100 * changes['area_change']:+.3g} %" if "area_change" in changes else ""
    text += f", volume {100 * changes['volume_change']:+.3g} %" if "volume_change" in changes else ""
    tell(arguments, text, {"output": arguments.output, **changes})
    return 0


def _changes(mesh: Mesh, result: Mesh) -> dict[str, float]:
    """Measure how far vertices moved, in mean edge lengths, and by how much the area and the volume changed."""
    scaled, exponent = unit_scale(mesh.vertices)  # areas of tiny meshes vanish
    mesh, result = mesh.with_vertices(scaled), result.with_vertices(np.ldexp(result.vertices, -exponent))
    moved = np.linalg.norm(result.vertices - mesh.vertices, axis=1)
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    edge = float(np.linalg.norm(end - start, axis=1).mean()) or 1.0  # edges of no length: nothing moves
    changes = {
        "n_moved": int(np.count_nonzero(moved)),
        "mean_displacement": float(moved.mean()) / edge,
        "max_displacement": float(moved.max()) / edge,
    }
    if mesh.area > 0:
        changes["area_change"] = result.area / mesh.area - 1
    if mesh.is_closed_manifold and mesh.volume != 0:
        changes["volume_change"] = result.volume / mesh.volume - 1
    return changes
