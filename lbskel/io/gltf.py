"""glTF 2.0, as one binary file (glb) or as JSON with its buffers beside it (gltf), through trimesh.

All meshes of the scene become one, each where the scene places it; materials are passed over. trimesh takes what it
cannot decode, compressed or sparse arrays, for zeros, and quantized positions as they are: these are refused first.
Format: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

from __future__ import annotations

__all__ = ["read_gltf"]

import io
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import Polygons
from lbskel.io.scenes import polygons_of_scene
from lbskel.io.text import read_bytes

GLB_MAGIC, GLB_HEADER = b"glTF", 20
FLOAT, TRIANGLE_FAN = 5126, 6


def read_gltf(path: Path) -> Polygons:
    """The triangles of all meshes in a glTF scene."""
    import trimesh

    data = read_bytes(path)
    binary = data.startswith(GLB_MAGIC)
    tree = _tree(data[GLB_HEADER : GLB_HEADER + int.from_bytes(data[12:16], "little")] if binary else data)
    _refuse_what_trimesh_mistakes(tree)
    scene = trimesh.load_scene(
        io.BytesIO(data),
        file_type="glb" if binary else "gltf",
        resolver={} if binary else _buffers(tree, path),
        process=False,
        maintain_order=True,
        skip_materials=True,
    )
    return polygons_of_scene(scene)


def _tree(text: bytes) -> dict[str, Any]:
    """The JSON part."""
    tree = json.loads(text)
    if not isinstance(tree, dict) or "asset" not in tree:
        raise FormatError("not a glTF file: the JSON part has no asset")
    return tree


def _refuse_what_trimesh_mistakes(tree: dict[str, Any]) -> None:
    """Raise a FormatError for what trimesh takes for zeros, for other numbers, or passes over."""
    accessors = tree.get("accessors", [])
    for primitive in [primitive for mesh in tree.get("meshes", []) for primitive in mesh["primitives"]]:
        positions, indices = primitive["attributes"].get("POSITION"), primitive.get("indices")
        used = [accessors[index] for index in (positions, indices) if index is not None]
        if any("sparse" in accessor or "bufferView" not in accessor for accessor in used):
            raise FormatError(
                "holds compressed or sparse triangles, which are not read; save it without "
                + (", ".join(tree.get("extensionsUsed", [])) or "sparse accessors")
            )
        if positions is not None and accessors[positions]["componentType"] != FLOAT:
            raise FormatError("holds quantized positions, which are not read; save it without quantization")
        if primitive.get("mode") == TRIANGLE_FAN:
            raise FormatError("holds triangle fans, which are not read; save it with triangles")


def _buffers(tree: dict[str, Any], path: Path) -> dict[str, bytes]:
    """The content of the buffer files, which lie in the folder of the glTF file or below."""
    files = {}
    for buffer in tree.get("buffers", []):
        uri = buffer["uri"]
        if not uri.startswith("data:"):
            file = (path.parent / unquote(uri)).resolve()
            if not file.is_relative_to(path.parent.resolve()):
                raise FormatError(f"its buffer {uri!r} lies outside of its folder")
            try:
                files[uri] = read_bytes(file)
            except FormatError as error:
                raise FormatError(f"its buffer {uri!r}: {error}") from None
    return files
