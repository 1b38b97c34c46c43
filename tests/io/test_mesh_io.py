"""Reading and writing meshes and point clouds: by hand, against trimesh's writers, and every way to go wrong."""

import base64
import json
import os
import struct
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

from lbskel import Mesh, PointCloud
from lbskel.errors import FormatError, MeshError
from lbskel.io import MESH_READERS, MESH_WRITERS, POINT_READERS, as_mesh, read_mesh, read_points, write_mesh
from lbskel.io.off import _plain, off_text
from lbskel.shapes import torus

trimesh = pytest.importorskip("trimesh")

TETRAHEDRON = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]  # the last belongs to no face
HALVES = [[0, 1, 2], [0, 2, 3]]
CUT = ("1 polygons were cut into triangles",)
PLY_VERTEX = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
PLY_ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 9 9\n"


def reads(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_mesh(path)


def ply(encoding, declarations, body):
    return f"ply\nformat {encoding} 1.0\n{declarations}end_header\n".encode() + body


def awkward_mesh():
    """A fan whose coordinates need all 17 digits, with a vertex that no face uses."""
    rng = np.random.default_rng(5)
    vertices = rng.normal(size=(9, 3)) * 10.0 ** rng.integers(-12, 12, size=(9, 1)) / 3
    return Mesh(vertices, [[0, i, i + 1] for i in range(1, 7)])


# What each format can say, by hand

GIVEN = {
    "polygon.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3 4\n",
    "relative.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\nv 9 9 9\n",
    "seams.obj": (
        "mtllib none.mtl\no thing\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\n"
        "usemtl a\nf 1/1/1 2/2/1 3/3/1 4/2/1\nl 1 2\np 5\n"
    ),
    "extras.obj": (
        "# c\r\nv 0 0 0 1 # w\r\nv\t1 0 0 .5 .5 .5\r\nv 1 1 \\\r\n 0\r\nv 0 1e0 0\r\nv 9 9 9\r\nf 1//1 2// 3 4//2\r\n"
    ),
    "plain.off": "OFF\n5 1 0\n" + PLY_ROWS + "4 0 1 2 3\n",
    "comments.off": "# c\n\nOFF # c\n# c\n5 1\n\n" + PLY_ROWS.replace("\n", " # c\n\n") + "4  0 1\t2 3 # c",
    "oneline.off": "OFF 5 1 0\n" + PLY_ROWS + "4 0 1 2 3 1.0 0.5 0 1\n",
    "colors.off": "COFF\n5 1 0\n" + PLY_ROWS.replace("\n", " 255 0 0 255\n") + "4 0 1 2 3 255 0 0\n",
    "normals.off": "NOFF\n5 1 0\n" + PLY_ROWS.replace("\n", " 0 0 1\n") + "4 0 1 2 3\n",
    "texture.off": "STOFF\n5 1 0\n" + PLY_ROWS.replace("\n", " 0.5 0.25\n") + "4 0 1 2 3\n",
    "text.ply": ply(
        "ascii",
        "comment hello\n" + PLY_VERTEX + "element face 1\nproperty list uchar int vertex_indices\n",
        PLY_ROWS.encode() + b"4 0 1 2 3\n",
    ),
    "windows.ply": ply(
        "ascii",
        PLY_VERTEX + "element face 1\nproperty list uchar int vertex_index\n",
        PLY_ROWS.encode() + b"4 0 1 2 3\n",
    ).replace(b"\n", b"\r\n"),
    "lists.ply": ply(
        "ascii",
        "element vertex 5\nproperty uchar red\nproperty double z\nproperty double y\nproperty double x\n"
        "element skipped 2\nproperty list uchar float a\nproperty int b\n"
        "element face 1\nproperty list uchar float texcoord\nproperty list uchar uint vertex_indices\n",
        b"1 0 0 0\n1 0 0 1\n1 0 1 1\n1 0 1 0\n1 9 9 9\n2 .5 .5 7\n0 7\n2 0.5 0.25 4 0 1 2 3\n",
    ),
    "big.ply": ply(
        "binary_big_endian",
        PLY_VERTEX
        + "element face 1\nproperty uchar flag\nproperty list ushort short vertex_indices\nproperty char c\n",
        np.array(SQUARE, dtype=">f4").tobytes() + struct.pack(">BHhhhhb", 1, 4, 0, 1, 2, 3, -1),
    ),
    "little.ply": ply(
        "binary_little_endian",
        "element face 1\nproperty list uint8 int32 vertex_indices\n" + PLY_VERTEX.replace("float", "double"),
        struct.pack("<Biiii", 4, 0, 1, 2, 3) + np.array(SQUARE, dtype="<f8").tobytes(),
    ),
}


@pytest.mark.parametrize("name", GIVEN)
def test_reads_all_vertices_in_order_and_cuts_polygons(tmp_path, name):
    mesh = reads(tmp_path, name, GIVEN[name])
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.faces, HALVES)
    assert mesh.notes == CUT
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int64


