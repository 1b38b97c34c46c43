"""OBJ: what its statements mean, and errors that name the line."""

import numpy as np
import pytest

from lbskel.errors import FormatError, MeshError
from lbskel.io import read_mesh, read_skeleton, write_mesh, write_skeleton
from lbskel.io.obj import read_obj_texture

VERTICES = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\n"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

SQUARES = {
    "polygon": VERTICES + "f 1 2 3 4\n",
    "relative indices": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\nv 9 9 9\n",
    "seams": (
        "mtllib none.mtl\no thing\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n" + VERTICES + "usemtl a\n"
        "f 1/1/1 2/2/1 3/3/1 4/2/1\nl 1 2\np 5\n"
    ),
    "weights, colors and line ends": (
        "# c\r\nv 0 0 0 1 # w\r\nv\t1 0 0 .5 .5 .5\r\nv 1 1 \\\r\n 0\r\nv 0 1e0 0\r\nv 9 9 9\r\nf 1//1 2// 3 4//2\r\n"
    ),
}


@pytest.mark.parametrize("name", SQUARES)
def test_all_vertices_are_kept_in_order_and_polygons_triangulated(read, check_square, name):
    check_square(read("a.obj", SQUARES[name]))


def test_polygons_of_several_sizes(read, check_polygons):
    check_polygons(read("a.obj", VERTICES + "f 1 2 3\nf 1 2 3 4\nf 4 1 2 3 5\nf 3 2 1\n"))


def test_faces_keep_their_order_across_materials(read):
    text = VERTICES + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 2 3 5\n"
    np.testing.assert_array_equal(read("a.obj", text).faces, [[0, 1, 2], [0, 2, 3], [1, 2, 4]])


def test_names_that_are_not_utf8_are_accepted(read):
    text = b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl caf\xe9\nf 1 2 3\n"
    np.testing.assert_array_equal(read("a.obj", text).faces, [[0, 1, 2]])


def test_relative_indices_count_from_the_vertices_defined_so_far(read):
    text = TRIANGLE + "f -3 -2 -1\nv 0 0 1\nf -4 -3 -1\nv 2 2 2\nf 1 -1 2\n"
    np.testing.assert_array_equal(read("a.obj", text).faces, [[0, 1, 2], [0, 1, 3], [0, 4, 1]])


def test_written_indices_begin_at_1(tmp_path, tetrahedron):
    write_mesh(tmp_path / "a.obj", tetrahedron)
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert lines[:2] == ["v 0.0 0.0 0.0", "v 1.0 0.0 0.0"]
    assert lines[4:] == ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("", FormatError, "the file is empty"),
        ("Dear reader,\nthis is a letter.\n", FormatError, "not an OBJ file with geometry"),
        ("v 0 0 0\nv 1 zero 0\n", FormatError, "line 2: three coordinates expected, found '1 zero 0'"),
        ("v 0 0 0\n\nv\nv 1 2 3\n", FormatError, "line 3: three coordinates expected"),
        ("v 0 0 0\nv 1 0\n", FormatError, "line 2: three coordinates"),
        ("v 0 \\\n0 \\\r\n0\nv 1 \\\nx 0\n", FormatError, "line 4: three coordinates expected, found '1  x 0'"),
        (TRIANGLE + "f 1 2 x\n", FormatError, "line 4: 3 vertex indices expected, found '1 2 x'"),
        (TRIANGLE + "f 1 2 2.5\n", FormatError, "line 4: vertex indices must be whole numbers"),
        (TRIANGLE + "f 1 2 nan\n", FormatError, "line 4: vertex indices must be whole numbers"),
        (TRIANGLE + "f 1 2 3\nf 1 2 4\n", MeshError, r"faces 1 .*the file has 3 vertices, numbered 1 to 3"),
        (TRIANGLE + "f 0 1 2\n", MeshError, "faces 0 .*numbered 1 to 3"),
        (TRIANGLE + "f -4 -2 -1\n", MeshError, "faces 0 .*use vertices that do not exist"),
        (TRIANGLE + "f 1 2 3 -4\n", MeshError, "faces 0 .*use vertices that do not exist"),
        (TRIANGLE + "f 1 2 99999999999999999999\n", FormatError, "must be whole"),
        (TRIANGLE + "f 1 2 3\nf 1 2\nf\n", MeshError, r"faces 1, 2 .*fewer than three corners"),
        (TRIANGLE, MeshError, "no faces"),
        ("v 0 0 0\nv nan 0 0\nv 0 inf 0\nf 1 2 3\n", MeshError, "vertices 1, 2 have NaN or infinite"),
        ("v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", MeshError, "vertices 1 have NaN or infinite"),
    ],
)
def test_errors_of_a_mesh_name_the_place(rejects, content, error, message):
    rejects("a.obj", content, error, message)


