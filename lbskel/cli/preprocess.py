"""``lbskel preprocess MESH -o OUT``: a mesh cleaned or simplified; a surface through a point cloud, or fewer points."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from pathlib import Path
from typing import Any

from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_mesh_and_output,
    add_preprocess_option,
    refuse_unwritable,
)
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import MESH_WRITERS, POINT_WRITERS, as_shape
from lbskel.io.atomic_write import write_all_safely
from lbskel.io.npy import encode_npy
from lbskel.io.text import prefix_errors
from lbskel.preprocess import (
    CLOUD_PREPARATIONS,
    STEPS,
    PreprocessResult,
    preprocess_mesh,
    reconstruct_surface,
)
from lbskel.preprocess.downsampling import DOWNSAMPLINGS, downsample_as
from lbskel.preprocess.point_cleaning import CleanedPoints


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel preprocess``."""
    parser = add_command(
        subparsers,
        "preprocess",
        "clean, remesh or simplify a mesh",
        details="lbskel skeletonize has the same option --preprocess and does this itself; here the mesh is written. "
        f"Steps: {', '.join(STEPS)}. Of a point cloud, the closed surface through its points is written; "
        f"--preprocess is then one of {', '.join(CLOUD_PREPARATIONS)}. "
        f"voxel:cell=LENGTH or farthest:points=NUMBER write a thinner cloud ({', '.join(POINT_WRITERS)}).",
        example="lbskel preprocess scan.stl -o clean.ply --preprocess scan --map map.npy",
    )
    add_mesh_and_output(parser)
    add_preprocess_option(parser)
    for name in ("--pipeline", "--steps"):  # of the same option in 0.1.0
        parser.add_argument(name, dest="preprocess", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
    parser.add_argument(
        "--map", metavar="NPY", help="write the new index of each vertex, -1 for none, as a numpy array"
    )
    parser.add_argument("--report", metavar="JSON", help="write the report of each step")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the pipeline and write the mesh, and the map and the report where they are asked for."""
    is_thinned = arguments.preprocess.partition(":")[0] in DOWNSAMPLINGS
    writers: dict[str, Any] = POINT_WRITERS if is_thinned else MESH_WRITERS
    files = (arguments.output, writers), (arguments.map, ("npy",)), (arguments.report, ("json",))
    refuse_unwritable(files, arguments.force)
    refuse_unwritable(files[1:], arguments.force, [arguments.mesh])  # the mesh itself may be replaced by the new one
    shape = as_shape(arguments.mesh)
    result: PreprocessResult | CleanedPoints
    if is_thinned:
        result = downsample_as(
            shape if isinstance(shape, PointCloud) else PointCloud(shape.vertices), arguments.preprocess
        )
    elif isinstance(shape, PointCloud):
        result = reconstruct_surface(shape, preprocess=arguments.preprocess)
    else:
        result = preprocess_mesh(shape, arguments.preprocess)
    report = {"mesh": arguments.mesh, **result.report}
    written = PointCloud(result.points) if isinstance(result, CleanedPoints) else result.mesh
    output = Path(arguments.output)
    with prefix_errors(output):
        contents: dict[Path, str | bytes] = {output: writers[output.suffix.lower().removeprefix(".")](written)}
    if arguments.map:
        contents[Path(arguments.map)] = encode_npy(result.vertex_map.indices)
    if arguments.report:
        contents[Path(arguments.report)] = json.dumps(report, indent=1) + "\n"
    write_all_safely(contents, arguments.force)
    notes = (*(() if isinstance(shape, PointCloud) else shape.notes), *result.notes)
    made = f"{arguments.output}: {_size(written)}"
    tell(arguments, "\n".join([f"{arguments.mesh}: {_size(shape)}", *(f"  {note}" for note in notes), made]), report)
    return 0


def _size(shape: Mesh | PointCloud) -> str:
    """Count the vertices and faces, or the points."""
    if isinstance(shape, PointCloud):
        return counted(len(shape.points), "point")
    return f"{counted(len(shape.vertices), 'vertex')}, {counted(len(shape.faces), 'face')}"
