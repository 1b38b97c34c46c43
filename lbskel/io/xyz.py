"""XYZ, a point per line: three coordinates with spaces or commas between.

What follows them, colors or normals, is passed over.
"""

from __future__ import annotations

__all__ = ["read_xyz"]

from pathlib import Path

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import Polygons
from lbskel.io.text import lines_of, read_text, table


def read_xyz(path: Path) -> Polygons:
    """The points of an XYZ file."""
    lines = lines_of(read_text(path).replace(",", " "))
    if not len(lines):
        raise FormatError("holds no points")
    return Polygons(table(lines, range(3), "three coordinates"))
