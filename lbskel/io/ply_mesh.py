"""Meshes and skeletons as PLY.

A mesh has the elements ``vertex`` (x, y, z) and ``face`` (the list vertex_indices). A skeleton has ``vertex`` (x, y,
z, radius), ``edge`` (vertex1, vertex2) and ``mesh_vertex`` (node: the node to which each mesh vertex is mapped).
"""

from __future__ import annotations

__all__ = ["encode_ply", "encode_ply_cloud", "encode_ply_skeleton", "read_ply", "read_ply_skeleton"]

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io.ply import Element, Lists, encode_ply_header, parse_ply
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import as_integers, format_rows, read_bytes
from lbskel.skeleton.skeleton import Skeleton

RADIUS_KIND = "radius_kind "


def read_ply(path: Path) -> PolygonSoup:
    """Read the vertices and polygons of a PLY file."""
    elements = parse_ply(read_bytes(path)).elements
    points, face = _points(elements.get("vertex", {})), elements.get("face", {})
    for name in ("vertex_indices", "vertex_index"):
        if isinstance(corners := face.get(name), Lists):
            values, sizes = (as_integers(part.astype(np.float64), "vertex indices") for part in corners)
            return PolygonSoup(points, values, sizes)
    if "tristrips" in elements:
        raise FormatError("has triangle strips, which are not supported; save it with faces")
    if lists := [name for name, values in face.items() if isinstance(values, Lists) and len(values.sizes)]:
        raise FormatError(f"its faces have no list vertex_indices but {', '.join(lists)}; rename the list of corners")
    return PolygonSoup(points)


def _columns(element: Element, names: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the named properties of an element as the columns of an (n, len(names)) array."""
    columns = [element.get(name) for name in names]
    if any(not isinstance(column, np.ndarray) for column in columns):
        raise FormatError(f"lacks an element with the properties {', '.join(names)}")
    return np.stack([np.asarray(column, dtype=np.float64) for column in columns], axis=1)


def _points(vertex: Element) -> NDArray[np.float64]:
    """Return the (n, 3) vertex positions."""
    return _columns(vertex, ("x", "y", "z"))


def encode_ply(mesh: Mesh) -> bytes:
    """Encode a mesh as binary PLY in double precision."""
    vertex = (len(mesh.vertices), ["double x", "double y", "double z"])
    face = (len(mesh.faces), ["list uchar int vertex_indices"])
    rows = np.empty(len(mesh.faces), dtype=[("size", "u1"), ("corners", "<i4", 3)])
    rows["size"], rows["corners"] = 3, mesh.faces
    header = encode_ply_header("binary_little_endian", [], {"vertex": vertex, "face": face})
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + rows.tobytes()


def encode_ply_cloud(cloud: PointCloud) -> bytes:
    """Encode a point cloud as binary PLY in double precision."""
    vertex = (len(cloud.points), ["double x", "double y", "double z"])
    header = encode_ply_header("binary_little_endian", [], {"vertex": vertex})
    return header.encode() + cloud.points.astype("<f8").tobytes()


def read_ply_skeleton(path: Path) -> Skeleton:
    """Read a skeleton from PLY; missing radii become NaN."""
    file = parse_ply(read_bytes(path))
    vertex, edge, mapped = (file.elements.get(name, {}) for name in ("vertex", "edge", "mesh_vertex"))
    nodes = _points(vertex)
    if "face" in file.elements and "edge" not in file.elements:
        raise FormatError("has faces and no edges: it is a mesh, not a skeleton")
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


def encode_ply_skeleton(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """Encode a skeleton as text PLY in double precision."""
    elements = {
        "vertex": (len(skeleton.nodes), ["double x", "double y", "double z", "double radius"]),
        "edge": (len(skeleton.edges), ["int vertex1", "int vertex2"]),
        "mesh_vertex": (len(skeleton.node_of_vertex), ["int node"]),
    }
    text = encode_ply_header("ascii", [RADIUS_KIND + " ".join(skeleton.radius_kind.split())], elements)
    text += format_rows("", np.column_stack([skeleton.nodes, skeleton.radii]))
    return {path: text + format_rows("", skeleton.edges) + format_rows("", skeleton.node_of_vertex[:, None])}
