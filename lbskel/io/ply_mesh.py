"""Meshes and skeletons as PLY.

A mesh has the elements ``vertex`` (x, y, z) and ``face`` (the list vertex_indices). A skeleton has ``vertex`` (x, y,
z, radius), ``edge`` (vertex1, vertex2) and ``mesh_vertex`` (node: the node that stands for each vertex of the mesh).
"""

from __future__ import annotations

__all__ = ["mesh_ply", "read_ply", "read_ply_skeleton", "skeleton_ply"]

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.atomic_write import rows_text
from lbskel.io.ply import Element, Lists, parse_ply, ply_header
from lbskel.io.polygon_soup import Polygons
from lbskel.io.text import as_integers, read_bytes
from lbskel.skeleton.skeleton import Skeleton

RADIUS_KIND = "radius_kind "


def read_ply(path: Path) -> Polygons:
    """The vertices and polygons of a PLY file."""
    elements = parse_ply(read_bytes(path)).elements
    points, face = _points(elements.get("vertex", {})), elements.get("face", {})
    for name in ("vertex_indices", "vertex_index"):
        if isinstance(corners := face.get(name), Lists):
            values, sizes = (as_integers(part.astype(np.float64), "vertex indices") for part in corners)
            return Polygons(points, values, sizes)
    if "tristrips" in elements:
        raise FormatError("holds triangle strips, which are not read; save it with faces")
    return Polygons(points)


def _columns(element: Element, names: tuple[str, ...]) -> NDArray[np.float64]:
    """Some properties of an element side by side."""
    columns = [element.get(name) for name in names]
    if any(not isinstance(column, np.ndarray) for column in columns):
        raise FormatError(f"lacks an element with the properties {', '.join(names)}")
    return np.stack([np.asarray(column, dtype=np.float64) for column in columns], axis=1)


def _points(vertex: Element) -> NDArray[np.float64]:
    """The (n, 3) positions."""
    return _columns(vertex, ("x", "y", "z"))


def mesh_ply(mesh: Mesh) -> bytes:
    """A mesh as binary PLY, in double precision."""
    vertex = (len(mesh.vertices), ["double x", "double y", "double z"])
    face = (len(mesh.faces), ["list uchar int vertex_indices"])
    rows = np.empty(len(mesh.faces), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    rows["size"], rows["corners"] = 3, mesh.faces
    header = ply_header("binary_little_endian", [], {"vertex": vertex, "face": face})
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + rows.tobytes()


def read_ply_skeleton(path: Path) -> Skeleton:
    """The skeleton in a PLY file; radii that it lacks are NaN."""
    file = parse_ply(read_bytes(path))
    vertex, edge, mapped = (file.elements.get(name, {}) for name in ("vertex", "edge", "mesh_vertex"))
    nodes = _points(vertex)
    if "face" in file.elements and "edge" not in file.elements:
        raise FormatError("holds faces and no edges: it is a mesh and no skeleton")
    radii = _columns(vertex, ("radius",))[:, 0] if "radius" in vertex else np.full(len(nodes), np.nan)
    node_of_vertex = _columns(mapped, ("node",))[:, 0] if mapped else np.empty(0)
    kinds = [comment.removeprefix(RADIUS_KIND) for comment in file.comments if comment.startswith(RADIUS_KIND)]
    return Skeleton(
        nodes,
        as_integers(_columns(edge, ("vertex1", "vertex2")), "edges") if edge else np.empty((0, 2), dtype=np.int64),
        radii,
        as_integers(node_of_vertex, "node_of_vertex"),
        next(iter(kinds), Skeleton.radius_kind),
    )


def skeleton_ply(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """A skeleton as text PLY, in double precision."""
    elements = {
        "vertex": (len(skeleton.nodes), ["double x", "double y", "double z", "double radius"]),
        "edge": (len(skeleton.edges), ["int vertex1", "int vertex2"]),
        "mesh_vertex": (len(skeleton.node_of_vertex), ["int node"]),
    }
    text = ply_header("ascii", [RADIUS_KIND + " ".join(skeleton.radius_kind.split())], elements)
    text += rows_text("", np.column_stack([skeleton.nodes, skeleton.radii]))
    return {path: text + rows_text("", skeleton.edges) + rows_text("", skeleton.node_of_vertex[:, None])}
