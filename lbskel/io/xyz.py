"""XYZ, one point per line: three coordinates separated by spaces, commas or semicolons; also as TXT and CSV.

Further columns, such as colors or normals, are ignored, and so is a first line of names.
"""

from __future__ import annotations

__all__ = ["read_xyz"]

import re
from pathlib import Path

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import content_lines, parse_columns, read_text

NAMES = re.compile(r"(//)?\"?[^\W\d]\w*\"?")  # the first word of a line of names; CloudCompare writes //X


def read_xyz(path: Path) -> PolygonSoup:
    """Read the points of an XYZ file."""
    lines = content_lines(re.sub("[,;]", " ", read_text(path)))
    if len(lines) and (first := NAMES.match(lines.texts[0])) and first[0].lower() not in ("nan", "inf", "infinity"):
        lines = lines[1:]
    if len(lines) > 1 and lines.texts[0] == str(len(lines) - 1):  # the number of points
        lines = lines[1:]
    if not len(lines):
        raise FormatError("the file has no points")
    return PolygonSoup(parse_columns(lines, range(3), "three coordinates"))
