"""OBJ, the text format of Wavefront: vertices (v), polygons (f) and polylines (l), numbered from 1.

A negative number counts back from the vertex line before it. Texture coordinates, normals, groups and materials are
passed over: the vertices are the ``v`` lines, all of them, in their order. A skeleton is one polyline per branch.
"""

from __future__ import annotations

__all__ = ["obj_text", "read_obj", "read_obj_skeleton", "skeleton_obj"]

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.mesh import Mesh
from lbskel.io.atomic_write import rows_text
from lbskel.io.polygon_soup import Polygons
from lbskel.io.text import Lines, ragged, read_text, table
from lbskel.skeleton.skeleton import Skeleton


def read_obj(path: Path) -> Polygons:
    """The vertices and polygons of an OBJ file."""
    statements = _statements(read_text(path))
    return Polygons(_points(statements), *_indices(statements, "f"), first_index=1)


def read_obj_skeleton(path: Path) -> Skeleton:
    """The vertices and polylines of an OBJ file; it has no radii, so they are NaN."""
    statements = _statements(read_text(path))
    points = _points(statements)
    if "f" in statements and "l" not in statements:
        raise FormatError("holds faces and no lines: it is a mesh and no skeleton")
    corners, sizes = _indices(statements, "l")
    polyline = np.repeat(np.arange(len(sizes)), sizes)
    joined = polyline[1:] == polyline[:-1]
    edges = np.stack([corners[:-1], corners[1:]], axis=1)[joined]
    return Skeleton(points, edges, np.full(len(points), np.nan))


def _statements(text: str) -> dict[str, Lines]:
    """What follows the first word of each line, by that word."""
    found: defaultdict[str, tuple[list[str], list[int]]] = defaultdict(lambda: ([], []))
    for number, line in enumerate(re.sub(r"\\\r?\n", " ", text).splitlines(), 1):
        words = line.split("#", 1)[0].split(None, 1)
        if words:
            texts, numbers = found[words[0]]
            texts.append(words[1].strip() if len(words) > 1 else "")
            numbers.append(number)
    return {word: Lines(texts, np.array(numbers)) for word, (texts, numbers) in found.items()}


def _points(statements: dict[str, Lines]) -> NDArray[np.float64]:
    """The (n, 3) positions."""
    if "v" not in statements:
        raise FormatError("not an OBJ file of a shape: no line begins with v")
    return table(statements["v"], range(3), "three coordinates")


def _indices(statements: dict[str, Lines], word: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """0-based vertex indices of all f or l lines, one line after the other, and how many each has.

    What names no vertex becomes a negative index, which whoever takes them refuses.
    """
    if word not in statements:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    lines = statements[word]
    lines = Lines(re.sub(r"/\S*", "", "\n".join(lines.texts)).split("\n"), lines.numbers)  # 7/2/9 is vertex 7
    sizes = np.array([len(line.split()) for line in lines.texts], dtype=np.int64)
    given = ragged(lines, sizes, 0, "vertex indices")
    seen = np.repeat(np.searchsorted(statements["v"].numbers, lines.numbers), sizes)
    return np.where(given < 0, seen + given, given - 1), sizes


def obj_text(mesh: Mesh) -> str:
    """A mesh as OBJ text."""
    return rows_text("v ", mesh.vertices) + rows_text("f ", mesh.faces + 1)


def skeleton_obj(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """A skeleton as vertices and one polyline per branch; radii are lost."""
    polylines = "".join(f"l {' '.join(map(str, branch + 1))}\n" for branch in skeleton.branches)
    return {path: rows_text("v ", skeleton.nodes) + polylines}
