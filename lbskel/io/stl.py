"""STL, the triangle soup of stereolithography, as text or binary: three corners per triangle, no shared vertices.

Corners at exactly the same position become one vertex, in the order of first appearance. Binary STL holds single
precision: about seven digits survive writing.
"""

from __future__ import annotations

__all__ = ["mesh_stl", "read_stl"]

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.polygon_soup import Polygons
from lbskel.io.text import lines_of, read_bytes, table

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
HEADER_BYTES, COUNT_BYTES = 80, 4
FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")


def read_stl(path: Path) -> Polygons:
    """The triangles of an STL file, corners at the same position merged."""
    data = read_bytes(path)
    start = HEADER_BYTES + COUNT_BYTES
    promised = int.from_bytes(data[HEADER_BYTES:start], "little")
    if len(data) == start + promised * TRIANGLE.itemsize and promised:  # text of exactly that length is no accident
        corners = np.frombuffer(data, TRIANGLE, promised, start)["corners"].reshape(-1, 3)
    elif data[:HEADER_BYTES].lstrip().lower().startswith(b"solid"):
        corners = _corners_of_text(data.decode(errors="replace"))
    else:
        raise FormatError(
            f"neither STL text, which begins with solid, nor binary STL: its header promises {promised} triangles, "
            f"which take {start + promised * TRIANGLE.itemsize} bytes, but the file has {len(data)}"
        )
    points, index = _merged(corners.astype(np.float64))
    note = f"{len(corners)} corners at {len(points)} exactly equal positions were merged into as many vertices"
    return Polygons(points, index, np.full(len(corners) // 3, 3), (note,))


def _corners_of_text(text: str) -> NDArray[np.float64]:
    """The (3m, 3) corners of the facets of STL text."""
    lines = lines_of(text, comment="\0")
    words = [line.split(None, 1)[0].lower() for line in lines.texts]
    rows = np.flatnonzero([word not in ("solid", "endsolid") for word in words])
    expected = FACET * (len(rows) // len(FACET) + 1)
    for row, word in zip(rows, expected, strict=False):
        if words[row] != word:
            raise FormatError(f"line {lines.numbers[row]}: {word} expected, found {lines.texts[row][:60]!r}")
    if len(rows) % len(FACET) or words[-1] != "endsolid":
        raise FormatError(f"ends at line {lines.numbers[-1]} without endsolid; is the file truncated?")
    return table(lines[rows[np.array(expected[: len(rows)]) == "vertex"]], range(1, 4), "vertex and three coordinates")


def _merged(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The positions that differ, in the order of first appearance, and for each corner its position."""
    as_bytes = np.ascontiguousarray(corners + 0.0).view(np.dtype((np.void, 24)))[:, 0]  # + 0.0 makes -0.0 and 0.0 one
    _, first, position = np.unique(as_bytes, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.argsort(order)
    return corners[first[order]], rank[position]


def mesh_stl(mesh: Mesh) -> bytes:
    """A mesh as binary STL."""
    rows = np.zeros(len(mesh.faces), dtype=TRIANGLE)
    with np.errstate(over="ignore"):
        rows["corners"] = mesh.vertices[mesh.faces]
    if not np.isfinite(rows["corners"]).all():
        raise FormatError("coordinates beyond the single precision of STL; write obj, off or ply")
    A, B, C = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    rows["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    return b"lbskel".ljust(HEADER_BYTES) + len(rows).to_bytes(COUNT_BYTES, "little") + rows.tobytes()
