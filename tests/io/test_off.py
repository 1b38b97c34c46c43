"""OFF: its variants, its fast path for triangles, and errors that name the line."""

import numpy as np
import pytest

from lbskel import read_mesh
from lbskel.errors import FormatError, MeshError
from lbskel.io import read_points
from lbskel.io.off import _parse_triangles, encode_off
from lbskel.shapes import torus

ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 9 9\n"
TRIANGLE = "0 0 0\n1 0 0\n0 1 0\n"
PLAIN = "OFF\n5 1 0\n" + ROWS + "4 0 1 2 3\n"

SQUARES = {
    "plain": PLAIN,
    "comments": "# c\n\nOFF # c\n# c\n5 1\n\n" + ROWS.replace("\n", " # c\n\n") + "4  0 1\t2 3 # c",
    "counts on the line of the header": "OFF 5 1 0\n" + ROWS + "4 0 1 2 3 1.0 0.5 0 1\n",
    "counts without a space": "OFF5 1 0\n" + ROWS + "4 0 1 2 3\n",
    "colors and counts without a space": "COFF5 1 0\n" + ROWS.replace("\n", " 9 9 9\n") + "4 0 1 2 3\n",
    "colors": "COFF\n5 1 0\n" + ROWS.replace("\n", " 255 0 0 255\n") + "4 0 1 2 3 255 0 0\n",
    "normals": "NOFF\n5 1 0\n" + ROWS.replace("\n", " 0 0 1\n") + "4 0 1 2 3\n",
    "texture coordinates": "STOFF\n5 1 0\n" + ROWS.replace("\n", " 0.5 0.25\n") + "4 0 1 2 3\n",
}


@pytest.mark.parametrize("name", SQUARES)
def test_all_vertices_are_kept_in_order_and_polygons_triangulated(read, check_square, name):
    check_square(read("a.off", SQUARES[name]))


def test_polygons_of_several_sizes(read, check_polygons):
    check_polygons(read("a.off", "OFF\n5 4 0\n" + ROWS + "3 0 1 2\n4 0 1 2 3\n5 3 0 1 2 4\n3 2 1 0\n"))


@pytest.mark.parametrize("layout", ["OFF\n{}", "\n OFF {}", "off\n\n{}", "OFF{}"])
def test_the_fast_path_reads_the_same_as_the_path_by_lines(tmp_path, layout):
    text = encode_off(torus(1.0, 0.3, 12, 8)).removeprefix("OFF\n")
    fast, by_lines = tmp_path / "fast.off", tmp_path / "by_lines.off"
    fast.write_text(layout.format(text))
    by_lines.write_text(f"OFF # a comment\n{text}")
    assert _parse_triangles(fast.read_bytes()) is not None
    assert _parse_triangles(by_lines.read_bytes()) is None
    np.testing.assert_array_equal(read_mesh(fast).vertices, read_mesh(by_lines).vertices)
    np.testing.assert_array_equal(read_mesh(fast).faces, read_mesh(by_lines).faces)


@pytest.mark.parametrize("row", ["3 0 1 9.5", "3 0 1", "3 0 1 x", "4 0 1 2 3", "2 0 1 2", "3 0 1 1e300"])
def test_the_fast_path_leaves_all_other_files_to_the_path_by_lines(row):
    assert _parse_triangles(f"OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n{row}\n".encode()) is None


def test_written_rows_begin_with_the_number_of_corners(tetrahedron):
    lines = encode_off(tetrahedron).splitlines()
    assert lines[:3] == ["OFF", "4 4 0", "0.0 0.0 0.0"]
    assert lines[6:] == ["3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("", FormatError, "the file is empty"),
        ("# nothing\n", FormatError, "it must begin with OFF"),
        ("v 0 0 0\n", FormatError, "it must begin with OFF"),
        ("4OFF\n1 0 0\n0 0 0 0\n", FormatError, "four or more dimensions"),
        ("OFF BINARY\n\x00\x00", FormatError, "binary OFF is not supported"),
        ("OFF\n", FormatError, "ends after its header"),
        ("OFF\nmany\n", FormatError, "line 2: counts of vertices and faces expected, found 'many'"),
        ("OFF\n3 1.5 0\n" + TRIANGLE, FormatError, "line 2: counts must be whole"),
        ("OFF\n-3 1 0\n" + TRIANGLE, FormatError, "line 2: declares -3 vertices"),
        ("OFF\n3 1 0\n" + TRIANGLE, FormatError, "line 2: declares 3 vertices and 1 face, but is followed by 3 lines"),
        ("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", FormatError, "line 4: three coordinates expected"),
        ("OFF\n3 1 0\n" + TRIANGLE + "3 0 1\n", FormatError, "line 6: 3 vertex indices expected, found '3 0 1'"),
        ("OFF\n3 1 0\n" + TRIANGLE + "3000000000 0 1\n", FormatError, "line 6: cannot have 3000000000"),
        ("OFF\n3 1 0\n" + TRIANGLE + "-3 0 1\n", FormatError, "line 6: cannot have -3"),
        ("OFF\n3 1 0\n" + TRIANGLE + "3 0 1 3\n", MeshError, "faces 0 .*numbered 0 to 2"),
        ("OFF\n3 1 0\n" + TRIANGLE + "4 0 1 2 -1\n", MeshError, "faces 0 .*use vertices that do not exist"),
        ("OFF\n3 1 0\n" + TRIANGLE + "2 0 1\n", MeshError, "faces 0 .*fewer than three corners"),
        ("OFF\n3 0 0\n" + TRIANGLE, MeshError, "no faces"),
    ],
)
def test_errors_name_the_place(rejects, content, error, message):
    rejects("a.off", content, error, message)


def test_no_vertices_are_an_error_of_a_point_cloud(rejects):
    rejects("a.off", "OFF\n0 0 0\n", MeshError, "empty", read_points)


def test_a_file_without_its_last_number_is_rejected(read):
    for length in range(len(PLAIN.rstrip()) - 1):
        with pytest.raises(FormatError):
            read("a.off", PLAIN[:length])


def test_declared_gigabytes_are_not_allocated(rejects_without_allocating):
    rejects_without_allocating("a.off", "OFF\n130000000 10 0\n0 0 0\n")
