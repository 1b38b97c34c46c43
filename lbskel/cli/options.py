"""Parts that commands share: how a command is added, files, the operator, and the options of a skeleton."""

from __future__ import annotations

__all__ = [
    "add_command",
    "add_force_option",
    "add_mesh_and_output",
    "add_operator_option",
    "add_preprocess_option",
    "add_skeleton_options",
    "add_swc_options",
    "add_tree_and_units",
    "read_mesh_to_write",
    "read_surface",
    "refuse_unwritable",
    "skeleton_options",
]

import argparse
import os
import textwrap
from collections.abc import Collection, Iterable
from pathlib import Path
from shlex import quote
from typing import Any

from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.settings import PRESETS
from lbskel.errors import FormatError, MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import MESH_WRITERS, as_shape
from lbskel.io.atomic_write import writable_target
from lbskel.operators import OPERATORS
from lbskel.pipeline.options import DOMAINS, JOIN, RADIUS_KINDS, TIP_POSITIONS
from lbskel.pipeline.preparation import SIMPLIFY
from lbskel.preprocess import PREPARATIONS
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.solvers import SOLVERS


def add_command(
    subparsers: Any, name: str, summary: str, *, example: str, details: str = "", json: str = "print the result as JSON"
) -> argparse.ArgumentParser:
    """Add the parser of a command, with a description and an example in its help, ``--quiet`` and ``--json``.

    ``json`` is the help of ``--json``.
    """
    description = f"{summary[0].upper()}{summary[1:]}.{' ' if details else ''}{details}"
    parser: argparse.ArgumentParser = subparsers.add_parser(
        name,
        help=summary,
        description=textwrap.fill(description, 100),
        epilog=f"example:\n  {example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.add_argument("--json", action="store_true", help=json)
    parser.set_defaults(on_stage=_ignore)  # told the stages of what takes long
    return parser


def _ignore(stage: str) -> None:
    """Show no stage."""


def add_mesh_and_output(parser: argparse.ArgumentParser) -> None:
    """Add the mesh that is read, and ``-o`` for the one that is written."""
    parser.add_argument("mesh", metavar="MESH")
    formats = f"mesh, positions and faces without colors and texture: {', '.join(MESH_WRITERS)}"
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help=formats)


def add_operator_option(
    parser: argparse.ArgumentParser, default: str, note: str = "'lbskel laplacian --help' lists them"
) -> None:
    """Add ``--operator``, a name in OPERATORS."""
    parser.add_argument(
        "--operator",
        default=default,
        choices=OPERATORS,
        metavar="NAME",
        help=f"discrete Laplacian; {note} (%(default)s)",
    )


