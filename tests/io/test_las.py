"""LAS and LAZ, through laspy."""

import sys

import numpy as np
import pytest

from lbskel import FormatError, MissingDependency, read_points


@pytest.mark.parametrize("extension", ["las", "laz"])
def test_coordinates_are_scaled_and_offset(tmp_path, extension):
    laspy = pytest.importorskip("laspy")
    points = np.array([[1e6, 2e6, 3], [1e6 + 0.001, 2e6, 3.5]])
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.offsets, header.scales = points[0], [0.001] * 3
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    path = tmp_path / f"a.{extension}"
    data.write(path)
    assert read_points(path).points == pytest.approx(points, abs=1e-9)  # rounding at 1e6


def header(count, size=20, format=0, start=227):
    data = bytearray(227)
    data[:4], data[24:26] = b"LASF", bytes([1, 2])
    data[96:100], data[104], data[105:107] = start.to_bytes(4, "little"), format, size.to_bytes(2, "little")
    data[107:111] = count.to_bytes(4, "little")
    return bytes(data)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"x y z\n", "does not begin with a header that says LASF"),
        (b"LASF" + b"\0" * 99, "does not begin with a header"),
        (header(3) + b"\0" * 40, "declares 3 points of 20 bytes, more than its 267; is the file truncated"),
        (header(0), "the header declares no points"),
        (header(2**32 - 1), "is the file truncated"),
        (header(1, size=3) + b"\0" * 40, "declares 1 point of 3 bytes, too few for coordinates"),
        (header(2**32 - 1, format=0x80), "declares 4,294,967,295 points in 227 bytes"),
    ],
    ids=range(7),
)
def test_broken_files_are_named(rejects, content, message):
    pytest.importorskip("laspy")
    rejects("a.las", content, FormatError, message, read_points)


def test_what_laspy_refuses_is_no_traceback(rejects):
    pytest.importorskip("laspy")
    rejects("a.laz", header(5, format=0x80) + b"\0" * 40, FormatError, "not a LAZ file that laspy reads", read_points)


def test_without_laspy_the_error_has_the_way_out(read, monkeypatch):
    monkeypatch.setitem(sys.modules, "laspy", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[las\]'"):
        read("a.laz", header(5, format=0x80), read_points)
