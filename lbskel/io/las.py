"""LAS, the format of lidar, and its compressed form LAZ, which is read through laspy.

Coordinates are the scaled whole numbers of the file with its offset; intensity, classes and colors are ignored.
Format: ASPRS, "LAS specification 1.4", https://www.asprs.org/wp-content/uploads/2019/07/LAS_1_4_r15.pdf
"""

from __future__ import annotations

__all__ = ["read_las"]

from pathlib import Path

import numpy as np

from lbskel.errors import FormatError, MissingDependency, counted
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import read_bytes

HEADER = np.dtype(
    {
        "names": ["signature", "minor", "start", "format", "size", "count", "scale", "offset"],
        "formats": ["S4", "u1", "<u4", "u1", "<u2", "<u4", ("<f8", 3), ("<f8", 3)],
        "offsets": [0, 25, 96, 104, 105, 107, 131, 155],
        "itemsize": 227,
    }
)
COUNT_OF_1_4 = 247  # position of the 64-bit number of points in headers of version 1.4
COMPRESSED = 0x80  # bit of the point format that LAZ sets
MAX_RATIO = 100  # points for each byte of a LAZ file that are credible: it stores at least bits for each


def read_las(path: Path) -> PolygonSoup:
    """Read the points of a LAS or LAZ file."""
    data = read_bytes(path)
    if len(data) < HEADER.itemsize or data[:4] != b"LASF":
        raise FormatError("not a LAS file: it does not begin with a header that says LASF")
    header = np.frombuffer(data, HEADER, 1)[0]
    count = int(header["count"])
    if header["minor"] >= 4 and len(data) >= COUNT_OF_1_4 + 8:
        count = int(np.frombuffer(data, "<u8", 1, COUNT_OF_1_4)[0])
    start, size = int(header["start"]), int(header["size"])
    if header["format"] & COMPRESSED:
        return _read_compressed(path, count, len(data))
    if count == 0:
        raise FormatError("the header declares no points")
    if size < 12 or start + count * size > len(data):
        fault = "too few for coordinates" if size < 12 else f"more than its {len(data):,}; is the file truncated?"
        raise FormatError(f"declares {counted(count, 'point')} of {size} bytes, {fault}")
    row = np.dtype({"names": ["xyz"], "formats": [("<i4", 3)], "offsets": [0], "itemsize": size})
    with np.errstate(over="ignore", invalid="ignore"):  # PointCloud names the points that are not finite
        points = np.frombuffer(data, row, count, start)["xyz"] * header["scale"] + header["offset"]
    return PolygonSoup(points)


def _read_compressed(path: Path, count: int, n_bytes: int) -> PolygonSoup:
    try:
        import laspy
    except ImportError:
        raise MissingDependency("laspy", "las", "reading LAZ") from None
    if count > MAX_RATIO * n_bytes:
        raise FormatError(f"declares {counted(count, 'point')} in {n_bytes:,} bytes; is the file truncated?")
    try:
        return PolygonSoup(np.asarray(laspy.read(path).xyz, dtype=np.float64))
    except Exception as error:  # laspy raises errors of many kinds for broken files
        raise FormatError(f"not a LAZ file that laspy reads: {error}") from None
