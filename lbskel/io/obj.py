"""OBJ, the text format of Wavefront: vertices (v), polygons (f) and polylines (l), with 1-based indices.

A negative index counts back from the last vertex defined before its line. Texture coordinates, normals, groups and
materials are ignored: the vertices are all ``v`` lines in their order. A skeleton is one polyline per branch.
"""

from __future__ import annotations

__all__ = ["encode_obj", "encode_obj_skeleton", "read_obj", "read_obj_skeleton"]

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import Lines, format_rows, parse_columns, parse_index_lists, read_text
from lbskel.skeleton.skeleton import Skeleton


def read_obj(path: Path) -> PolygonSoup:
    """Read the vertices and polygons of an OBJ file."""
    statements = _statements(read_text(path))
    return PolygonSoup(_points(statements), *_indices(statements, "f"), first_index=1)


def read_obj_skeleton(path: Path) -> Skeleton:
    """Read the vertices and polylines of an OBJ file as a skeleton; OBJ has no radii, so they are NaN."""
    statements = _statements(read_text(path))
    points = _points(statements)
    if "f" in statements and "l" not in statements:
        raise FormatError("has faces and no polylines: it is a mesh, not a skeleton")
    indices, sizes = _indices(statements, "l")
    polyline = np.repeat(np.arange(len(sizes)), sizes)
    is_edge = polyline[1:] == polyline[:-1]
    edges = np.stack([indices[:-1], indices[1:]], axis=1)[is_edge]
    return Skeleton(points, edges, np.full(len(points), np.nan))


def _statements(text: str) -> dict[str, Lines]:
    """Group the arguments of all statements by their keyword, the first word of the line."""
    found: defaultdict[str, tuple[list[str], list[int]]] = defaultdict(lambda: ([], []))
    statement, first = "", 0
    for number, line in enumerate([*text.splitlines(), ""], 1):
        first = first if statement else number
        statement += line.split("#", 1)[0]
        if statement.endswith("\\"):  # continued on the next line
            statement = statement[:-1] + " "
            continue
        words, statement = statement.split(None, 1), ""
        if words:
            texts, numbers = found[words[0]]
            texts.append(words[1].strip() if len(words) > 1 else "")
            numbers.append(first)
    return {word: Lines(texts, np.array(numbers)) for word, (texts, numbers) in found.items()}


def _points(statements: dict[str, Lines]) -> NDArray[np.float64]:
    """Parse the (n, 3) vertex positions."""
    if "v" not in statements:
        raise FormatError("not an OBJ file with geometry: no line begins with v")
    return parse_columns(statements["v"], range(3), "three coordinates")


def _indices(statements: dict[str, Lines], keyword: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Parse all f or l statements: their 0-based vertex indices, concatenated, and the number of indices of each.

    Indices of vertices that do not exist are out of range, negative or too large, and rejected by the caller.
    """
    if keyword not in statements:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    lines = statements[keyword]
    lines = Lines(re.sub(r"/\S*", "", "\n".join(lines.texts)).split("\n"), lines.numbers)  # 7/2/9 is vertex 7
    sizes = np.array([len(line.split()) for line in lines.texts], dtype=np.int64)
    given = parse_index_lists(lines, sizes, 0, "vertex indices")
    n_before = np.repeat(np.searchsorted(statements["v"].numbers, lines.numbers), sizes)
    return np.where(given < 0, n_before + given, given - 1), sizes


def encode_obj(mesh: Mesh) -> str:
    """Encode a mesh as OBJ text."""
    return format_rows("v ", mesh.vertices) + format_rows("f ", mesh.faces + 1)


def encode_obj_skeleton(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """Encode a skeleton as vertices and one polyline per branch; radii are lost."""
    polylines = "".join(f"l {' '.join(map(str, branch + 1))}\n" for branch in skeleton.branches)
    return {path: format_rows("v ", skeleton.nodes) + polylines}
