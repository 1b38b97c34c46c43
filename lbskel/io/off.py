"""OFF, the object file format of Geomview: text, with colors (COFF), normals (NOFF) or texture coordinates (STOFF).

Position comes first on each vertex line; what follows it is passed over.
Format: http://www.geomview.org/docs/html/OFF.html
"""

from __future__ import annotations

__all__ = ["off_text", "read_off"]

import re
from pathlib import Path

import numpy as np

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.atomic_write import rows_text
from lbskel.io.polygon_soup import Polygons
from lbskel.io.text import EXACT_WHOLE, Lines, as_integers, lines_of, numbers_of, ragged, read_bytes, table, text_of

HEADER = re.compile(r"(ST)?C?N?OFF|off")
PLAIN = re.compile(rb"\s*(?:OFF|off)\s+(\d{1,15})\s+(\d{1,15})\s+\d+\s")  # with the counts that are then told


def read_off(path: Path) -> Polygons:
    """The vertices and polygons of an OFF file."""
    data = read_bytes(path)
    return _plain(data) or _with_more(text_of(data))


def _plain(data: bytes) -> Polygons | None:
    """What nothing but positions and triangles is in, in a fifth of the time; None of all else, with its faults."""
    start = PLAIN.match(data)
    if start is None:
        return None
    n_vertices, n_faces = map(int, start.groups())
    try:
        numbers = numbers_of(memoryview(data)[start.end() :])
    except ValueError:
        return None
    if len(numbers) != 3 * n_vertices + 4 * n_faces:
        return None
    faces = numbers[3 * n_vertices :].reshape(n_faces, 4)
    if (faces[:, 0] != 3).any() or (faces != np.floor(faces)).any() or not np.abs(faces).max(initial=0) < EXACT_WHOLE:
        return None
    corners = faces[:, 1:].astype(np.int64).ravel()
    return Polygons(numbers[: 3 * n_vertices].reshape(-1, 3), corners, np.full(n_faces, 3))


def _with_more(text: str) -> Polygons:
    """What has other polygons, comments or more columns, line by line."""
    lines = _without_header(lines_of(text))
    n_vertices, n_faces = as_integers(
        table(lines[:1], range(2), "counts of vertices and faces"), "counts", lines.numbers
    )[0]
    if n_vertices < 0 or n_faces < 0 or len(lines) < 1 + n_vertices + n_faces:
        raise FormatError(
            f"line {lines.numbers[0]}: promises {n_vertices} vertices and {n_faces} faces, "
            f"but {len(lines) - 1} lines follow; is the file truncated?"
        )
    points = table(lines[1 : 1 + n_vertices], range(3), "three coordinates")
    faces = lines[1 + n_vertices : 1 + n_vertices + n_faces]
    sizes = as_integers(table(faces, range(1), "count of corners"), "counts of corners", faces.numbers)[:, 0]
    return Polygons(points, ragged(faces, sizes, 1, "vertex indices"), sizes)


def _without_header(lines: Lines) -> Lines:
    """The lines from the counts on, which may stand on the line of the header."""
    header, rest = [*(lines.texts[0].split(None, 1) if len(lines) else ()), "", ""][:2]
    if not HEADER.fullmatch(header):
        hint = "four or more dimensions" if re.fullmatch(r".*(4|n)OFF", header) else "it must begin with OFF"
        raise FormatError(f"not an OFF file of a surface: {hint}")
    if rest.upper().startswith("BINARY"):
        raise FormatError("binary OFF is not read; save it as text, or as PLY")
    texts, numbers = (lines.texts, lines.numbers) if rest else (lines.texts[1:], lines.numbers[1:])
    if not texts:
        raise FormatError("the file ends after its header")
    return Lines([rest or texts[0], *texts[1:]], numbers)


def off_text(mesh: Mesh) -> str:
    """A mesh as OFF text."""
    F = mesh.faces
    header = f"OFF\n{len(mesh.vertices)} {len(F)} 0\n"
    return header + rows_text("", mesh.vertices) + rows_text("", np.column_stack([np.full(len(F), 3), F]))
