"""XYZ, one point per line: three coordinates separated by spaces, commas or semicolons; also as TXT and CSV.

Further columns, such as colors or normals, are ignored. A first line of names tells the columns if x, y and z are among
them; else the coordinates come first.
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
    text, columns = read_text(path), [0, 1, 2]
    lines = content_lines(re.sub("[,;]", " ", text))
    if len(lines) and (first := NAMES.match(lines.texts[0])) and first[0].lower() not in ("nan", "inf", "infinity"):
        columns = _columns(text.splitlines()[lines.numbers[0] - 1])
        lines = lines[1:]
    if len(lines) > 1 and lines.texts[0] == str(len(lines) - 1):  # the number of points
        lines = lines[1:]
    if not len(lines):
        raise FormatError("the file has no points")
    return PolygonSoup(parse_columns(lines, columns, "three coordinates"))


def _columns(line: str) -> list[int]:
    """Find the columns of x, y and z in a line of names."""
    words = re.split("[,;]", line) if re.search("[,;]", line) else line.split()
    names = [word.strip(' \t"/').lower() for word in words]
    return [names.index(axis) for axis in "xyz"] if {*"xyz"} <= set(names) else [0, 1, 2]