def add_preprocess_option(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add ``--preprocess``: how a mesh is cleaned, remeshed or simplified."""
    parser.add_argument(
        "--preprocess",
        default="auto",
        metavar="HOW",
        help=f"{', '.join(PREPARATIONS)}; or steps, such as merge_close,remesh_isotropic:edge_length=0.011; or a .toml "
        "file with a table [[step]] for each step; none thins no point cloud (%(default)s)",
    )


def add_force_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--force``."""
    parser.add_argument("--force", action="store_true", help="replace files that exist")


def refuse_unwritable(
    files: Iterable[tuple[str | Path | None, Collection[str]]], force: bool, inputs: Iterable[str | Path | None] = ()
) -> None:
    """Raise FormatError if a file cannot be written, before anything is computed.

    That is, if its name has none of the extensions beside it, if it exists, if it is named twice or is one of the
    inputs, or as :func:`writable_target` does. None is no file.
    """
    seen: set[Path] = set()
    read = {os.path.realpath(path) for path in inputs if path}
    for path, extensions in [(Path(name), extensions) for name, extensions in files if name]:
        if path.suffix.lower().removeprefix(".") not in extensions and not path.is_dir():
            known = [f".{extension}" for extension in extensions]
            raise FormatError(f"{path}: the name must end in {'one of: ' if len(known) > 1 else ''}{', '.join(known)}")
        target = writable_target(path, force=True)
        if str(target) in read:
            raise FormatError(f"{path}: is an input, and would be lost; give the output another name")
        if target.exists() and not force:
            raise FormatError(f"{path} exists already; give --force to replace it")
        if target in seen:
            raise FormatError(f"{path}: is named for two outputs; give each a name of its own")
        seen.add(target)


def read_surface(path: str) -> Mesh:
    """Read a mesh; of a point cloud, raise MeshError with the command that makes a surface of it."""
    shape = as_shape(path)
    if isinstance(shape, PointCloud):
        raise MeshError(
            f"{path}: is a point cloud, and this command needs a mesh; lbskel preprocess {quote(path)} "
            f"-o {quote(f'{Path(path).stem}_surface.ply')} writes the surface through its points"
        )
    return shape


def read_mesh_to_write(arguments: argparse.Namespace) -> Mesh:
    """Read the mesh, if the one to be written can be."""
    refuse_unwritable([(arguments.output, MESH_WRITERS)], arguments.force)
    return read_surface(arguments.mesh)


def add_skeleton_options(
    parser: argparse.ArgumentParser, *, time_limit_help: str = "return the best result found within SECONDS"
) -> None:
    """Add the options of :func:`lbskel.skeletonize`, the same for one mesh and for many."""
    group = parser.add_argument_group("skeleton")
    group.add_argument(
        "--preset",
        default="curvature_flow",
        choices=[*PRESETS, *DOMAINS],
        metavar="NAME",
        help=f"settings of the contraction: {', '.join(PRESETS)} (%(default)s); or options for a kind of shape: "
        f"{', '.join(DOMAINS)}",
    )
    group.add_argument(
        "--operator",
        choices=OPERATORS,
        metavar="NAME",
        help="discrete Laplacian in place of the preset's; 'lbskel laplacian --help' lists them",
    )
    group.add_argument(
        "--energy",
        choices=ENERGIES,
        metavar="NAME",
        help=f"energy of each step in place of the preset's: {', '.join(ENERGIES)}",
    )
    group.add_argument(
        "--solver",
        choices=SOLVERS,
        metavar="NAME",
        help=f"linear solver in place of the preset's: {', '.join(SOLVERS)}",
    )
    group.add_argument(
        "--simplify",
        default="auto",
        choices=SIMPLIFY,
        metavar="HOW",
        help="auto contracts a simplified proxy of large meshes, none contracts every vertex (%(default)s)",
    )
    group.add_argument(
        "--min-branch-ratio",
        type=float,
        metavar="RADII",
        help=f"keep end branches that reach this many local radii from their junction ({MIN_BRANCH_RATIO})",
    )
    group.add_argument(
        "--tip-position",
        choices=TIP_POSITIONS,
        metavar="WHERE",
        help="end branches at the last inscribed ball (inside, the default) or on the surface (surface)",
    )
    group.add_argument(
        "--radius-kind",
        choices=RADIUS_KINDS,
        metavar="KIND",
        help="radii are distances to the surface (inscribed, the default) or those of tubes that fit it best (mean)",
    )
    group.add_argument("--nodes", dest="n_nodes", type=int, metavar="N", help="number of nodes of the skeleton")
    group.add_argument(
        "--root",
        type=_vertex_or_point,
        metavar="PLACE",
        help="first node, the root in swc, is the nearest to this: the index of a vertex, or a point as X,Y,Z in the "
        "units of the mesh; its type in swc is 1 only if it is in the soma by the radii too",
    )
    group.add_argument(
        "--anchor",
        type=_vertex_or_point,
        action="append",
        default=[],
        metavar="PLACE",
        help="have a node at a vertex or a point; may be repeated",
    )
    add_preprocess_option(group)
    group.add_argument(
        "--join",
        nargs="?",
        const="all",
        choices=JOIN,
        metavar="WHICH",
        help="join to one graph the pieces of open surfaces (pieces, the default), all components (all), or none",
    )
    group.add_argument(
        "--min-loop", type=float, metavar="RADII", help="open loops shorter than this many local radii (0)"
    )
    group.add_argument("--time-limit", type=float, metavar="SECONDS", help=time_limit_help)


def add_swc_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of what is written: a tree, and the scale and units of swc."""
    add_tree_and_units(parser, "the positions and radii in swc", "in swc")


def add_tree_and_units(parser: argparse.ArgumentParser, lengths: str, where: str) -> None:
    """Add ``--tree``, and ``--scale`` and ``--units`` of the lengths in an output, which are named for the help."""
    parser.add_argument("--tree", action="store_true", help="cut each cycle where it is thinnest")
    parser.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help=f"multiply {lengths}, such as 0.001 from nanometers to micrometers (%(default)s)",
    )
    parser.add_argument("--units", metavar="NAME", help=f"name of the units {where}, such as um")


def skeleton_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the options as keyword arguments of :func:`lbskel.skeletonize`, without the limits on time and memory."""
    return {
        "preset": arguments.preset,
        "operator": arguments.operator,
        "energy": arguments.energy,
        "solver": arguments.solver,
        "simplify": arguments.simplify,
        "min_branch_ratio": arguments.min_branch_ratio,
        "tip_position": arguments.tip_position,
        "join": arguments.join,
        "min_loop": arguments.min_loop,
        "radius_kind": arguments.radius_kind,
        "n_nodes": arguments.n_nodes,
        "root": arguments.root,
        "anchors": arguments.anchor,
        "preprocess": arguments.preprocess,
    }


def _vertex_or_point(text: str) -> int | list[float]:
    """Parse the index of a vertex, or a point."""
    try:
        point = [float(part) for part in text.split(",")] if "," in text else int(text)
    except ValueError:
        point = []
    if isinstance(point, list) and len(point) != 3:
        raise argparse.ArgumentTypeError(f"must be the index of a vertex or a point as X,Y,Z, not {text!r}")
    return point
