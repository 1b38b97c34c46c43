"""glTF, as trimesh writes it and as other programs do, with everything that must be rejected."""

import base64
import json
import struct

import numpy as np
import pytest

from lbskel.errors import FormatError
from lbskel.io import read_mesh
from lbskel.io.gltf import buffer_files

trimesh = pytest.importorskip("trimesh")

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.fixture
def scene(tetrahedron):
    """A tetrahedron and a square with an unused vertex, each with a transform."""
    scene = trimesh.Scene()
    scene.add_geometry(
        trimesh.Trimesh(tetrahedron.vertices, tetrahedron.faces, process=False),
        transform=trimesh.transformations.translation_matrix([0, 0, 5]),
    )
    scene.add_geometry(trimesh.Trimesh(SQUARE, HALVES, process=False), transform=np.diag([2.0, 1, 1, 1]))
    return scene


@pytest.fixture
def check_scene(tetrahedron):
    def check(mesh):
        # glTF has single precision, in which these whole numbers are exact
        np.testing.assert_array_equal(mesh.vertices[:4], tetrahedron.vertices + np.array([0, 0, 5]))
        np.testing.assert_array_equal(mesh.vertices[4:], SQUARE * [2, 1, 1])
        np.testing.assert_array_equal(mesh.faces, np.concatenate([tetrahedron.faces, HALVES + 4]))
        assert mesh.notes == ("2 meshes of the scene were joined into one",)

    return check


def gltf_with(**changes):
    """A triangle whose positions, primitive or other entries are changed."""
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


def test_glb_joins_the_meshes_of_a_scene(read, scene, check_scene):
    check_scene(read("a.glb", scene.export(file_type="glb")))


def test_gltf_reads_buffers_in_files_and_in_its_text(read, tmp_path, scene, check_scene):
    files = scene.export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    check_scene(read_mesh(tmp_path / "model.gltf"))
    tree = json.loads(files["model.gltf"])
    for buffer in tree["buffers"]:
        (tmp_path / buffer["uri"]).unlink()
    with pytest.raises(FormatError, match=r"its buffer .*: no such file"):
        read_mesh(tmp_path / "model.gltf")
    for buffer in tree["buffers"]:
        content = base64.b64encode(files[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{content}"
    check_scene(read("inside.gltf", json.dumps(tree)))


def test_a_scene_of_one_mesh_has_no_notes(read, tetrahedron):
    mesh = trimesh.Trimesh(tetrahedron.vertices, tetrahedron.faces, process=False)
    assert read("a.glb", mesh.export(file_type="glb")).notes == ()


def test_positions_without_indices(read):
    np.testing.assert_array_equal(read("a.gltf", gltf_with()).faces, [[0, 1, 2]])


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.glb", "Dear reader,\n", "cannot be read as .glb"),
        ("a.gltf", "[]", "has no asset"),
        ("a.gltf", gltf_with(meshes=[], nodes=[]), "cannot be read|no triangles"),
        ("a.gltf", gltf_with(nodes=[{}]), "no triangles"),
        ("a.gltf", gltf_with(primitive={"mode": 0}), "no triangles"),
        ("a.gltf", gltf_with(primitive={"mode": 6}), "triangle fans"),
        ("a.gltf", gltf_with(positions={"sparse": {}}), "save it without sparse accessors"),
        (
            "a.gltf",
            gltf_with(positions={"bufferView": None}, extensionsUsed=["KHR_draco"]),
            "without KHR_draco",
        ),
        ("a.gltf", gltf_with(positions={"componentType": 5122}), "quantized"),
        ("a.gltf", gltf_with(positions={"count": 10**9}), "cannot be read as .gltf"),
        (
            "a.gltf",
            gltf_with(buffers=[{"uri": "../../secret.bin", "byteLength": 36}]),
            "outside of its folder",
        ),
        ("a.gltf", gltf_with(buffers=[{"byteLength": 36}]), "its buffer 0 has no uri; save it as glb"),
        ("a.gltf", gltf_with(buffers=[{"uri": "http://a.b/c.bin", "byteLength": 36}]), "no such file"),
    ],
)
def test_errors_say_what_is_wrong(rejects, name, content, message):
    rejects(name, content, FormatError, message)


def test_indices_of_one_mesh_do_not_reach_into_the_next(rejects):
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
    rejects("a.gltf", text, FormatError, r"vertex indices outside 0\.\.2")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("chunk.glb", struct.pack("<4sIIII", b"glTF", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A) + b"{}" * 400),
        ("count.gltf", gltf_with(positions={"count": 250_000_000})),
        ("nothing.gltf", gltf_with(positions={"count": 250_000_000, "bufferView": None})),
    ],
)
def test_declared_gigabytes_are_not_allocated(read, rejects_without_allocating, name, content):
    read("warm.gltf", gltf_with())  # what trimesh allocates on first use does not count
    rejects_without_allocating(name, content)


def test_buffer_files_are_those_that_the_file_names(tmp_path):
    path = tmp_path / "a b.gltf"
    path.write_text('{"asset": {}, "buffers": [{"uri": "a%20b.bin"}, {"uri": "data:,x"}, {"uri": "c/d.bin"}]}')
    folder = tmp_path.resolve()
    assert buffer_files(path) == [folder / "a b.bin", folder / "c" / "d.bin"]
    path.write_text('{"asset": {}, "buffers": [{}]}')
    assert buffer_files(path) == buffer_files(tmp_path / "none.gltf") == buffer_files(tmp_path / "a.ply") == []
