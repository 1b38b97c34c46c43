"""XYZ, one point per line: three coordinates separated by spaces or commas.

Further columns, such as colors or normals, are ignored.
"""

from __future__ import annotations

__all__ = ["read_xyz"]

from pathlib import Path

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import content_lines, parse_columns, read_text


def read_xyz(path: Path) -> PolygonSoup:
    """Read the points of an XYZ file."""
    lines = content_lines(read_text(path).replace(",", " "))
    if not len(lines):
        raise FormatError("the file has no points")
    return PolygonSoup(parse_columns(lines, range(3), "three coordinates"))
