"""VTP, the polygonal data of VTK as XML, which ParaView and the Vascular Modeling Toolkit read.

One polyline per branch, one vertex cell per isolated node. The point data are ``radius`` and, for the Vascular Modeling
Toolkit, inscribed radii as ``MaximumInscribedSphereRadius`` too; the field data are ``node_of_vertex`` and
``radius_kind``.
"""

from __future__ import annotations

__all__ = ["encode_vtp", "read_vtp"]

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.text import as_integers, read_bytes
from lbskel.io.vtk_xml import VtkFile, encode_array, find_array, parse_vtk
from lbskel.skeleton.skeleton import Skeleton

RADIUS_NAMES = ("radius", "MaximumInscribedSphereRadius")


def encode_vtp(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """Encode a skeleton as VTP."""
    isolated = np.flatnonzero(skeleton.degrees == 0)
    branches = skeleton.branches
    kind = np.frombuffer(skeleton.radius_kind.encode() + b"\0", dtype=np.uint8)
    field = encode_array("node_of_vertex", skeleton.node_of_vertex) + encode_array("radius_kind", kind)
    names = RADIUS_NAMES if skeleton.radius_kind == "inscribed" else RADIUS_NAMES[:1]
    radii = "".join(encode_array(name, skeleton.radii) for name in names)
    counts = f'NumberOfPoints="{len(skeleton.nodes)}" NumberOfVerts="{len(isolated)}" NumberOfLines="{len(branches)}"'
    text = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
        f"<FieldData>\n{field}</FieldData>\n"
        f"<Piece {counts}>\n"
        f"<PointData>\n{radii}</PointData>\n"
        f"<Points>\n{encode_array('Points', skeleton.nodes, 3)}</Points>\n"
        f"{_encode_cells('Verts', isolated[:, None])}{_encode_cells('Lines', branches)}"
        "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    return {path: text}


def _encode_cells(name: str, cells: Sequence[NDArray[np.int64]] | NDArray[np.int64]) -> str:
    """Encode the cells of one type: their point indices, concatenated, and the end of each cell in these."""
    points = np.concatenate([*cells, np.empty(0, dtype=np.int64)])
    ends = np.cumsum([len(cell) for cell in cells], dtype=np.int64)
    return f"<{name}>\n{encode_array('connectivity', points)}{encode_array('offsets', ends)}</{name}>\n"


def read_vtp(path: Path) -> Skeleton:
    """Read the polylines of a VTP file as a skeleton; missing radii become NaN."""
    file = parse_vtk(read_bytes(path))
    pieces = file.root.findall("PolyData/Piece")
    if not pieces:
        raise FormatError("not a VTP file: no PolyData with a Piece")
    nodes: list[NDArray[np.float64]] = []
    edges: list[NDArray[np.int64]] = []
    radii: list[NDArray[np.float64]] = []
    first = 0
    for piece in pieces:
        points = find_array(file, piece.find("Points"), None)
        if points is None or points.size % 3:
            raise FormatError("the points do not have three coordinates each")
        n = points.size // 3
        point_data = [find_array(file, piece.find("PointData"), name) for name in RADIUS_NAMES]
        radii.append(next((values for values in point_data if values is not None), np.full(n, np.nan)))
        edges.append(_read_edges(file, piece.find("Lines"), n) + first)
        nodes.append(points.reshape(-1, 3))
        first += n
    field = file.root.find("PolyData/FieldData")
    mapped, kind = find_array(file, field, "node_of_vertex"), find_array(file, field, "radius_kind")
    return Skeleton(
        np.concatenate(nodes),
        np.concatenate(edges),
        np.concatenate(radii),
        as_integers(mapped, "node_of_vertex") if mapped is not None else np.empty(0, dtype=np.int64),
        bytes(kind.astype(np.uint8)).rstrip(b"\0").decode() if kind is not None else Skeleton.radius_kind,
    )


def _read_edges(file: VtkFile, lines: Element | None, n: int) -> NDArray[np.int64]:
    """Read the (e, 2) pairs of consecutive points of the polylines; n is the number of points."""
    connectivity, offsets = find_array(file, lines, "connectivity"), find_array(file, lines, "offsets")
    if connectivity is None or offsets is None:
        return np.empty((0, 2), dtype=np.int64)
    points, ends = as_integers(connectivity, "connectivity of lines"), as_integers(offsets, "offsets of lines")
    if points.size and (points.min() < 0 or points.max() >= n):
        raise FormatError(f"a line uses a point outside 0..{n - 1}")
    if (np.diff(ends, prepend=0) < 0).any() or (ends[-1] if len(ends) else 0) != len(points):
        raise FormatError("the offsets of the lines do not match their connectivity")
    is_edge = np.ones(max(len(points) - 1, 0), dtype=bool)
    is_edge[ends[(ends > 0) & (ends < len(points))] - 1] = False
    return np.stack([points[:-1], points[1:]], axis=1)[is_edge]
