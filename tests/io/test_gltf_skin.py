"""Rigs as glTF: read again by trimesh and as JSON; skinned by the file's own numbers."""

import json
import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel import FormatError, MeshError, Rig, UnknownChoice, read_mesh, write_rig
from lbskel.io.gltf_skin import encode_rig
from lbskel.shapes import tube


@pytest.fixture(scope="module")
def arm():
    """A tube along z with six bones, all of which the vertices follow a little."""
    mesh = tube(np.stack([*np.zeros((2, 13)), np.linspace(0, 6, 13)], axis=1), 0.5, sides=8)
    ends = np.stack([*np.zeros((2, 7)), np.arange(7.0)], axis=1)
    near = np.exp(-((mesh.vertices[:, 2:] - np.arange(6) - 0.5) ** 2))
    names = tuple(f"bone_{k}" for k in range(6))
    return Rig(mesh, names, ends[:-1], ends[1:], np.arange(-1, 5), near / near.sum(axis=1, keepdims=True))


def parsed(data):
    """The JSON of a glb, and its accessors as arrays."""
    magic, version, length, size, kind = struct.unpack("<IIIII", data[:20])
    assert (magic, version, length, kind) == (0x46546C67, 2, len(data), 0x4E4F534A)
    document, binary = json.loads(data[20 : 20 + size]), data[28 + size :]
    types = {5126: "<f4", 5123: "<u2", 5125: "<u4"}
    widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
    arrays = []
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        raw = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        arrays.append(np.frombuffer(raw, types[accessor["componentType"]]).reshape(-1, widths[accessor["type"]]))
    return document, arrays


def skinned(data, turns):
    """Positions by the file's numbers alone, with rotations of bones by name."""
    document, arrays = parsed(data)
    primitive = document["meshes"][0]["primitives"][0]["attributes"]
    positions = np.column_stack([arrays[primitive["POSITION"]], np.ones(len(arrays[primitive["POSITION"]]))])
    world = {}

    def visit(number, above):
        node, local = document["nodes"][number], np.eye(4)
        local[:3, 3] = node.get("translation", [0, 0, 0])
        local[:3, :3] = turns.get(node["name"], np.eye(3))
        world[number] = above @ local
        for child in node.get("children", []):
            visit(child, world[number])

    for number in document["scenes"][0]["nodes"]:
        visit(number, np.eye(4))
    skin = document["skins"][0]
    bind = arrays[skin["inverseBindMatrices"]].reshape(-1, 4, 4).transpose(0, 2, 1)
    moves = np.array([world[joint] @ own for joint, own in zip(skin["joints"], bind, strict=True)])
    total, sums = np.zeros((len(positions), 3)), np.zeros((len(positions), 1))
    for number in range(sum(name.startswith("JOINTS") for name in primitive)):
        joints, weights = arrays[primitive[f"JOINTS_{number}"]], arrays[primitive[f"WEIGHTS_{number}"]]
        total += np.einsum("nk,nkxy,ny->nx", weights, moves[joints], positions)[:, :3]
        sums += weights.sum(axis=1, dtype=np.float64, keepdims=True)
    return total / sums  # single precision leaves 1e-7, as much as 0.1 far from the origin


def test_the_file_moves_as_the_rig(arm):
    turns = {
        "bone_2": Rotation.from_euler("x", 50, degrees=True).as_matrix(),
        "bone_4": Rotation.from_rotvec([1.0, 2.0, 0.5]).as_matrix(),
    }
    data = encode_rig(arm)
    assert skinned(data, {}) == pytest.approx(arm.mesh.vertices, abs=1e-5)  # single precision of lengths of 6
    assert skinned(data, turns) == pytest.approx(arm.posed(turns).vertices, abs=1e-5)


@pytest.mark.parametrize("up", ["y", "z"])
def test_a_rig_far_from_the_origin_keeps_its_shape(arm, tmp_path, up):
    """At 1e6 single precision has steps of 1/16; the file's own numbers are exact where they are added in double."""
    away = np.array([1e6, -2e6, 5e5])
    far = Rig(
        arm.mesh.with_vertices(arm.mesh.vertices + away), arm.names, arm.heads + away, arm.tails + away, arm.parents,
        arm.weights,
    )  # fmt: skip
    turns = {"bone_2": Rotation.from_euler("x", 50, degrees=True).as_matrix()}
    turned = away if up == "y" else away[[0, 2, 1]] * [1, 1, -1]
    for pose in (turns, {}):
        assert skinned(encode_rig(far, up=up), pose) - turned == pytest.approx(
            skinned(encode_rig(arm, up=up), pose), abs=1e-5
        )
    write_rig(tmp_path / "far.glb", far, up=up)
    read = read_mesh(tmp_path / "far.glb").vertices - turned  # by trimesh, which knows no skins
    assert read == pytest.approx(skinned(encode_rig(arm, up=up), {}), abs=1e-5)


