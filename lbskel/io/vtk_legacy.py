"""Meshes in VTK's legacy files (.vtk) of polygonal data, as text or big-endian binary, of versions 1 to 5.

Up to version 4 a cell is its number of points and their indices; from 5 on the cells are an array of offsets and one of
indices, as in XML files. Point and cell data are left out.
Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

__all__ = ["read_vtk"]

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, choose, counted
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import as_integers, read_bytes
from lbskel.io.vtk_polydata import Cells, join_cells, wrong_data_set

HEAD = re.compile(rb"\s*# vtk DataFile Version (\d+)\.\d+[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s*\n", re.IGNORECASE)
DTYPES = {
    "float": ">f4",
    "double": ">f8",
    "char": ">i1",
    "unsigned_char": ">u1",
    "short": ">i2",
    "unsigned_short": ">u2",
    "int": ">i4",
    "unsigned_int": ">u4",
    "long": ">i8",  # of Linux and macOS; 4 bytes on Windows
    "unsigned_long": ">u8",
    "vtkidtype": ">i4",
    "vtktypeint64": ">i8",
    "vtktypeuint64": ">u8",
}
CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS")


class _Scanner:
    """The position in a file, and what is read from there on."""

    def __init__(self, data: bytes, position: int, is_binary: bool):
        self._data, self._position, self._is_binary = data, position, is_binary

    def words(self) -> list[str]:
        """Read the words of the next line that is not empty; none at the end of the file."""
        while self._position < len(self._data):
            end = self._data.find(b"\n", self._position)
            end = len(self._data) if end < 0 else end
            line, self._position = self._data[self._position : end], end + 1
            if line.strip():
                return line.decode("ascii", "replace").split()
        return []

    def skip_paragraph(self) -> None:
        """Move the position behind the next empty line."""
        match = re.compile(rb"\n[ \t\r]*\n").search(self._data, self._position - 1)
        self._position = match.end() if match else len(self._data)

    def skip_texts(self, count: int) -> None:
        """Move the position behind texts: a line each, or a length, its size in its first two bits, and a text."""
        for _ in range(count):
            begin = self._position
            if self._is_binary:
                width = 8 >> (self._data[begin : begin + 1] or b"\0")[0] // 64
                length = int.from_bytes(self._data[begin : begin + width], "big") % (1 << 8 * width - 2)
                self._position = begin + width + length
            else:
                self._position = self._data.find(b"\n", begin) + 1 or len(self._data) + 1
            if self._position > len(self._data):
                raise FormatError(f"declares {counted(count, 'text')}, and fewer follow; is the file truncated?")

    def numbers(self, count: int, kind: str) -> NDArray[np.float64]:
        """Read ``count`` numbers of a type, as (count,) float64."""
        dtype = np.dtype(choose(DTYPES, kind.lower(), "type of numbers"))
        n_bytes = count * dtype.itemsize if self._is_binary else count
        if not 0 <= n_bytes <= len(self._data) - self._position:
            raise FormatError(f"declares {counted(count, 'number')}, and fewer follow; is the file truncated?")
        if self._is_binary:
            values = np.frombuffer(self._data, dtype, count, self._position).astype(np.float64)
            self._position += n_bytes
            return values
        *parts, rest = [*self._data[self._position :].split(None, count), b""][: count + 1]
        if len(parts) < count:
            raise FormatError(f"declares {counted(count, 'number')}, and fewer follow; is the file truncated?")
        self._position = len(self._data) - len(rest)
        try:
            return np.array(parts, dtype=np.bytes_).astype(np.float64)
        except ValueError as error:
            raise FormatError(f"not a number: {error}") from None


def read_vtk(path: Path) -> PolygonSoup:
    """Read the polygons and triangle strips of a legacy file of polygonal data."""
    data = read_bytes(path)
    head = HEAD.match(data)
    if not head:
        raise FormatError("not a legacy VTK file: it does not begin with '# vtk DataFile Version'")
    scanner = _Scanner(data, head.end(), head.group(2).upper() == b"BINARY")
    keyword, *kind = scanner.words() or [""]
    if keyword.upper() != "DATASET" or [word.upper() for word in kind] != ["POLYDATA"]:
        raise wrong_data_set(" ".join(kind) or "an unknown type")
    points, cells = np.empty((0, 3)), dict[str, Cells]()
    while words := scanner.words():
        keyword, arguments = words[0].upper(), words[1:]
        if keyword in ("POINT_DATA", "CELL_DATA"):
            break
        if keyword == "METADATA":
            scanner.skip_paragraph()
        elif keyword == "FIELD":
            _skip_field(scanner, _count(arguments, 1))
        elif keyword == "POINTS":
            points = scanner.numbers(3 * _count(arguments, 0), arguments[-1]).reshape(-1, 3)
        elif keyword in CELLS:
            counts = _count(arguments, 0), _count(arguments, 1)
            cells[keyword] = (_cells_by_offsets if int(head.group(1)) >= 5 else _cells_by_sizes)(scanner, *counts)
        else:
            raise FormatError(f"unknown section {words[0]!r}")
    taken = [[cells[name]] if name in cells else [] for name in ("POLYGONS", "TRIANGLE_STRIPS")]
    return join_cells([points], *taken)


def _count(arguments: list[str], place: int) -> int:
    """Return a number of the line that begins a section."""
    if len(arguments) <= place or not re.fullmatch(r"\d{1,15}", arguments[place]):
        raise FormatError(f"a section begins with {' '.join(arguments)!r}, where its size is expected")
    return int(arguments[place])


def _skip_field(scanner: _Scanner, n_arrays: int) -> None:
    """Skip the arrays of a field, which say nothing about the surface."""
    while n_arrays:
        words = scanner.words()
        if words[:1] == ["METADATA"]:
            scanner.skip_paragraph()
            continue
        if len(words) != 4:
            raise FormatError(f"an array of a field begins with {' '.join(words)!r}, not with a name, sizes and a type")
        count = _count(words, 1) * _count(words, 2)
        if words[3].lower() == "string":
            scanner.skip_texts(count)
        else:
            scanner.numbers(count, words[3])
        n_arrays -= 1


def _cells_by_offsets(scanner: _Scanner, n_offsets: int, n_corners: int) -> Cells:
    """Read cells of version 5: an array of offsets, which begins with 0, and one of points."""
    offsets, corners = (
        as_integers(scanner.numbers(count, _array_type(scanner.words(), name)), f"{name.lower()} of cells")
        for name, count in (("OFFSETS", n_offsets), ("CONNECTIVITY", n_corners))
    )
    sizes = np.diff(offsets)
    if (sizes < 0).any() or offsets[:1].any() or offsets[-1:].sum() != n_corners:
        raise FormatError("the offsets of the cells do not match their connectivity")
    return corners, sizes


def _array_type(words: list[str], name: str) -> str:
    """Return the type of an array from the line before it."""
    if len(words) != 2 or words[0].upper() != name:
        raise FormatError(f"{name} and a type expected, found {' '.join(words)!r}")
    return words[1]


def _cells_by_sizes(scanner: _Scanner, n_cells: int, n_numbers: int) -> Cells:
    """Read cells of versions before 5: for each its number of points, then the points."""
    numbers = as_integers(scanner.numbers(n_numbers, "int"), "cells")
    starts: list[int] = []
    start, sizes_at = 0, numbers.tolist()
    while start < n_numbers and len(starts) < n_cells:
        starts.append(start)
        start += 1 + max(sizes_at[start], 0)
    if start != n_numbers or len(starts) != n_cells:
        raise FormatError(
            f"declares {counted(n_cells, 'cell')} of {counted(n_numbers, 'number')}, but the sizes of the cells differ"
        )
    return np.delete(numbers, starts), numbers[starts]
