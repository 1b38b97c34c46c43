"""``lbskel preprocess MESH -o OUT``: a mesh cleaned, remeshed or simplified, or the surface of a point cloud."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_mesh_and_output,
    add_preprocess_option,
    refuse_existing,
)
from lbskel.cli.terminal import tell
from lbskel.geometry.mesh import PointCloud
from lbskel.io import MESH_WRITERS, as_shape
from lbskel.io.atomic_write import write_all_safely
from lbskel.io.text import known_extension
from lbskel.preprocess import (
    CLOUD_PREPARATIONS,
    PREPARATIONS,
    STEPS,
    Pipeline,
    PreprocessResult,
    preprocess_mesh,
    reconstruct_surface,
)


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel preprocess``."""
    parser = add_command(
        subparsers,
        "preprocess",
        "clean, remesh or simplify a mesh",
        details="lbskel skeletonize has the same option --preprocess and does this itself; here the mesh is written. "
        f"Steps: {', '.join(STEPS)}. Of a point cloud, the closed surface through its points is written; "
        f"--preprocess is then one of {', '.join(CLOUD_PREPARATIONS)}.",
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
    paths = [Path(path) for path in (arguments.output, arguments.map, arguments.report) if path]
    suffix = known_extension(arguments.output, MESH_WRITERS, "meshes")
    refuse_existing(paths, arguments.force)
    shape = as_shape(arguments.mesh)
    if isinstance(shape, PointCloud):
        result, size = reconstruct_surface(shape, preprocess=arguments.preprocess), f"{len(shape.points):,} points"
    else:
        how = arguments.preprocess if arguments.preprocess in PREPARATIONS else Pipeline.parse(arguments.preprocess)
        result, size = preprocess_mesh(shape, how), f"{len(shape.vertices):,} vertices, {len(shape.faces):,} faces"
    report = {"mesh": arguments.mesh, **result.report}
    contents: dict[Path, str | bytes] = {Path(arguments.output): MESH_WRITERS[suffix](result.mesh)}
    if arguments.map:
        contents[Path(arguments.map)] = _array(result)
    if arguments.report:
        contents[Path(arguments.report)] = json.dumps(report, indent=1) + "\n"
    write_all_safely(contents, arguments.force)
    notes = (*(() if isinstance(shape, PointCloud) else shape.notes), *result.notes)
    made = f"{arguments.output}: {len(result.mesh.vertices):,} vertices, {len(result.mesh.faces):,} faces"
    tell(arguments, "\n".join([f"{arguments.mesh}: {size}", *(f"  {note}" for note in notes), made]), report)
    return 0


def _array(result: PreprocessResult) -> bytes:
    """Encode the vertex map as an npy file."""
    data = io.BytesIO()
    np.save(data, result.vertex_map.indices, allow_pickle=False)
    return data.getvalue()
