"""OFF, the text format of Geomview, also with colors (COFF), normals (NOFF) or texture coordinates (STOFF).

Each vertex line begins with the position; the rest of the line is ignored. The counts may follow the header without a
space, as in many files of ModelNet.
Format: http://www.geomview.org/docs/html/OFF.html
"""

from __future__ import annotations

__all__ = ["encode_off", "read_off"]

import re
from pathlib import Path

import numpy as np

from lbskel.errors import FormatError, counted
from lbskel.geometry.mesh import Mesh
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import (
    MAX_EXACT_INTEGER,
    Lines,
    as_integers,
    content_lines,
    decode_text,
    format_rows,
    parse_columns,
    parse_index_lists,
    parse_numbers,
    read_bytes,
)

HEADER = re.compile(r"((?:ST)?C?N?OFF|off)(\d*)")
HEADER_WITH_COUNTS = re.compile(rb"\s*(?:OFF|off)\s*(\d{1,15})\s+(\d{1,15})\s+\d+\s")  # numbers of vertices and faces


def read_off(path: Path) -> PolygonSoup:
    """Read the vertices and polygons of an OFF file."""
    data = read_bytes(path)
    return _parse_triangles(data) or _parse_lines(decode_text(data))


def _parse_triangles(data: bytes) -> PolygonSoup | None:
    """Parse a file of positions and triangles only, in a fifth of the time; None for any other or invalid file."""
    header = HEADER_WITH_COUNTS.match(data)
    if header is None:
        return None
    n_vertices, n_faces = map(int, header.groups())
    try:
        numbers = parse_numbers(memoryview(data)[header.end() :])
    except ValueError:
        return None
    if len(numbers) != 3 * n_vertices + 4 * n_faces:
        return None
    faces = numbers[3 * n_vertices :].reshape(n_faces, 4)
    if (
        (faces[:, 0] != 3).any()
        or (faces != np.floor(faces)).any()
        or not np.abs(faces).max(initial=0) < MAX_EXACT_INTEGER
    ):
        return None
    corners = faces[:, 1:].astype(np.int64).ravel()
    return PolygonSoup(numbers[: 3 * n_vertices].reshape(-1, 3), corners, np.full(n_faces, 3))


def _parse_lines(text: str) -> PolygonSoup:
    """Parse a file with other polygons, comments or more columns line by line."""
    lines = _skip_header(content_lines(text))
    n_vertices, n_faces = as_integers(
        parse_columns(lines[:1], range(2), "counts of vertices and faces"), "counts", lines.numbers
    )[0]
    if n_vertices < 0 or n_faces < 0 or len(lines) < 1 + n_vertices + n_faces:
        raise FormatError(
            f"line {lines.numbers[0]}: declares {counted(n_vertices, 'vertex')} and "
            f"{counted(n_faces, 'face')}, but is followed by {counted(len(lines) - 1, 'line')}; is the file truncated?"
        )
    points = parse_columns(lines[1 : 1 + n_vertices], range(3), "three coordinates")
    faces = lines[1 + n_vertices : 1 + n_vertices + n_faces]
    sizes = as_integers(parse_columns(faces, range(1), "count of corners"), "counts of corners", faces.numbers)[:, 0]
    return PolygonSoup(points, parse_index_lists(faces, sizes, 1, "vertex indices"), sizes)


def _skip_header(lines: Lines) -> Lines:
    """Drop the header; the counts may follow it on the same line."""
    header, rest = [*(lines.texts[0].split(None, 1) if len(lines) else ()), "", ""][:2]
    if not (match := HEADER.fullmatch(header)):
        hint = "four or more dimensions" if re.fullmatch(r".*(4|n)OFF", header) else "it must begin with OFF"
        raise FormatError(f"not an OFF file of a surface: {hint}")
    rest = f"{match[2]} {rest}".strip()
    if rest.upper().startswith("BINARY"):
        raise FormatError("binary OFF is not supported; save it as text, or as PLY")
    texts, numbers = (lines.texts, lines.numbers) if rest else (lines.texts[1:], lines.numbers[1:])
    if not texts:
        raise FormatError("the file ends after its header")
    return Lines([rest or texts[0], *texts[1:]], numbers)


def encode_off(mesh: Mesh) -> str:
    """Encode a mesh as OFF text."""
    F = mesh.faces
    header = f"OFF\n{len(mesh.vertices)} {len(F)} 0\n"
    return header + format_rows("", mesh.vertices) + format_rows("", np.column_stack([np.full(len(F), 3), F]))
