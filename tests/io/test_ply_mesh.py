"""Meshes and skeletons as PLY, in every encoding and with elements and properties of other programs."""

import struct

import numpy as np
import pytest

from lbskel.errors import FormatError, MeshError
from lbskel.io import read_skeleton, write_mesh, write_skeleton

VERTEX = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 9 9\n"
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]])


def ply(encoding, declarations, body):
    body = body if isinstance(body, bytes) else body.encode()
    return f"ply\nformat {encoding} 1.0\n{declarations}end_header\n".encode() + body


TEXT = ply("ascii", "comment hello\n" + VERTEX + FACE, ROWS + "4 0 1 2 3\n")

SQUARES = {
    "text": TEXT,
    "line ends of windows": ply("ascii", VERTEX + FACE.replace("indices", "index"), ROWS + "4 0 1 2 3\n").replace(
        b"\n", b"\r\n"
    ),
    "other elements and properties": ply(
        "ascii",
        "element vertex 5\nproperty uchar red\nproperty double z\nproperty double y\nproperty double x\n"
        "element skipped 2\nproperty list uchar float a\nproperty int b\n"
        "element face 1\nproperty list uchar float texcoord\nproperty list uchar uint vertex_indices\n",
        "1 0 0 0\n1 0 0 1\n1 0 1 1\n1 0 1 0\n1 9 9 9\n2 .5 .5 7\n0 7\n2 0.5 0.25 4 0 1 2 3\n",
    ),
    "big endian": ply(
        "binary_big_endian",
        VERTEX + "element face 1\nproperty uchar flag\nproperty list ushort short vertex_indices\nproperty char c\n",
        SQUARE.astype(">f4").tobytes() + struct.pack(">BHhhhhb", 1, 4, 0, 1, 2, 3, -1),
    ),
    "faces before vertices": ply(
        "binary_little_endian",
        "element face 1\nproperty list uint8 int32 vertex_indices\n" + VERTEX.replace("float", "double"),
        struct.pack("<Biiii", 4, 0, 1, 2, 3) + SQUARE.astype("<f8").tobytes(),
    ),
}


@pytest.mark.parametrize("name", SQUARES)
def test_all_vertices_are_kept_in_order_and_polygons_triangulated(read, check_square, name):
    check_square(read("a.ply", SQUARES[name]))


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygons_of_several_sizes(read, check_polygons, encoding):
    polygons = [[0, 1, 2], [0, 1, 2, 3], [3, 0, 1, 2, 4], [2, 1, 0]]
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(encoding)
    if order:
        body = SQUARE.astype(order + "f4").tobytes()
        body += b"".join(struct.pack(f"{order}B{len(p)}iB", len(p), *p, 7) for p in polygons)
    else:
        body = ROWS + "".join(f"{len(p)} {' '.join(map(str, p))} 7\n" for p in polygons)
    declarations = VERTEX + "element face 4\nproperty list uchar int vertex_indices\nproperty uchar red\n"
    check_polygons(read("a.ply", ply(encoding, declarations, body)))


