"""VTP, the polygonal data of VTK as XML, which ParaView and the Vascular Modeling Toolkit read.

One polyline per branch, a vertex per node without an edge; on the points ``radius`` and, for vascular work, the same
as ``MaximumInscribedSphereRadius``; ``node_of_vertex`` and ``radius_kind`` in the field data.
"""

from __future__ import annotations

__all__ = ["read_vtp", "skeleton_vtp"]

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.text import as_integers, read_bytes
from lbskel.io.vtk_xml import VtkFile, data_array, parse_vtk
from lbskel.skeleton.skeleton import Skeleton

RADIUS_NAMES = ("radius", "MaximumInscribedSphereRadius")


def skeleton_vtp(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """A skeleton as VTP."""
    single = np.flatnonzero(skeleton.degrees == 0)
    branches = skeleton.branches
    kind = np.frombuffer(skeleton.radius_kind.encode() + b"\0", dtype=np.uint8)
    field = data_array("node_of_vertex", skeleton.node_of_vertex) + data_array("radius_kind", kind)
    radii = "".join(data_array(name, skeleton.radii) for name in RADIUS_NAMES)
    counts = f'NumberOfPoints="{len(skeleton.nodes)}" NumberOfVerts="{len(single)}" NumberOfLines="{len(branches)}"'
    text = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
        f"<FieldData>\n{field}</FieldData>\n"
        f"<Piece {counts}>\n"
        f"<PointData>\n{radii}</PointData>\n"
        f"<Points>\n{data_array('Points', skeleton.nodes, 3)}</Points>\n"
        f"{_cells('Verts', single[:, None])}{_cells('Lines', branches)}"
        "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    return {path: text}


def _cells(name: str, cells: Sequence[NDArray[np.int64]] | NDArray[np.int64]) -> str:
    """The cells of one sort: their points one after the other, and where each ends."""
    points = np.concatenate([*cells, np.empty(0, dtype=np.int64)])
    ends = np.cumsum([len(cell) for cell in cells], dtype=np.int64)
    return f"<{name}>\n{data_array('connectivity', points)}{data_array('offsets', ends)}</{name}>\n"


def read_vtp(path: Path) -> Skeleton:
    """The polylines in a VTP file; radii that it lacks are NaN."""
    file = parse_vtk(read_bytes(path))
    pieces = file.root.findall("PolyData/Piece")
    if not pieces:
        raise FormatError("not a VTP file: no PolyData with a Piece")
    nodes: list[NDArray] = []
    edges: list[NDArray] = []
    radii: list[NDArray] = []
    for piece in pieces:
        points = _array(file, piece.find("Points"), None)
        if points is None or points.size % 3:
            raise FormatError("the points have no three coordinates each")
        first, n = sum(map(len, nodes)), points.size // 3
        named = [radius for name in RADIUS_NAMES if (radius := _array(file, piece.find("PointData"), name)) is not None]
        radii.append(named[0] if named else np.full(n, np.nan))
        edges.append(_edges(file, piece.find("Lines"), n) + first)
        nodes.append(points.reshape(-1, 3))
    field = file.root.find("PolyData/FieldData")
    mapped, kind = _array(file, field, "node_of_vertex"), _array(file, field, "radius_kind")
    return Skeleton(
        np.concatenate(nodes),
        np.concatenate(edges),
        np.concatenate(radii),
        as_integers(mapped, "node_of_vertex") if mapped is not None else np.empty(0, dtype=np.int64),
        bytes(kind.astype(np.uint8)).rstrip(b"\0").decode() if kind is not None else Skeleton.radius_kind,
    )


def _array(file: VtkFile, section: Element | None, name: str | None) -> NDArray[np.float64] | None:
    """The array of that name in a section, or its first if None is given; None if there is none."""
    for element in section if section is not None else ():
        if name in (None, element.get("Name")):
            return file.array(element).astype(np.float64)
    return None


def _edges(file: VtkFile, lines: Element | None, n: int) -> NDArray[np.int64]:
    """The pairs of points next to each other on polylines."""
    found = _array(file, lines, "connectivity"), _array(file, lines, "offsets")
    if found[0] is None or found[1] is None:
        return np.empty((0, 2), dtype=np.int64)
    points, ends = as_integers(found[0], "points of lines"), as_integers(found[1], "ends of lines")
    if points.size and (points.min() < 0 or points.max() >= n):
        raise FormatError(f"a line names a point outside 0..{n - 1}")
    if (np.diff(ends, prepend=0) < 0).any() or (ends[-1] if len(ends) else 0) != len(points):
        raise FormatError("the ends of the lines do not fit their points")
    within = np.ones(max(len(points) - 1, 0), dtype=bool)
    within[ends[(ends > 0) & (ends < len(points))] - 1] = False
    return np.stack([points[:-1], points[1:]], axis=1)[within]
