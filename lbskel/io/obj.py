"""OBJ, the text format of Wavefront: vertices (v), polygons (f) and polylines (l), with 1-based indices.

A negative index counts back from the last vertex defined before its line. Normals, groups and materials are ignored,
and texture coordinates are read apart: the vertices are all ``v`` lines in their order. A skeleton is one polyline per
branch.
"""

from __future__ import annotations

__all__ = ["encode_obj", "encode_obj_skeleton", "read_obj", "read_obj_skeleton", "read_obj_texture"]

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.polygon_soup import PolygonSoup, mesh_from_polygons
from lbskel.io.text import Lines, format_rows, parse_columns, parse_index_lists, read_text
from lbskel.skeleton.skeleton import Skeleton


def read_obj(path: Path) -> PolygonSoup:
    """Read the vertices and polygons of an OBJ file."""
    statements = _statements(read_text(path))
    return PolygonSoup(_points(statements), *_indices(statements, "f"), first_index=1)


def read_obj_texture(path: Path, mesh: Mesh) -> NDArray[np.float64] | None:
    """Read the texture coordinates of a mesh from the OBJ file that it was read from.

    Parameters
    ----------
    path : Path
    mesh : Mesh
        As :func:`lbskel.read_mesh` returns it.

    Returns
    -------
    (m, 3, 2) array of float, or None
        u, and v, which grows upwards, of the corners of each face; None if the file has none.

    Raises
    ------
    FormatError
        If a corner has none, or one that does not exist or is no pair of numbers, or the faces are not the mesh's.
    """
    statements = _statements(read_text(path))
    if "vt" not in statements or "f" not in statements:
        return None
    pairs = parse_columns(statements["vt"], range(2), "two texture coordinates")
    corners, sizes = _indices(statements, "f")
    names = [corner.split("/")[1:2] for line in statements["f"].texts for corner in line.split()]
    numbers = np.array([int(name[0]) if name and re.fullmatch(r"-?\d+", name[0]) else 0 for name in names])
    n_before = np.repeat(np.searchsorted(statements["vt"].numbers, statements["f"].numbers), sizes)
    rows = np.where(numbers < 0, n_before + numbers, numbers - 1)
    missing = (rows < 0) | (rows >= len(pairs))
    if missing.any():
        line = np.repeat(statements["f"].numbers, sizes)[missing.argmax()]
        raise FormatError(f"line {line}: a corner has no texture coordinates, or some that do not exist")
    # the polygons without common corners are cut alike, and tell which corners of the file those of the faces are
    apart = mesh_from_polygons(PolygonSoup(_points(statements)[corners], np.arange(len(corners)), sizes))
    if not np.array_equal(corners[apart.faces], mesh.faces):
        raise FormatError("the faces of the file are not those of the mesh")
    return pairs[rows[apart.faces]]


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
