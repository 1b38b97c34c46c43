"""``lbskel edit MESH -o OUT``: a mesh with one region held and another moved rigidly, and how rigid the rest stays."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.applications import EDITING_METHODS, Editor, rigid_motion
from lbskel.applications.deformation_methods import ITERATIVE
from lbskel.applications.editing import ITERATIONS
from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_mesh_and_output,
    add_operator_option,
    read_mesh_to_write,
)
from lbskel.cli.terminal import tell
from lbskel.errors import MeshError, UnknownChoice, counted
from lbskel.geometry.mesh import Mesh
from lbskel.io import write_mesh


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel edit``."""
    parser = add_command(
        subparsers,
        "edit",
        "move a region of a mesh, and the rest of the surface with it",
        details="A region AXIS:LOW:HIGH holds the vertices between two fractions of the bounding box, such as z:0.9:1.",
        example="lbskel edit meshes/dinosaur.ply -o out.ply --fix z:0:0.3 --move z:0.9:1 --axis 0,0,1 --angle 40",
    )
    add_mesh_and_output(parser)
    parser.add_argument(
        "--fix", type=_region, action="append", default=[], metavar="REGION", help="vertices that stay; may be repeated"
    )
    parser.add_argument("--move", type=_region, required=True, metavar="REGION", help="vertices that are moved")
    parser.add_argument("--angle", type=float, default=0.0, metavar="DEGREES", help="of the rotation (%(default)s)")
    parser.add_argument(
        "--axis", type=_vector, default=(0.0, 0.0, 1.0), metavar="X,Y,Z", help="of the rotation (0,0,1)"
    )
    parser.add_argument(
        "--center", type=_vector, metavar="X,Y,Z", help="of the rotation, in units of the mesh (the region's mean)"
    )
    parser.add_argument(
        "--translate", type=_vector, default=(0.0, 0.0, 0.0), metavar="X,Y,Z", help="in units of the mesh (0,0,0)"
    )
    parser.add_argument(
        "--method",
        default="arap",
        choices=EDITING_METHODS,
        metavar="NAME",
        help=f"{', '.join(EDITING_METHODS)} (%(default)s)",
    )
    parser.add_argument("--iterations", type=int, metavar="N", help=f"of {' and '.join(ITERATIVE)} ({ITERATIONS})")
    add_operator_option(parser, "robust")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Edit, write and print the sizes of the regions and the change of lengths."""
    mesh = read_mesh_to_write(arguments)
    moved = _vertices(mesh, arguments.move)
    fixed = np.unique(np.concatenate([np.empty(0, np.int64), *(_vertices(mesh, r) for r in arguments.fix)]))
    if len(both := np.intersect1d(fixed, moved)):
        raise MeshError(f"{counted(len(both), 'vertex')} in a region of --fix and in that of --move, such as {both[0]}")
    center = mesh.vertices[moved].mean(axis=0) if arguments.center is None else arguments.center
    try:
        motion = rigid_motion(
            axis=arguments.axis, angle_deg=arguments.angle, center=center, translation=arguments.translate
        )
    except MeshError as error:  # of the options: the mesh has no part in it
        raise UnknownChoice(str(error)) from None
    editor = Editor(mesh, [fixed, moved], method=arguments.method, operator=arguments.operator)
    result = editor.edit([np.eye(4), motion], iterations=arguments.iterations)
    write_mesh(arguments.output, result, force=arguments.force)
    before, after = (each.edge_lengths for each in (mesh, result))
    change = np.abs(np.divide(after, before, out=np.ones_like(after), where=before > 0) - 1)
    text = (
        f"{arguments.mesh}: {counted(len(mesh.vertices), 'vertex')}, {counted(len(mesh.faces), 'face')}\n"
        f"{arguments.output}: {counted(len(fixed), 'vertex')} fixed, {len(moved):,} moved; edge lengths changed by "
        f"{100 * change.mean():.3g} % on average, {100 * change.max():.3g} % at most"
    )
    facts = {
        "output": arguments.output,
        "n_fixed": len(fixed),
        "n_moved": len(moved),
        "mean_length_change": float(change.mean()),
        "max_length_change": float(change.max()),
    }
    tell(arguments, text, facts)
    return 0


def _region(text: str) -> tuple[int, float, float]:
    """Parse a region: the axis, and two fractions of the bounding box."""
    try:
        axis, low, high = text.split(":")
        return ("x", "y", "z").index(axis), float(low), float(high)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be AXIS:LOW:HIGH, such as z:0.9:1, not {text!r}") from None


def _vector(text: str) -> tuple[float, ...]:
    """Parse three finite numbers."""
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        x = y = z = np.nan
    if not np.isfinite([x, y, z]).all():
        raise argparse.ArgumentTypeError(f"must be X,Y,Z, three finite numbers, not {text!r}")
    return x, y, z


def _vertices(mesh: Mesh, region: tuple[int, float, float]) -> NDArray[np.int64]:
    """Return the vertices in a region, of those that faces use."""
    axis, low, high = region
    values = mesh.vertices[mesh.used_vertices, axis]
    height = np.ptp(values)
    share = (values - values.min()) / (height if height > 0 else 1.0)
    chosen: NDArray[np.int64] = mesh.used_vertices[(share >= low) & (share <= high)]
    if not len(chosen):
        raise MeshError(f"there is no vertex in the region {'xyz'[axis]}:{low:g}:{high:g}")
    return chosen