def test_a_written_mesh_is_binary_in_double_precision(tmp_path, tetrahedron):
    write_mesh(tmp_path / "a.ply", tetrahedron)
    header, body = (tmp_path / "a.ply").read_bytes().split(b"end_header\n", 1)
    assert b"format binary_little_endian 1.0\n" in header
    assert b"property double x\n" in header
    assert body[:96] == tetrahedron.vertices.astype("<f8").tobytes()
    assert body[96:] == b"".join(struct.pack("<Biii", 3, *face) for face in tetrahedron.faces)


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        (ply("ascii", VERTEX.replace(" z", " w"), ROWS), FormatError, "properties x, y, z"),
        (ply("ascii", VERTEX.replace("float z", "list int int z"), "0 0 0\n" * 5), FormatError, "x, y, z"),
        (ply("ascii", VERTEX + FACE, ROWS + "-3 0 1 2"), FormatError, "cannot have -3"),
        (ply("ascii", VERTEX + FACE, ROWS + "3 0 1 2.5"), FormatError, "must be whole numbers"),
        (ply("ascii", VERTEX + FACE, ROWS + "3 0 1 5"), MeshError, "faces 0 .*numbered 0 to 4"),
        (ply("ascii", VERTEX + FACE, ROWS + "4 0 1 2 -1"), MeshError, "faces 0 .*do not exist"),
        (ply("ascii", VERTEX, ROWS.replace("9 9 9", "9 nan 9")), MeshError, "faces|vertices 4"),
        (ply("ascii", VERTEX, ROWS), MeshError, "no faces"),
        (ply("ascii", VERTEX.replace("5", "0"), ""), MeshError, "empty"),
        (ply("ascii", VERTEX + FACE.replace("face", "tristrips"), ROWS + "3 0 1 2"), FormatError, "strips"),
        (
            ply("ascii", VERTEX + FACE.replace("vertex_indices", "corners"), ROWS + "3 0 1 2"),
            FormatError,
            "its faces have no list vertex_indices but corners; rename the list",
        ),
    ],
)
def test_errors_of_a_mesh_name_the_place(rejects, content, error, message):
    rejects("a.ply", content, error, message)


def test_a_text_file_without_its_last_number_is_rejected(read):
    for length in range(len(TEXT.rstrip()) - 1):
        with pytest.raises(FormatError):
            read("a.ply", TEXT[:length])


def test_trimesh_reads_a_written_skeleton(tmp_path, skeleton):
    trimesh = pytest.importorskip("trimesh", minversion="5.0")  # earlier versions read no edges from text
    write_skeleton(tmp_path / "a.ply", skeleton)
    raw = trimesh.load(tmp_path / "a.ply").metadata["_ply_raw"]
    np.testing.assert_array_equal(np.ravel(raw["vertex"]["data"]["radius"]), skeleton.radii)
    ends = [np.ravel(raw["edge"]["data"][name]) for name in ("vertex1", "vertex2")]
    np.testing.assert_array_equal(np.stack(ends, axis=1), skeleton.edges)


def test_a_binary_skeleton_without_radii(read):
    declarations = VERTEX.replace("5", "3") + "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
    body = np.arange(9, dtype="<f4").tobytes() + np.array([[0, 1], [1, 2]], dtype="<i4").tobytes()
    skeleton = read("a.ply", ply("binary_little_endian", declarations, body), read_skeleton)
    np.testing.assert_array_equal(skeleton.nodes, np.arange(9).reshape(3, 3))
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2]])
    assert np.isnan(skeleton.radii).all()
    assert skeleton.radius_kind == "inscribed"


SKELETON_VERTEX = VERTEX.replace("5", "2")
EDGE = "element edge 1\nproperty int vertex1\nproperty int vertex2\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"Dear reader,\n", "it must begin with ply"),
        (ply("ascii", SKELETON_VERTEX + EDGE, "0 0 0\n1 1 1\n0 2\n"), "name a node outside 0..1"),
        (ply("ascii", SKELETON_VERTEX + EDGE, "0 0 0\n1 1 1\n0 1.5\n"), "edges must be whole numbers"),
        (
            ply("ascii", SKELETON_VERTEX + EDGE.replace("vertex2", "end"), "0 0 0\n1 1 1\n0 1\n"),
            "properties vertex1, vertex2",
        ),
        (ply("ascii", SKELETON_VERTEX + EDGE, "0 0 0\n1 1 1\n"), "element edge of 1: the header declares more"),
        (ply("ascii", SKELETON_VERTEX.replace("2", "0"), ""), "no nodes"),
        (ply("ascii", SKELETON_VERTEX + FACE.replace("1", "0"), "0 0 0 1 1 1"), "a mesh, not a skeleton"),
    ],
)
def test_errors_of_a_skeleton_name_the_place(rejects, content, message):
    rejects("a.ply", content, FormatError, message, read_skeleton)