def test_a_skeleton_is_one_polyline_per_branch(tmp_path, tree):
    write_skeleton(tmp_path / "a.obj", tree)
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert lines[:2] == ["v 0.0 0.0 0.0", "v 1.0 0.0 0.0"]
    assert sorted(lines[6:]) == ["l 1 3", "l 2 3", "l 3 4 5 6"] or sorted(lines[6:]) == ["l 1 3", "l 2 3", "l 6 5 4 3"]


def test_polylines_become_edges(read):
    skeleton = read("a.obj", "v 0 0 0\nv 1 0 0\nl -2 -1\nv 2 0 0\nv 3 0 0\nl 2/1 3/2 4/3\nf 1 2 3\n", read_skeleton)
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2], [2, 3]])
    assert np.isnan(skeleton.radii).all()


def test_consecutive_polylines_are_not_joined(read):
    skeleton = read("a.obj", VERTICES + "l 1 2 3\nl 5 4\n", read_skeleton)
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("l 1 2\n", "no line begins with v"),
        ("v 0 0 0\nv 1 1 1\nl 1 3\n", "name a node outside 0..1"),
        ("v 0 0 0\nv 1 1 1\nl 0 1\n", "name a node outside 0..1"),
        ("v 0 0 0\nv 1 1 1\nl 1 two\n", "line 3: 2 vertex indices expected"),
        ("v 0 0 0\nv 1 1 1\nv 2 2 0\nf 1 2 3\n", "a mesh, not a skeleton"),
    ],
)
def test_errors_of_a_skeleton_name_the_place(rejects, content, message):
    rejects("a.obj", content, FormatError, message, read_skeleton)


def test_a_comment_that_ends_in_a_backslash_does_not_continue(read):
    text = "# C:\\models\\\n" + TRIANGLE + "f 1 \\\n2 \\\n3\\"
    np.testing.assert_array_equal(read("a.obj", text).faces, [[0, 1, 2]])


TEXTURE = "vt 0 0\nvt 0.5 0 0\nvt 0.5 1\nvt 0 1\n"


def textured(folder, text):
    path = folder / "a.obj"
    path.write_text(text)
    return read_mesh(path), lambda mesh: read_obj_texture(path, mesh)


@pytest.mark.parametrize("face", ["f 1/1 2/2/1 3/3 4/4\n", "f -5/-4 -4/-3 -3/-2/7 -2/-1\nvt 7 7\n"])
def test_texture_coordinates_follow_the_corners_of_polygons(tmp_path, face):
    """A square of which the texture has the left half."""
    mesh, read = textured(tmp_path, TEXTURE + VERTICES + face)
    assert len(mesh.faces) == 2
    assert read(mesh) == pytest.approx(mesh.vertices[mesh.faces][:, :, :2] * [0.5, 1.0])


def test_texture_coordinates_that_are_missing_are_told(tmp_path):
    mesh, read = textured(tmp_path, TRIANGLE + "f 1 2 3\n")
    assert read(mesh) is None
    for corner in ("3", "3//1", "3/9", "3/0", "3/x", "3/-9"):
        mesh, read = textured(tmp_path, TEXTURE + TRIANGLE + f"f 1/1 2/2 {corner}\n")
        with pytest.raises(FormatError, match="line 8: a corner has no texture coordinates"):
            read(mesh)
    mesh, read = textured(tmp_path, "vt 1\n" + TRIANGLE + "f 1/1 2/1 3/1\n")
    with pytest.raises(FormatError, match=r"line 1: .*two texture coordinates"):
        read(mesh)
    mesh, read = textured(tmp_path, TEXTURE + TRIANGLE + "f 1/1 2/2 3/3\n")
    with pytest.raises(FormatError, match="not those of the mesh"):
        read(type(mesh)(mesh.vertices, mesh.faces[:, ::-1]))
