"""STL, the triangle soup of stereolithography, as text or binary: three corners per triangle, no shared vertices.

Corners at exactly equal positions are merged into one vertex, in the order of first appearance. Binary STL has single
precision: about seven digits survive writing. A mesh so far from the origin that vertices would merge is not written.
"""

from __future__ import annotations

__all__ = ["encode_stl", "read_stl"]

from codecs import BOM_UTF8
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, counted
from lbskel.geometry.mesh import Mesh
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import content_lines, decode_text, parse_columns, read_bytes

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
HEADER_BYTES, COUNT_BYTES = 80, 4  # of binary STL: free text, then the number of triangles as a little-endian uint32
# Lower bound on the size of a mesh, in its own units. It follows from the smallest normal number in single precision:
# below it, positions have fewer than seven digits
SMALLEST_SIZE = 1e7 * float(np.finfo(np.float32).tiny)
FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def read_stl(path: Path) -> PolygonSoup:
    """Read the triangles of an STL file; corners at exactly equal positions are merged."""
    data = read_bytes(path)
    start = HEADER_BYTES + COUNT_BYTES
    declared = int.from_bytes(data[HEADER_BYTES:start], "little")
    length = start + declared * TRIANGLE.itemsize
    is_text = data.removeprefix(BOM_UTF8)[:HEADER_BYTES].lstrip().lower().startswith(b"solid")
    is_text = is_text and b"\0" not in data.rstrip(b"\0")
    if len(data) == length and (declared or not is_text):  # a text is so long by accident
        corners = np.frombuffer(data, TRIANGLE, declared, start)["corners"].reshape(-1, 3)
    elif is_text:
        corners = _parse_text(decode_text(data))
    else:
        raise FormatError(
            "neither STL text, which begins with solid and has no zero bytes, nor binary STL: its header declares "
            f"{counted(declared, 'triangle')} in {length:,} bytes, but the file has "
            f"{len(data):,}; {'was it cut off?' if len(data) < length else 'save it again'}"
        )
    points, index = _merge(corners.astype(np.float64))
    note = f"{len(corners):,} corners were merged into {counted(len(points), 'vertex')} at exactly equal positions"
    notes = (note,) if len(points) < len(corners) else ()
    return PolygonSoup(points, index, np.full(len(corners) // 3, 3), notes)


def _parse_text(text: str) -> NDArray[np.float64]:
    """Parse the (3m, 3) corners of the facets of STL text."""
    lines = content_lines(text, comment="\0")
    keywords = [line.split(None, 1)[0].lower() for line in lines.texts]
    rows = np.flatnonzero([keyword not in ("solid", "endsolid") for keyword in keywords])
    expected = FACET * (len(rows) // len(FACET) + 1)
    for row, keyword in zip(rows, expected, strict=False):
        if keywords[row] != keyword:
            raise FormatError(f"line {lines.numbers[row]}: {keyword} expected, found {lines.texts[row][:60]!r}")
    if len(rows) % len(FACET) or keywords[-1] != "endsolid":
        raise FormatError(f"ends at line {lines.numbers[-1]} without endsolid; is the file truncated?")
    vertices = lines[rows[np.array(expected[: len(rows)]) == "vertex"]]
    return parse_columns(vertices, range(1, 4), "vertex and three coordinates")


def _merge(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Find the distinct positions, in the order of first appearance, and the index of each corner's position."""
    as_bytes = np.ascontiguousarray(corners + 0.0).view(np.dtype((np.void, 24)))[:, 0]  # + 0.0 turns -0.0 into 0.0
    _, first, position = np.unique(as_bytes, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.argsort(order)
    return corners[first[order]], rank[position]


def encode_stl(mesh: Mesh) -> bytes:
    """Encode a mesh as binary STL, with unit normals by the right-hand rule."""
    rows = np.zeros(len(mesh.faces), dtype=TRIANGLE)
    with np.errstate(over="ignore"):
        rows["corners"] = mesh.vertices[mesh.faces]
    if not np.isfinite(rows["corners"]).all():
        raise FormatError("coordinates overflow the single precision of STL; write obj, off or ply")
    used = mesh.vertices[mesh.used_vertices]
    if np.ptp(used, axis=0).max() < SMALLEST_SIZE:
        raise FormatError("coordinates underflow the single precision of STL; write obj, off or ply")
    n_here, n_there = (len(_merge(V.astype("<f4").astype(np.float64))[0]) for V in (used - used.mean(axis=0), used))
    if (n_lost := n_here - n_there) > 0:
        raise FormatError(
            f"{counted(n_lost, 'vertex')} would merge with others in the single precision of STL; move the mesh to the "
            "origin, or write obj, off or ply"
        )
    rows["normal"] = mesh.face_normals
    return b"lbskel".ljust(HEADER_BYTES) + len(rows).to_bytes(COUNT_BYTES, "little") + rows.tobytes()
