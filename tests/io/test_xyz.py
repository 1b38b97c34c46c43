"""XYZ: one point per line, further columns ignored."""

import numpy as np
import pytest

from lbskel.errors import FormatError, MeshError
from lbskel.io import read_points

ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 9 9\n"


@pytest.mark.parametrize(
    "content",
    [
        "# c\n0 0 0\n1\t0 0\n\n1 1 0\n0 1 0\n9 9 9",
        ROWS.replace(" ", ", "),
        ROWS.replace("\n", " 0.1 0.2 0.3\n"),
        "5\n" + ROWS,
    ],
)
def test_comments_commas_and_further_columns(read, content):
    cloud = read("a.xyz", content, read_points)
    np.testing.assert_array_equal(cloud.points, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]])


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("1 2 3\n1 2\n", FormatError, "line 2: three coordinates expected, found '1 2'"),
        ("# nothing\n", FormatError, "has no points"),
        ("x,y,z\n", FormatError, "has no points"),
        ("1,5;2,5;3,5\n", FormatError, "line 1: .* decimal points and separated by ';', expected, found '1,5;2,5;3,5'"),
        ("1 2 3\n1,5 2,5 3,5\n", FormatError, "line 2: three coordinates expected"),
        ("1,5 2,5 3,5\n", FormatError, "line 1: .* decimal points"),
        ("1,2,3\n1,,2,3\n", FormatError, "line 2: three coordinates, with decimal points and separated by ','"),
        ("3\n1 2 3\n", FormatError, "line 1: three coordinates expected, found '3'"),
        ("1 2 3\n1 nan 3\n", MeshError, "points 1"),
        ("\nid,px,py,pz\n7,1,2,3\n", FormatError, "line 2: none of more than three columns are named x, y and z; name"),
        (",a,b,c\n0,1,2,3\n", FormatError, "line 1: none of more than three"),
        ("a nx ny nz\n7 0 0 1\n", FormatError, "line 1: none of more than three .* not 'a nx ny nz'"),
    ],
)
def test_errors_name_the_place(rejects, content, error, message):
    rejects("a.xyz", content, error, message, read_points)


@pytest.mark.parametrize("names", ["x,y,z", '"X";"Y";"Z"', "//X Y Z"])
def test_a_first_line_of_names_is_ignored(read, names):
    content = names + "\n" + ROWS.replace(" ", ";" if ";" in names else " ")
    assert len(read("a.csv", content, read_points).points) == 5


def test_a_first_point_that_is_not_finite_is_no_line_of_names(rejects):
    rejects("a.xyz", "nan 0 0\n1 2 3\n", MeshError, "points 0", read_points)


@pytest.mark.parametrize(
    "content",
    ["id,x,y,z\n7,1,2,3\n", '"Point ID";"Z";"Y";"X"\n7;3;2;1\n', "# c\n//r Y X Z\n9 2 1 3\n", "a b c\n1 2 3\n"]
    + ['"r","Points:0","Points:1","Points:2"\n9,1,2,3\n', "id,X [mm],Y (mm),Z[mm]\n7,1,2,3\n"]
    + ["X [mm] Y [mm] Z [mm] R G\n1 2 3 4 5\n", "# r X (mm) Y (mm) Z (mm)\n9 1 2 3\n"]
    + ['"r [1/m, 1/s]","X [m]","Y [m]","Z [m]"\n9,1,2,3\n']
    + ["Cut pipe 7 here\n1 2 3\n", "a;b;c;\n1;2;3;\n"]
    + ["name,x,y,z,r,g,b\n,1,2,3,255,0,0\n", ",x,y,z\n0,1,2,3\n", "# id x y z\n7 1 2 3\n", "#id;z;y;x\n;3;2;1\n"],
)
def test_names_tell_the_columns_of_the_coordinates(read, content):
    np.testing.assert_array_equal(read("a.csv", content, read_points).points, [[1, 2, 3]])


@pytest.mark.parametrize("comment", ["# points: x y z", "# x, y and z", "# x,y,z"])
def test_a_comment_that_does_not_name_every_column_is_none_of_names(read, comment):
    np.testing.assert_array_equal(read("a.xyz", comment + "\n1 2 3 4 5\n", read_points).points, [[1, 2, 3]])