MIXED = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 0, 1], [3, 1, 2], [3, 2, 4], [2, 1, 0]]  # of sizes 3, 4, 5 and 3


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygons_of_several_sizes_in_ply(tmp_path, encoding):
    polygons = [[0, 1, 2], [0, 1, 2, 3], [3, 0, 1, 2, 4], [2, 1, 0]]
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(encoding)
    if order:
        body = np.array(SQUARE, dtype=order + "f4").tobytes()
        body += b"".join(struct.pack(f"{order}B{len(p)}iB", len(p), *p, 7) for p in polygons)
    else:
        body = (PLY_ROWS + "".join(f"{len(p)} {' '.join(map(str, p))} 7\n" for p in polygons)).encode()
    declarations = PLY_VERTEX + "element face 4\nproperty list uchar int vertex_indices\nproperty uchar red\n"
    mesh = reads(tmp_path, "a.ply", ply(encoding, declarations, body))
    np.testing.assert_array_equal(mesh.faces, MIXED)
    assert mesh.notes == ("2 polygons were cut into triangles",)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "a.obj",
            "".join(f"v {row}\n" for row in PLY_ROWS.splitlines()) + "f 1 2 3\nf 1 2 3 4\nf 4 1 2 3 5\nf 3 2 1\n",
        ),
        ("a.off", "OFF\n5 4 0\n" + PLY_ROWS + "3 0 1 2\n4 0 1 2 3\n5 3 0 1 2 4\n3 2 1 0\n"),
    ],
)
def test_polygons_of_several_sizes_in_text(tmp_path, name, text):
    np.testing.assert_array_equal(reads(tmp_path, name, text).faces, MIXED)


def test_obj_keeps_the_order_of_faces_across_materials(tmp_path):
    vertices = "".join(f"v {row}\n" for row in PLY_ROWS.splitlines())
    text = vertices + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 2 3 5\n"
    np.testing.assert_array_equal(reads(tmp_path, "a.obj", text).faces, [[0, 1, 2], [0, 2, 3], [1, 2, 4]])


def test_obj_names_that_are_no_utf8_do_no_harm(tmp_path):
    text = b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl caf\xe9\nf 1 2 3\n"
    np.testing.assert_array_equal(reads(tmp_path, "a.obj", text).faces, [[0, 1, 2]])


def soup(mesh):
    return mesh.vertices[mesh.faces].astype(np.float32)


def test_stl_is_merged_at_exactly_equal_positions(tmp_path):
    corners = soup(TETRAHEDRON)
    corners[corners == 0] = np.where(np.arange((corners == 0).sum()) % 2, 0.0, -0.0)  # both zeros are one position
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in corners)
    binary = reads(tmp_path, "a.stl", b"solid but binary".ljust(80) + struct.pack("<I", 4) + rows)
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x} {y} {z}\n" for x, y, z in triangle)
        + " endloop\nendfacet\n"
        for triangle in corners.tolist()
    )
    text = reads(tmp_path, "b.stl", f"solid facet vertex\n{facets}endsolid\nSOLID\r\n{facets.upper()}ENDSOLID\n")
    order = [0, 2, 1, 3]  # of first appearance
    for mesh, times in ((binary, 1), (text, 2)):
        np.testing.assert_array_equal(mesh.vertices, TETRAHEDRON.vertices[order])
        np.testing.assert_array_equal(mesh.faces, np.tile(np.argsort(order)[TETRAHEDRON.faces], (times, 1)))
        assert mesh.notes == (f"{12 * times} corners at 4 exactly equal positions were merged into as many vertices",)
        assert mesh.is_closed_manifold == (times == 1)