def test_z_up_is_turned_to_y_up(arm):
    turned = skinned(encode_rig(arm, up="z"), {})
    assert turned == pytest.approx(arm.mesh.vertices[:, [0, 2, 1]] * [1, 1, -1], abs=1e-5)


def test_weights_sum_to_one_and_joints_without_weight_are_zero(arm):
    document, arrays = parsed(encode_rig(arm))
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    weights = np.concatenate([arrays[attributes[f"WEIGHTS_{k}"]] for k in (0, 1)], axis=1)
    joints = np.concatenate([arrays[attributes[f"JOINTS_{k}"]] for k in (0, 1)], axis=1)
    assert weights.sum(axis=1, dtype=np.float64) == pytest.approx(1, abs=1e-6)
    assert (joints[weights == 0] == 0).all()
    assert [node["name"] for node in document["nodes"]] == [*arm.names, "armature", "mesh"]


def test_trimesh_and_lbskel_read_the_mesh(arm, tmp_path):
    import trimesh

    write_rig(tmp_path / "arm.glb", arm)
    assert len(trimesh.load(tmp_path / "arm.glb", force="mesh").faces) == len(arm.mesh.faces)
    assert read_mesh(tmp_path / "arm.glb").vertices == pytest.approx(arm.mesh.vertices, abs=1e-6)


def test_what_cannot_be_written_is_an_error(arm, tmp_path):
    with pytest.raises(FormatError, match=r"must end in \.glb"):
        write_rig(tmp_path / "arm.fbx", arm)
    with pytest.raises(UnknownChoice, match="y, z"):
        write_rig(tmp_path / "arm.glb", arm, up="x")
    huge = Rig(
        arm.mesh.with_vertices(1e40 * arm.mesh.vertices), arm.names, arm.heads, arm.tails, arm.parents, arm.weights
    )
    with pytest.raises(FormatError, match="scale the mesh"):
        write_rig(tmp_path / "arm.glb", huge)
    assert list(tmp_path.iterdir()) == []


def test_vertices_at_seams_of_the_texture_are_written_once_for_each_place_in_it(arm):
    faces = arm.mesh.faces
    texture = np.round(arm.mesh.vertices[faces][:, :, [0, 2]], 1)
    texture[: len(faces) // 2, :, 0] += 10.0  # a seam
    document, arrays = parsed(encode_rig(arm, texture=texture))
    primitive = document["meshes"][0]["primitives"][0]
    position, pair, joints, weights = (
        arrays[primitive["attributes"][name]] for name in ("POSITION", "TEXCOORD_0", "JOINTS_0", "WEIGHTS_0")
    )
    corners = arrays[primitive["indices"]].reshape(-1, 3)
    assert len(arm.mesh.vertices) < len(position) == len(pair) < 2 * len(arm.mesh.vertices)
    assert position[corners] == pytest.approx(arm.mesh.vertices[faces], abs=1e-6)
    assert pair[corners] == pytest.approx(np.stack([texture[..., 0], 1 - texture[..., 1]], axis=2), abs=1e-5)
    plain, without = parsed(encode_rig(arm))
    names = plain["meshes"][0]["primitives"][0]["attributes"]
    assert "TEXCOORD_0" not in names
    assert (joints[corners] == without[names["JOINTS_0"]][faces]).all()
    assert (weights[corners] == without[names["WEIGHTS_0"]][faces]).all()


@pytest.mark.parametrize("texture", [np.zeros((4, 3, 2)), "nan"])
def test_texture_coordinates_of_another_shape_or_not_finite_are_refused(arm, texture):
    texture = np.full((*arm.mesh.faces.shape, 2), np.nan) if isinstance(texture, str) else texture
    with pytest.raises(MeshError, match=rf"a finite pair for each corner, shape \({len(arm.mesh.faces)}, 3, 2\)"):
        encode_rig(arm, texture=texture)
