"""PCD: text and binary, fields in any order, broken headers."""

import numpy as np
import pytest

from lbskel import FormatError, read_points

HEADER = "# .PCD v.7\nVERSION .7\nFIELDS rgb z x y\nSIZE 4 4 8 4\nTYPE U F F F\nCOUNT 2 1 1 1\n"
HEADER += "WIDTH 2\nHEIGHT 1\nPOINTS {n}\n"
ROW = np.dtype([("rgb", "<u4", 2), ("z", "<f4"), ("x", "<f8"), ("y", "<f4")])
BINARY = np.array([((1, 2), 3, 1, 2), ((3, 4), 6, 4, 5)], dtype=ROW).tobytes()


def header(n=2):
    return HEADER.format(n=n)


def test_text_and_binary_are_the_same_points(read):
    text = read("a.pcd", header() + "DATA ascii\n1 2 3 1 2\n3 4 6 4 5\n", read_points)
    binary = read("a.pcd", (header() + "DATA binary\n").encode() + BINARY, read_points)
    np.testing.assert_array_equal(text.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(binary.points, text.points)


def test_without_their_number_there_are_width_times_height(read):
    cloud = read("a.pcd", header().replace("POINTS 2\n", "") + "DATA ascii\n1 2 3 1 2\n3 4 6 4 5\n", read_points)
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])


def test_points_that_a_sensor_did_not_see_are_left_out(read):
    cloud = read("a.pcd", header() + "DATA ascii\n1 2 nan nan nan\n3 4 6 4 5\n", read_points)
    np.testing.assert_array_equal(cloud.points, [[4, 5, 6]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("VERSION .7\n", "no line DATA"),
        (header().replace(" z", " w") + "DATA ascii\n1 2 3 1 2\n", "must name x, y and z"),
        (header() + "DATA binary_compressed\n", "save it as ascii or binary"),
        (header(3) + "DATA ascii\n1 2 3 1 2\n3 4 6 4 5\n", "declares 3 points and has 2"),
        (header() + "DATA binary\nxx", "declares 2 points and has 0"),
        (header().replace("POINTS 2\n", "") + "DATA ascii\n1 2 3 1 2\n", "declares 2 points and has 1"),
        (header().replace("WIDTH 2", "").replace("POINTS 2\n", "") + "DATA ascii\n", "positive whole number: '\\?'"),
        (header().replace("POINTS 2", "POINTS -2") + "DATA ascii\n", "positive whole number: '-2'"),
        (header().replace("SIZE 4 4 8 4", "SIZE 4 4 7 4") + "DATA binary\n" + "x" * 99, "SIZE and TYPE name no number"),
        (header().replace("TYPE U F F F", "TYPE U F F") + "DATA binary\n" + "x" * 99, "an entry for each field"),
        (header() + "DATA ascii\n1 2 3 1\n", "line 11: x, y and z expected"),
    ],
)
def test_errors_name_the_place(rejects, content, message):
    rejects("a.pcd", content, FormatError, message, read_points)


def test_a_header_that_declares_gigabytes_allocates_none(rejects_without_allocating):
    rejects_without_allocating("a.pcd", header(10**9) + "DATA binary\n", read_points)
