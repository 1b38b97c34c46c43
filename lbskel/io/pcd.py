"""PCD, the format of the Point Cloud Library: fields of points as text or binary; all but x, y and z are ignored.

Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html. Points with a coordinate that is NaN are
left out, since organized clouds have them where a sensor saw nothing.
"""

from __future__ import annotations

__all__ = ["read_pcd"]

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, counted
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import Lines, content_lines, decode_text, parse_columns, read_bytes

KINDS = {"F": "f", "I": "i", "U": "u"}  # TYPE of a field, in numpy's names


def read_pcd(path: Path) -> PolygonSoup:
    """Read the points of a PCD file, text or binary."""
    data = read_bytes(path)
    header, how, start = _header(data)
    names = header.get("FIELDS", [])
    counts = [_whole(count) for count in header.get("COUNT", ["1"] * len(names))]
    sizes = [header.get(name, ["?"]) for name in (("POINTS",) if "POINTS" in header else ("WIDTH", "HEIGHT"))]
    n_points = math.prod(_whole(" ".join(words)) for words in sizes)
    missing = [name for name in "xyz" if name not in names]
    if missing or len(counts) != len(names):
        raise FormatError(f"FIELDS and COUNT must name x, y and z, not {' '.join(names) or 'nothing'}")
    if how == "ascii":
        first = np.cumsum(counts) - counts
        lines = content_lines(decode_text(data[start:]))
        lines = Lines(lines.texts, lines.numbers + data.count(b"\n", 0, start))
        points = parse_columns(lines, [first[names.index(name)] for name in "xyz"], "x, y and z")
    elif how == "binary":
        points = _binary(data[start:], header, counts, n_points)
    else:
        raise FormatError(
            f"DATA {how} is not supported; save it as ascii or binary, as pcl_convert_pcd_ascii_binary does"
        )
    if len(points) < n_points:
        raise FormatError(f"declares {counted(n_points, 'point')} and has {len(points):,}; is the file truncated?")
    points = points[:n_points]
    return PolygonSoup(points[~np.isnan(points).any(axis=1)])


def _header(data: bytes) -> tuple[dict[str, list[str]], str, int]:
    """Split the header into the words of each line, and find how the data is stored and where it begins."""
    found: dict[str, list[str]] = {}
    position = 0
    while position < len(data):
        end = data.find(b"\n", position)
        end = len(data) if end < 0 else end
        words = decode_text(data[position:end]).split("#", 1)[0].split()
        position = end + 1
        if words:
            found[words[0].upper()] = words[1:]
            if words[0].upper() == "DATA" and len(words) == 2:
                return found, words[1].lower(), position
    raise FormatError("not a PCD file: it has no line DATA")


def _binary(data: bytes, header: dict[str, list[str]], counts: list[int], n_points: int) -> NDArray[np.float64]:
    """Coordinates of the points in rows of binary fields."""
    names, sizes, kinds = header["FIELDS"], header.get("SIZE", []), header.get("TYPE", [])
    if not len(names) == len(sizes) == len(kinds) or not set(kinds) <= set(KINDS):
        raise FormatError("FIELDS, SIZE and TYPE must have an entry for each field")
    try:
        types = [np.dtype(f"<{KINDS[kind]}{_whole(size)}") for kind, size in zip(kinds, sizes, strict=True)]
        fields = [(f"{i}", kind, (count,)) for i, (kind, count) in enumerate(zip(types, counts, strict=True))]
        row = np.dtype(fields)
    except (TypeError, ValueError) as error:
        raise FormatError(f"SIZE and TYPE name no number: {error}") from None
    table = np.frombuffer(data, dtype=row, count=min(n_points, len(data) // row.itemsize))
    return np.stack([table[f"{names.index(name)}"][:, 0] for name in "xyz"], axis=1).astype(np.float64)


def _whole(text: str) -> int:
    """Parse a positive whole number."""
    if not (text.isascii() and text.isdigit() and 0 < int(text[:15]) < 2**40):
        raise FormatError(f"a count in the header is no positive whole number: {text[:20]!r}")
    return int(text)
