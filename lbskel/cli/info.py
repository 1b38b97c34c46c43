"""``lbskel info MESH``: measures of a mesh or a point cloud; ``lbskel info --system``: the installation."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from lbskel.cli.options import add_command
from lbskel.cli.terminal import tell
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import as_shape
from lbskel.pipeline.environment import system


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel info``."""
    parser = add_command(
        subparsers,
        "info",
        "print sizes, topology and measures of a mesh or a point cloud",
        details="Lengths, areas and volumes are in the units of the file.",
        example="lbskel info meshes/knot.off",
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("mesh", metavar="MESH", nargs="?")
    what.add_argument(
        "--system",
        action="store_true",
        help="print the versions of packages, whether the inner loops are compiled, and processors and threads",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the measures as text or JSON."""
    facts = system() if arguments.system else _facts(as_shape(arguments.mesh))
    width = max(len(name) for name in facts)
    shown = {name: _box(value) if name == "bounding_box" else _text(value) for name, value in facts.items()}
    lines = [f"{name.replace('_', ' '):{width}}  {value}" for name, value in shown.items()]
    tell(arguments, "\n".join(lines), facts)
    return 0


def _facts(shape: Mesh | PointCloud) -> dict[str, Any]:
    return _cloud_facts(shape) if isinstance(shape, PointCloud) else _mesh_facts(shape)


def _cloud_facts(cloud: PointCloud) -> dict[str, Any]:
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    distinct = np.unique(cloud.points, axis=0)
    nearest = cKDTree(distinct).query(distinct, k=min(2, len(distinct)))[0].reshape(len(distinct), -1)[:, -1]
    return {
        "points": len(cloud.points),
        "duplicates": len(cloud.points) - len(distinct),
        "bounding_box": [low.tolist(), high.tolist()],
        "diagonal": float(np.linalg.norm(high - low)),
        "mean_distance_of_neighbors": float(nearest.mean()),
    }


def _mesh_facts(mesh: Mesh) -> dict[str, Any]:
    used = mesh.vertices[mesh.used_vertices]
    low, high = used.min(axis=0), used.max(axis=0)
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    return {
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "components": mesh.n_components,
        "closed_manifold": mesh.is_closed_manifold,
        "genus": mesh.genus,
        "boundary_edges": int((mesh.faces_per_edge == 1).sum()),
        "nonmanifold_edges": int((mesh.faces_per_edge > 2).sum()),
        "unused_vertices": len(mesh.vertices) - len(mesh.used_vertices),
        "zero_area_faces": int((mesh.face_areas == 0).sum()),
        "bounding_box": [low.tolist(), high.tolist()],
        "diagonal": mesh.diagonal,
        "mean_edge": float(np.linalg.norm(end - start, axis=1).mean()),
        "area": mesh.area,
        "volume": mesh.volume if mesh.is_closed_manifold else None,
        "notes": list(mesh.notes),
    }


def _box(corners: list[list[float]]) -> str:
    """Format the lowest and the highest corner."""
    return " to ".join(", ".join(map(_text, corner)) for corner in corners)


def _text(value: Any) -> str:
    """Format a measure as text."""
    if value is None:
        return "not defined"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "; ".join(_text(item) for item in value) if value else "none"
    return f"{value:,}" if isinstance(value, int) else str(value)
