"""XYZ, one point per line: three coordinates separated by white space, commas or semicolons; also as TXT and CSV.

The first point tells which of these separates the columns of all lines. Further columns, such as colors or normals, are
ignored. A first line of names, or a comment that names every column, tells the columns if x, y and z are among them,
such as ``X [mm]``, or ParaView's ``Points:0`` to ``Points:2``. Else the coordinates come first; of more than three
columns with other names nobody knows which they are.
"""

from __future__ import annotations

__all__ = ["read_xyz"]

import re
from pathlib import Path

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import content_lines, parse_columns, read_text

NAMES = re.compile(r"[\s,;\"]*(//)?\"?([^\W\d]\w*)")  # the first word of a line of names; CloudCompare writes //X
UNIT = re.compile(r"\s*(\[[^\]]*\]|\([^)]*\))")
POINTS = ("points:0", "points:1", "points:2")  # names of the coordinates in tables of ParaView


def read_xyz(path: Path) -> PolygonSoup:
    """Read the points of an XYZ file."""
    text = read_text(path)
    lines, columns, header = content_lines(text), None, None
    if len(lines) and (first := NAMES.match(lines.texts[0])) and first[2].lower() not in ("nan", "inf", "infinity"):
        header, lines = lines[:1], lines[1:]
    if len(lines) > 1 and lines.texts[0] == str(len(lines) - 1):  # the number of points
        lines = lines[1:]
    if not len(lines):
        raise FormatError("the file has no points")
    delimiter = next((mark for mark in ";," if mark in lines.texts[0]), None)
    if header is not None:
        columns = _columns(header.texts[0])
        n_names, n_columns = (len(_fields(each.texts[0].rstrip(" ,;"))) for each in (header, lines))
        if columns is None and n_names == n_columns > 3:
            raise FormatError(
                f"line {header.numbers[0]}: none of more than three columns are named x, y and z; name those of the "
                f"coordinates so, not {header.texts[0][:60]!r}"
            )
        columns = columns or [0, 1, 2]
    for line in text.splitlines()[: lines.numbers[0] - 1]:
        names = line.strip().removeprefix("#")
        if columns is None and names != line.strip() and len(_fields(names)) == len(_fields(lines.texts[0])):
            columns = _columns(names)
    what = f", with decimal points and separated by {delimiter!r}," if delimiter else ""
    return PolygonSoup(parse_columns(lines, columns or [0, 1, 2], f"three coordinates{what}", delimiter))


def _fields(line: str) -> list[str]:
    """Split a line, without units in brackets, at its semicolons, or else its commas, or else its white space."""
    line = UNIT.sub("", line)
    return line.split(next((mark for mark in ";," if mark in line), None))


def _columns(line: str) -> list[int] | None:
    """Find the columns of x, y and z in a line of names; None if it lacks one."""
    names = [word.strip(' \t"/').lower() for word in _fields(line)]
    return next(([*map(names.index, axes)] for axes in ("xyz", POINTS) if {*axes} <= set(names)), None)