# glTF, as trimesh writes it


def scene_of_two():
    scene = trimesh.Scene()
    tetrahedron = trimesh.Trimesh(TETRAHEDRON.vertices, TETRAHEDRON.faces, process=False)
    unused = trimesh.Trimesh(SQUARE, HALVES, process=False)
    scene.add_geometry(tetrahedron, transform=trimesh.transformations.translation_matrix([0, 0, 5]))
    scene.add_geometry(unused, transform=np.diag([2.0, 1, 1, 1]))
    return scene


def check_scene_of_two(mesh):
    # glTF holds single precision, in which these whole numbers are exact
    np.testing.assert_array_equal(mesh.vertices[:4], TETRAHEDRON.vertices + np.array([0, 0, 5]))
    np.testing.assert_array_equal(mesh.vertices[4:], np.array(SQUARE) * [2, 1, 1])
    np.testing.assert_array_equal(mesh.faces, np.concatenate([TETRAHEDRON.faces, np.array(HALVES) + 4]))
    assert mesh.notes == ("2 meshes of the scene were joined into one",)


def test_glb_joins_the_meshes_of_a_scene(tmp_path):
    check_scene_of_two(reads(tmp_path, "a.glb", scene_of_two().export(file_type="glb")))


def test_gltf_reads_buffers_beside_it_and_inside(tmp_path):
    files = scene_of_two().export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    check_scene_of_two(read_mesh(tmp_path / "model.gltf"))
    tree = json.loads(files["model.gltf"])
    for buffer in tree["buffers"]:
        (tmp_path / buffer["uri"]).unlink()
    with pytest.raises(FormatError, match=r"its buffer .*: no such file"):
        read_mesh(tmp_path / "model.gltf")
    for buffer in tree["buffers"]:
        content = base64.b64encode(files[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{content}"
    check_scene_of_two(reads(tmp_path, "inside.gltf", json.dumps(tree)))


def test_glb_of_one_mesh_says_nothing(tmp_path):
    mesh = trimesh.Trimesh(TETRAHEDRON.vertices, TETRAHEDRON.faces, process=False)
    assert reads(tmp_path, "a.glb", mesh.export(file_type="glb")).notes == ()


def gltf_with(**changes):
    """A triangle whose accessors are changed."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes()
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"
    positions = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", **changes.pop("positions", {})}
    primitive = {"attributes": {"POSITION": 0}, **changes.pop("primitive", {})}
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{key: value for key, value in positions.items() if value is not None}],
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        **changes,
    }
    return json.dumps(tree)


def test_gltf_without_indices(tmp_path):
    np.testing.assert_array_equal(reads(tmp_path, "a.gltf", gltf_with()).faces, [[0, 1, 2]])


# Round trips and other writers


@pytest.mark.parametrize("name", [name for name in MESH_WRITERS if name != "stl"])
def test_round_trip_to_the_last_bit(tmp_path, name):
    mesh = awkward_mesh()
    write_mesh(tmp_path / f"a.{name}", mesh)
    back = read_mesh(tmp_path / f"a.{name}")
    np.testing.assert_array_equal(back.vertices, mesh.vertices)
    np.testing.assert_array_equal(back.faces, mesh.faces)
    assert back.notes == ()


def test_stl_round_trip_keeps_single_precision(tmp_path):
    mesh = awkward_mesh()
    write_mesh(tmp_path / "a.stl", mesh)
    back = read_mesh(tmp_path / "a.stl")
    np.testing.assert_array_equal(soup(back), soup(mesh))


@pytest.mark.parametrize("name", MESH_WRITERS)
def test_trimesh_reads_what_is_written(tmp_path, name):
    write_mesh(tmp_path / f"a.{name}", TETRAHEDRON)
    other = trimesh.load(tmp_path / f"a.{name}", process=False)
    np.testing.assert_array_equal(soup(other), soup(TETRAHEDRON))
    # of unit normals in single precision
    np.testing.assert_allclose(np.linalg.norm(other.face_normals, axis=1), 1, rtol=1e-6)


@pytest.mark.parametrize("name", ["obj", "off", "ply", "stl"])
def test_reads_what_trimesh_writes(tmp_path, name):
    other = trimesh.Trimesh(TETRAHEDRON.vertices, TETRAHEDRON.faces, process=False)
    exported = other.export(file_type=name)
    back = reads(tmp_path, f"a.{name}", exported)
    np.testing.assert_array_equal(soup(back), soup(TETRAHEDRON))


def test_write_refuses_what_stl_cannot_hold_and_writes_degenerate_faces(tmp_path):
    with pytest.raises(FormatError, match=r"a\.stl: coordinates beyond the single precision of STL"):
        write_mesh(tmp_path / "a.stl", Mesh([[0, 0, 0], [1e39, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    assert not (tmp_path / "a.stl").exists()
    write_mesh(tmp_path / "a.stl", Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 1]]))
    assert read_mesh(tmp_path / "a.stl").faces.tolist() == [[0, 1, 1]]


def test_write_refuses_what_exists(tmp_path):
    write_mesh(tmp_path / "a.off", TETRAHEDRON)
    with pytest.raises(FormatError, match="exists already"):
        write_mesh(tmp_path / "a.off", TETRAHEDRON)
    write_mesh(tmp_path / "a.off", awkward_mesh(), force=True)
    assert len(read_mesh(tmp_path / "a.off").vertices) == 9
    with pytest.raises(FormatError, match="unknown extension 'glb'; known for meshes: obj, off, ply, stl"):
        write_mesh(tmp_path / "a.glb", TETRAHEDRON)


# Point clouds


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.xyz", "# c\n0 0 0\n1\t0 0\n\n1 1 0\n0 1 0\n9 9 9"),
        ("a.xyz", PLY_ROWS.replace(" ", ", ")),
        ("a.xyz", PLY_ROWS.replace("\n", " 0.1 0.2 0.3\n")),
        ("a.off", "OFF\n5 0 0\n" + PLY_ROWS),
        ("a.off", "NOFF\n5 0\n" + PLY_ROWS.replace("\n", "\t0 0 1\n")),
        ("a.off", GIVEN["plain.off"]),
        ("a.ply", ply("ascii", PLY_VERTEX, PLY_ROWS.encode())),
        ("a.ply", GIVEN["big.ply"]),
    ],
)
def test_reads_points(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    cloud = read_points(path)
    assert isinstance(cloud, PointCloud)
    np.testing.assert_array_equal(cloud.points, SQUARE)


@pytest.mark.parametrize(
    ("name", "content", "error", "message"),
    [
        ("a.xyz", "1 2 3\n1 2\n", FormatError, "line 2: three coordinates expected, found '1 2'"),
        ("a.xyz", "# nothing\n", FormatError, "holds no points"),
        ("a.xyz", "1 2 3\n1 nan 3\n", MeshError, "vertices? 1|points 1"),
        ("a.off", "OFF\n0 0 0\n", MeshError, "empty"),
        ("a.pcd", "1 2 3\n", FormatError, "unknown extension 'pcd'; known for point clouds: xyz, ply, off"),
    ],
)
def test_points_that_are_none(tmp_path, name, content, error, message):
    (tmp_path / name).write_text(content)
    with pytest.raises(error, match=message):
        read_points(tmp_path / name)


# Every way to go wrong

TRIANGLE_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
TRIANGLE_OFF = "0 0 0\n1 0 0\n0 1 0\n"
FACET = "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"

WRONG = [
    ("a.obj", "", FormatError, "the file is empty"),
    ("a.obj", "Dear reader,\nthis is a letter.\n", FormatError, "not an OBJ file of a shape"),
    ("a.obj", "v 0 0 0\nv 1 zero 0\n", FormatError, "line 2: three coordinates expected, found '1 zero 0'"),
    ("a.obj", "v 0 0 0\n\nv\nv 1 2 3\n", FormatError, "line 3: three coordinates expected"),
    ("a.obj", "v 0 0 0\nv 1 0\n", FormatError, "line 2: three coordinates"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 x\n", FormatError, "line 4: 3 vertex indices expected, found '1 2 x'"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 2.5\n", FormatError, "line 4: vertex indices must be whole numbers"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 nan\n", FormatError, "line 4: vertex indices must be whole numbers"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 3\nf 1 2 4\n", MeshError, r"faces 1 .*the file has 3 vertices, numbered 1 to 3"),
    ("a.obj", TRIANGLE_OBJ + "f 0 1 2\n", MeshError, "faces 0 .*numbered 1 to 3"),
    ("a.obj", TRIANGLE_OBJ + "f -4 -2 -1\n", MeshError, "faces 0 .*name vertices that do not exist"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 3 -4\n", MeshError, "faces 0 .*name vertices that do not exist"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 99999999999999999999\n", FormatError, "must be whole"),
    ("a.obj", TRIANGLE_OBJ + "f 1 2 3\nf 1 2\nf\n", MeshError, r"faces 1, 2 .*fewer than three corners"),
    ("a.obj", TRIANGLE_OBJ, MeshError, "no faces"),
    ("a.obj", "v 0 0 0\nv nan 0 0\nv 0 inf 0\nf 1 2 3\n", MeshError, "vertices 1, 2 have NaN or infinite"),
    ("a.obj", "v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", MeshError, "vertices 1 have NaN or infinite"),
    ("a.off", "", FormatError, "the file is empty"),
    ("a.off", "# nothing\n", FormatError, "it must begin with OFF"),
    ("a.off", "v 0 0 0\n", FormatError, "it must begin with OFF"),
    ("a.off", "4OFF\n1 0 0\n0 0 0 0\n", FormatError, "four or more dimensions"),
    ("a.off", "OFF BINARY\n\x00\x00", FormatError, "binary OFF is not read"),
    ("a.off", "OFF\n", FormatError, "ends after its header"),
    ("a.off", "OFF\nmany\n", FormatError, "line 2: counts of vertices and faces expected, found 'many'"),
    ("a.off", "OFF\n3 1.5 0\n" + TRIANGLE_OFF, FormatError, "line 2: counts must be whole"),
    ("a.off", "OFF\n-3 1 0\n" + TRIANGLE_OFF, FormatError, "line 2: promises -3 vertices"),
    (
        "a.off",
        "OFF\n3 1 0\n" + TRIANGLE_OFF,
        FormatError,
        "line 2: promises 3 vertices and 1 faces, but 3 lines follow",
    ),
    ("a.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", FormatError, "line 4: three coordinates expected"),
    (
        "a.off",
        "OFF\n3 1 0\n" + TRIANGLE_OFF + "3 0 1\n",
        FormatError,
        "line 6: 3 vertex indices expected, found '3 0 1'",
    ),
    ("a.off", "OFF\n3 1 0\n" + TRIANGLE_OFF + "3000000000 0 1\n", FormatError, "line 6: holds no 3000000000"),
    ("a.off", "OFF\n3 1 0\n" + TRIANGLE_OFF + "-3 0 1\n", FormatError, "line 6: holds no -3"),
    ("a.off", "OFF\n3 1 0\n" + TRIANGLE_OFF + "3 0 1 3\n", MeshError, "faces 0 .*numbered 0 to 2"),
    ("a.off", "OFF\n3 1 0\n" + TRIANGLE_OFF + "4 0 1 2 -1\n", MeshError, "faces 0 .*name vertices that do not exist"),
    ("a.off", "OFF\n3 1 0\n" + TRIANGLE_OFF + "2 0 1\n", MeshError, "faces 0 .*fewer than three corners"),
    ("a.off", "OFF\n3 0 0\n" + TRIANGLE_OFF, MeshError, "no faces"),
    ("a.ply", "OFF\n", FormatError, "it must begin with ply"),
    ("a.ply", "ply\nformat ascii 1.0\n", FormatError, "no end_header"),
    ("a.ply", ply("ebcdic", "", b""), FormatError, "line 2: not a line of a PLY header"),
    ("a.ply", b"ply\nelement vertex 1\nend_header\n", FormatError, "names no format"),
    ("a.ply", ply("ascii", "element vertex -1\n", b""), FormatError, "line 3: not a line"),
    ("a.ply", ply("ascii", "property float x\n", b""), FormatError, "line 3: not a line"),
    ("a.ply", ply("ascii", "element vertex 1\nproperty quad x\n", b""), FormatError, "line 4: not a line"),
    ("a.ply", ply("ascii", PLY_VERTEX.replace(" z", " w"), PLY_ROWS.encode()), FormatError, "properties x, y, z"),
    ("a.ply", ply("ascii", PLY_VERTEX.replace("float z", "list int int z"), b"0 0 0\n" * 5), FormatError, "x, y, z"),
    ("a.ply", ply("ascii", PLY_VERTEX, b"0 0 0\n1 nought 0\n"), FormatError, "line 9: 'nought' is no number"),
    ("a.ply", ply("ascii", PLY_VERTEX, b"1 2 3 4"), FormatError, "element vertex of 5: more is promised"),
    ("a.ply", ply("ascii", "element a 1\nproperty int b\n", b" \n"), FormatError, "element a of 1: more is promised"),
    ("a.ply", ply("ascii", PLY_VERTEX + FACE, PLY_ROWS.encode() + b"-3 0 1 2"), FormatError, "cannot hold -3"),
    ("a.ply", ply("ascii", PLY_VERTEX + FACE, PLY_ROWS.encode() + b"3 0 1 2.5"), FormatError, "must be whole numbers"),
    ("a.ply", ply("ascii", PLY_VERTEX + FACE, PLY_ROWS.encode() + b"3 0 1 5"), MeshError, "faces 0 .*numbered 0 to 4"),
    ("a.ply", ply("ascii", PLY_VERTEX + FACE, PLY_ROWS.encode() + b"4 0 1 2 -1"), MeshError, "faces 0 .*do not exist"),
    ("a.ply", ply("ascii", PLY_VERTEX, PLY_ROWS.replace("9 9 9", "9 nan 9").encode()), MeshError, "faces|vertices 4"),
    ("a.ply", ply("ascii", PLY_VERTEX, PLY_ROWS.encode()), MeshError, "no faces"),
    ("a.ply", ply("ascii", PLY_VERTEX.replace("5", "0"), b""), MeshError, "empty"),
    (
        "a.ply",
        ply("ascii", PLY_VERTEX + FACE.replace("face", "tristrips"), PLY_ROWS.encode() + b"3 0 1 2"),
        FormatError,
        "strips",
    ),
    ("a.stl", "Dear reader,\n", FormatError, "neither STL text, which begins with solid, nor binary"),
    ("a.stl", b"\0" * 84, FormatError, "promises 0 triangles"),
    ("a.stl", "solid\nendsolid\n", MeshError, "empty"),
    ("a.stl", FACET.removesuffix("endsolid"), FormatError, "ends at line 8 without endsolid"),
    (
        "a.stl",
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
        FormatError,
        "line 6: vertex expected",
    ),
    ("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", FormatError, "ends at line 4 without endsolid"),
    (
        "a.stl",
        FACET.replace("0 1 0", "0 1"),
        FormatError,
        "line 6: vertex and three coordinates expected, found 'vertex 0 1'",
    ),
    (
        "a.stl",
        FACET.replace("1 0 0", "1 0 nan"),
        MeshError,
        "vertices 1 have NaN",
    ),
    ("a.glb", "Dear reader,\n", FormatError, "not readable as .glb"),
    ("a.gltf", "[]", FormatError, "has no asset"),
    ("a.gltf", gltf_with(meshes=[], nodes=[]), FormatError, "not readable|no triangles"),
    ("a.gltf", gltf_with(nodes=[{}]), FormatError, "no triangles"),
    ("a.gltf", gltf_with(primitive={"mode": 0}), FormatError, "no triangles"),
    ("a.gltf", gltf_with(primitive={"mode": 6}), FormatError, "triangle fans"),
    ("a.gltf", gltf_with(positions={"sparse": {}}), FormatError, "save it without sparse accessors"),
    (
        "a.gltf",
        gltf_with(positions={"bufferView": None}, extensionsUsed=["KHR_draco"]),
        FormatError,
        "without KHR_draco",
    ),
    ("a.gltf", gltf_with(positions={"componentType": 5122}), FormatError, "quantized"),
    ("a.gltf", gltf_with(positions={"count": 10**9}), FormatError, "not readable as .gltf"),
    (
        "a.gltf",
        gltf_with(buffers=[{"uri": "../../secret.bin", "byteLength": 36}]),
        FormatError,
        "outside of its folder",
    ),
    ("a.gltf", gltf_with(buffers=[{"uri": "http://a.b/c.bin", "byteLength": 36}]), FormatError, "no such file"),
]


@pytest.mark.parametrize(("name", "content", "error", "message"), WRONG)
def test_says_what_is_wrong_and_where(tmp_path, name, content, error, message):
    with pytest.raises(error, match=message) as raised:
        reads(tmp_path, name, content)
    assert type(raised.value) is error
    assert str(raised.value).startswith(str(tmp_path / name))


def test_indices_of_one_gltf_mesh_do_not_reach_into_the_next(tmp_path):
    data = np.array([0, 1, 3], dtype="<u2").tobytes().ljust(8, b"\0") + np.zeros((3, 3), dtype="<f4").tobytes()
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"
    views = [{"buffer": 0, "byteLength": 6}, {"buffer": 0, "byteOffset": 8, "byteLength": 36}]
    accessors = [
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 0, "componentType": 5123, "count": 3, "type": "SCALAR"},
    ]
    text = gltf_with(
        buffers=[{"uri": uri, "byteLength": 44}],
        bufferViews=views,
        accessors=accessors,
        primitive={"indices": 1},
        nodes=[{"mesh": 0}, {"mesh": 0}],
        scenes=[{"nodes": [0, 1]}],
    )
    with pytest.raises(FormatError, match="name vertices outside of its 3"):
        reads(tmp_path, "a.gltf", text)


def test_names_that_are_no_mesh_files(tmp_path):
    with pytest.raises(
        FormatError, match=r"a\.xml: unknown extension 'xml'; known for meshes: obj, off, ply, stl, glb, gltf"
    ):
        read_mesh(tmp_path / "a.xml")
    with pytest.raises(FormatError, match="no extension; known for meshes"):
        read_mesh("mesh")
    with pytest.raises(FormatError, match="is a folder"):
        read_mesh(tmp_path)
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(FormatError, match="is a folder, not a file"):
        read_mesh(tmp_path / "folder.obj")
    for name in ("missing.obj", "MISSING.OBJ", "folder.obj/a.stl"):
        with pytest.raises(FormatError, match=r"no such file|cannot be read"):
            read_mesh(tmp_path / name)
    with pytest.raises(FormatError, match=r"not readable|cannot be read"):
        read_mesh("a\0.obj")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_does_not_block(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(FormatError, match="not a regular file"):
        read_mesh(tmp_path / "a.obj")


@pytest.mark.parametrize("name", ["ply", "stl", "glb"])
def test_a_binary_file_cut_anywhere_is_refused(tmp_path, name):
    other = trimesh.Trimesh(TETRAHEDRON.vertices, TETRAHEDRON.faces, process=False)
    whole = other.export(file_type=name)
    for length in range(len(whole)):
        with pytest.raises(FormatError):
            reads(tmp_path, f"a.{name}", whole[:length])


@pytest.mark.parametrize("name", ["text.ply", "plain.off"])
def test_a_text_file_that_lacks_its_last_number_is_refused(tmp_path, name):
    content = GIVEN[name]
    whole = content if isinstance(content, bytes) else content.encode()
    for length in range(len(whole.rstrip()) - 1):
        with pytest.raises(FormatError):
            reads(tmp_path, name, whole[:length])


HUGE = {
    "vertices.ply": ply("binary_little_endian", PLY_VERTEX.replace("5", "300000000"), bytes(1000)),
    "list.ply": ply("binary_little_endian", FACE, b"\xff" + bytes(100)),
    "list32.ply": ply("binary_little_endian", FACE.replace("uchar", "uint"), b"\xff\xff\xff\xff" + bytes(100)),
    "rows.ply": ply("binary_little_endian", FACE.replace("1", "4000000000"), bytes(1000)),
    "text.ply": ply("ascii", PLY_VERTEX.replace("5", "300000000"), b"1 2 3\n"),
    "a.stl": bytes(80) + struct.pack("<I", 60_000_000) + bytes(1000),
    "a.off": "OFF\n130000000 10 0\n0 0 0\n",
    "chunk.glb": struct.pack("<4sIIII", b"glTF", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A) + b"{}" * 400,
    "count.gltf": gltf_with(positions={"count": 250_000_000}),
    "nothing.gltf": gltf_with(positions={"count": 250_000_000, "bufferView": None}),
}


@pytest.mark.parametrize("name", HUGE)
def test_a_promise_of_gigabytes_fails_without_allocating_them(tmp_path, name):
    reads(tmp_path, "warm.gltf", gltf_with())  # what trimesh allocates when it is first used is not the file's doing
    tracemalloc.start()
    try:
        with pytest.raises(FormatError):
            reads(tmp_path, name, HUGE[name])
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2_000_000  # bytes; each of the files promises a gigabyte or more and holds about a thousand bytes


def test_nothing_is_printed(tmp_path, capfd):
    for name, content in GIVEN.items():
        reads(tmp_path, name, content)
    for name, content, error, _ in WRONG:
        with pytest.raises(error):
            reads(tmp_path, name, content)
    assert capfd.readouterr() == ("", "")


# What users have


def test_as_mesh_takes_paths_and_all_else(tmp_path):
    path = tmp_path / "a.off"
    write_mesh(path, TETRAHEDRON)
    for data in (str(path), path, TETRAHEDRON, (TETRAHEDRON.vertices, TETRAHEDRON.faces)):
        np.testing.assert_array_equal(as_mesh(data).faces, TETRAHEDRON.faces)
    assert as_mesh(TETRAHEDRON) is TETRAHEDRON
    with pytest.raises(FormatError, match="no such file"):
        as_mesh(tmp_path / "b.off")
    with pytest.raises(FormatError, match="square: no extension; known for meshes"):
        as_mesh("square")
    with pytest.raises(MeshError):
        as_mesh(17)


def test_write_mesh_takes_whatever_as_mesh_takes(tmp_path):
    pair, copy = tmp_path / "pair.off", tmp_path / "copy.obj"
    write_mesh(pair, (TETRAHEDRON.vertices, TETRAHEDRON.faces.tolist()))
    write_mesh(copy, pair)
    np.testing.assert_array_equal(read_mesh(copy).faces, TETRAHEDRON.faces)
    with pytest.raises(MeshError):
        write_mesh(tmp_path / "none.off", 17)


@pytest.mark.parametrize("written", ["OFF\n{}", "\n OFF {}", "off\n\n{}"])
def test_plain_triangles_are_read_at_once_and_as_line_by_line(tmp_path, written):
    text = off_text(torus(1.0, 0.3, 12, 8)).removeprefix("OFF\n")
    plain, more = tmp_path / "plain.off", tmp_path / "more.off"
    plain.write_text(written.format(text))
    more.write_text(f"OFF # a comment\n{text}")
    assert _plain(plain.read_bytes()) is not None
    assert _plain(more.read_bytes()) is None
    at_once, by_lines = read_mesh(plain), read_mesh(more)
    np.testing.assert_array_equal(at_once.vertices, by_lines.vertices)
    np.testing.assert_array_equal(at_once.faces, by_lines.faces)


@pytest.mark.parametrize("fault", ["3 0 1 9.5", "3 0 1", "3 0 1 x", "4 0 1 2 3", "2 0 1 2", "3 0 1 1e300"])
def test_what_is_not_plain_is_left_to_the_careful_reader(fault):
    assert _plain(f"OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n{fault}\n".encode()) is None


def test_extensions_in_capitals(tmp_path):
    write_mesh(tmp_path / "A.OBJ", TETRAHEDRON)
    assert len(read_mesh(tmp_path / "A.OBJ").vertices) == 4


def test_every_written_format_is_read():
    assert set(MESH_WRITERS) <= set(MESH_READERS)
    assert set(POINT_READERS) == {"xyz", "ply", "off"}


def test_importing_is_light():
    code = "import sys, lbskel.io; print([n for n in ('trimesh', 'networkx', 'vtkmodules') if n in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
