"""A rig as binary glTF 2.0 (glb): a skinned mesh with y up, in its rest pose as given, and a node for each bone.

A node stands at the head of its bone, without a rotation; the inverse bind matrix moves the head to the origin. All
root bones are children of one node, ``armature``. Positions and weights are in single precision; weights come in fours.
A rig far from the origin has its positions relative to its middle, where ``armature`` and the mesh then stand.
Format: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html, sections 3.7.3 and 4.4 (the numbers below).
"""

from __future__ import annotations

__all__ = ["UP_AXES", "encode_rig", "write_rig"]

import json
import os
import struct
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, MeshError, choose
from lbskel.geometry.mesh import Mesh
from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.armature import Rig

# For the axis of the mesh that points up, the rotation of its coordinates to those of glTF, where y points up.
UP_AXES: dict[str, NDArray[np.float64]] = {
    "y": np.eye(3),
    "z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}
FLOAT, UINT16, UINT32 = 5126, 5123, 5125  # componentType
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963  # bufferView.target
GLTF_MAGIC, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
SET_SIZE = 4  # joints and weights in an attribute
FAR = 100  # largest coordinate, in diagonals, up to which single precision keeps 1e-5 of the diagonal
LARGEST = 1e30  # of a coordinate: its square is finite in single precision only below 1.8e19, but files hold the value


def write_rig(
    path: str | os.PathLike[str], rig: Rig, *, up: str = "y", texture: Any = None, force: bool = False
) -> None:
    """Write a rig as binary glTF 2.0.

    Parameters
    ----------
    path : path-like
        With the extension glb.
    rig : Rig
    up : str
        The axis of the mesh that points up, ``y`` or ``z``; in glTF it is y. The mesh is turned, not scaled.
    texture : (m, 3, 2) array_like of float, optional
        Texture coordinates of the corners of each face: u, and v, which grows upwards. A vertex with several is written
        several times. Images and materials are not written.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    MeshError
        If there is not one finite pair of texture coordinates for each corner.
    FormatError
        If the extension is another, a coordinate is too large for single precision, or the file exists or cannot be
        written.
    UnknownChoice
        If ``up`` is another axis.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(3.0, 0.4, 10)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lbskel.write_rig(Path(folder) / "rod.glb", lbskel.rig(rod, lbskel.skeletonize(rod)), up="z")
    ...     (Path(folder) / "rod.glb").read_bytes()[:4]
    b'glTF'
    """
    if not os.fspath(path).lower().endswith(".glb"):
        raise FormatError(f"{path}: the name must end in .glb")
    write_safely(path, encode_rig(rig, up=up, texture=texture), force)


def encode_rig(rig: Rig, *, up: str = "y", texture: Any = None) -> bytes:
    """Encode a rig as :func:`write_rig` writes it."""
    turn = choose(UP_AXES, up, "axis that points up")
    vertices, heads = rig.mesh.vertices @ turn.T, rig.heads @ turn.T
    if np.abs(vertices).max() > LARGEST:
        raise FormatError("coordinates are too large for glTF's single precision: scale the mesh first")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    is_far = max(np.abs(low).max(), np.abs(high).max()) > FAR * np.linalg.norm(high - low)
    place = {"translation": ((low + high) / 2).tolist()} if is_far else {}
    if is_far:
        vertices, heads = (points - place["translation"] for points in (vertices, heads))
    file = _File()
    row, corners, pairs = _split(rig.mesh, texture)
    attributes = {"POSITION": file.add(vertices[row].astype(np.float32), "VEC3", ARRAY_BUFFER, bounds=True)}
    attributes["NORMAL"] = file.add(_normals(rig, turn)[row], "VEC3", ARRAY_BUFFER)
    if texture is not None:
        attributes["TEXCOORD_0"] = file.add(pairs, "VEC2", ARRAY_BUFFER)
    for number, (joints, weights) in enumerate(_influences(rig.weights[row])):
        attributes[f"JOINTS_{number}"] = file.add(joints, "VEC4", ARRAY_BUFFER)
        attributes[f"WEIGHTS_{number}"] = file.add(weights, "VEC4", ARRAY_BUFFER)
    indices = file.add(corners.astype(np.uint32).ravel(), "SCALAR", ELEMENT_ARRAY_BUFFER)
    bind = np.tile(np.eye(4, dtype=np.float32), (len(heads), 1, 1))
    bind[:, 3, :3] = -heads  # in columns
    inverse_bind = file.add(bind.reshape(-1, 16), "MAT4")
    b = len(heads)
    children: list[list[int]] = [[] for _ in range(b + 1)]  # the last: of the armature
    for bone, parent in enumerate(rig.parents.tolist()):
        children[parent].append(bone)
    offsets = np.where(rig.parents[:, None] >= 0, heads - heads[rig.parents], heads)
    nodes: list[dict[str, Any]] = [
        {
            "name": name,
            "translation": offset,
            **({"children": own} if own else {}),
        }
        for name, offset, own in zip(rig.names, offsets.astype(np.float32).tolist(), children, strict=False)
    ]
    # the translation of the mesh is for readers that know no skins: to others it has none of its own
    nodes += [{"name": "armature", "children": children[b], **place}, {"name": "mesh", "mesh": 0, "skin": 0, **place}]
    document = {
        "asset": {"version": "2.0", "generator": "lbskel"},
        "scene": 0,
        "scenes": [{"nodes": [b, b + 1]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices}]}],
        "skins": [{"inverseBindMatrices": inverse_bind, "joints": list(range(b)), "skeleton": b}],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": len(file.data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    chunks += struct.pack("<II", len(file.data), BIN_CHUNK) + file.data
    return struct.pack("<III", GLTF_MAGIC, 2, 12 + len(chunks)) + chunks


class _File:
    """The binary chunk, with the views and accessors of what has been added."""

    def __init__(self) -> None:
        self.data, self.views, self.accessors = b"", [], []  # type: bytes, list[dict[str, Any]], list[dict[str, Any]]

    def add(self, values: NDArray[Any], kind: str, target: int | None = None, *, bounds: bool = False) -> int:
        """Append an array, and return the number of its accessor."""
        component = {np.dtype(np.float32): FLOAT, np.dtype(np.uint16): UINT16, np.dtype(np.uint32): UINT32}
        data = values.astype(values.dtype.newbyteorder("<")).tobytes()
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append({**view, **({"target": target} if target else {})})
        accessor = {"bufferView": len(self.views) - 1, "componentType": component[values.dtype], "count": len(values)}
        limits = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()} if bounds else {}
        self.accessors.append({**accessor, "type": kind, **limits})
        self.data += data + b"\0" * (-len(data) % 4)
        return len(self.accessors) - 1


def _split(mesh: Mesh, texture: Any) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
    """Rows of the mesh's vertices that are written, (m, 3) their places for each face, and their texture coordinates.

    In glTF the coordinate v grows downwards.
    """
    if texture is None:
        return np.arange(len(mesh.vertices)), mesh.faces, np.empty((0, 2), dtype=np.float32)
    given = np.asarray(texture, dtype=np.float64)
    if given.shape != (*mesh.faces.shape, 2) or not np.isfinite(given).all():
        raise MeshError(
            f"texture must have a finite pair for each corner, shape {(*mesh.faces.shape, 2)}; it has the shape "
            f"{given.shape}"
        )
    table = np.concatenate([mesh.faces.reshape(-1, 1), given.reshape(-1, 2)], axis=1)
    rows, place = np.unique(table, axis=0, return_inverse=True)
    pairs = np.stack([rows[:, 1], 1 - rows[:, 2]], axis=1).astype(np.float32)
    return rows[:, 0].astype(np.int64), place.reshape(mesh.faces.shape), pairs


def _normals(rig: Rig, turn: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n, 3) unit normals; up where there is none."""
    normals = np.nan_to_num(igl.per_vertex_normals(rig.mesh.vertices, rig.mesh.faces)) @ turn.T
    normals = normals.astype(np.float32).astype(np.float64)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(length > 0.5, normals / np.where(length > 0.5, length, 1.0), [0.0, 1.0, 0.0])
    return unit.astype(np.float32)


def _influences(weights: NDArray[np.float64]) -> list[tuple[NDArray[np.uint16], NDArray[np.float32]]]:
    """List joints and weights in sets of four, the largest first; joints without weight are 0, weights sum to 1."""
    most = max(1, int((weights.astype(np.float32) > 0).sum(axis=1).max()))
    width = -(-most // SET_SIZE) * SET_SIZE
    padded = np.pad(weights, ((0, 0), (0, max(0, width - weights.shape[1]))))
    joints = np.argsort(-padded, axis=1, kind="stable")[:, :width]
    values = np.take_along_axis(padded, joints, axis=1).astype(np.float32)
    values[:, 0] += np.float32(1) - values.sum(axis=1, dtype=np.float32)
    joints = np.where(values > 0, joints, 0).astype(np.uint16)
    return [
        (np.ascontiguousarray(joints[:, k : k + SET_SIZE]), np.ascontiguousarray(values[:, k : k + SET_SIZE]))
        for k in range(0, width, SET_SIZE)
    ]
