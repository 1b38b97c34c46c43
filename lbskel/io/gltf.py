"""glTF 2.0, as one binary file (glb) or as JSON with separate buffer files (gltf), read through trimesh.

All meshes of the scene are joined into one with their transforms applied; materials are ignored. trimesh reads data
that it cannot decode (compressed or sparse accessors) as zeros, and quantized positions without their scale, so such
files are rejected before trimesh sees them.
Format: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

from __future__ import annotations

__all__ = ["buffer_files", "read_gltf"]

import io
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.scenes import polygons_from_scene
from lbskel.io.text import convert_errors, read_bytes

GLB_MAGIC = b"glTF"
GLB_HEADER = 20  # bytes before the JSON text: 12 of the file header, 8 of the header of the first chunk (glTF 2.0)
JSON_LENGTH = slice(12, 16)  # bytes that hold the length of the JSON text, a little-endian uint32 (glTF 2.0)
FLOAT = 5126  # accessor.componentType of float32 (glTF 2.0)
TRIANGLE_FAN = 6  # mesh.primitive.mode of a triangle fan (glTF 2.0)


def read_gltf(path: Path) -> PolygonSoup:
    """Read the triangles of all meshes in a glTF scene."""
    import trimesh

    data = read_bytes(path)
    is_binary = data.startswith(GLB_MAGIC)
    tree = _parse_json(data)
    _reject_unsupported(tree)
    scene = trimesh.load_scene(
        io.BytesIO(data),
        file_type="glb" if is_binary else "gltf",
        resolver={} if is_binary else _read_buffers(tree, path),
        process=False,
        maintain_order=True,
        skip_materials=True,
    )
    return polygons_from_scene(scene)


def buffer_files(path: Path) -> list[Path]:
    """List the buffer files that a file with the extension gltf names; none if it is anything else, or broken."""
    if path.suffix.lower() != ".gltf":
        return []
    try:
        with convert_errors(path):
            return list(_buffer_files(_parse_json(read_bytes(path)), path).values())
    except FormatError:
        return []


def _parse_json(data: bytes) -> dict[str, Any]:
    """Parse the JSON part of the file."""
    end_of_json = GLB_HEADER + int.from_bytes(data[JSON_LENGTH], "little")
    tree = json.loads(data[GLB_HEADER:end_of_json] if data.startswith(GLB_MAGIC) else data)
    if not isinstance(tree, dict) or "asset" not in tree:
        raise FormatError("not a glTF file: the JSON part has no asset")
    return tree


def _reject_unsupported(tree: dict[str, Any]) -> None:
    """Raise a FormatError for data that trimesh would read as zeros, scale wrongly or skip."""
    accessors = tree.get("accessors", [])
    for primitive in [primitive for mesh in tree.get("meshes", []) for primitive in mesh["primitives"]]:
        positions, indices = primitive["attributes"].get("POSITION"), primitive.get("indices")
        used = [accessors[index] for index in (positions, indices) if index is not None]
        if any("sparse" in accessor or "bufferView" not in accessor for accessor in used):
            raise FormatError(
                "has compressed or sparse triangles, which are not supported; save it without "
                + (", ".join(tree.get("extensionsUsed", [])) or "sparse accessors")
            )
        if positions is not None and accessors[positions]["componentType"] != FLOAT:
            raise FormatError("has quantized positions, which are not supported; save it without quantization")
        if primitive.get("mode") == TRIANGLE_FAN:
            raise FormatError("has triangle fans, which are not supported; save it with triangles")


def _read_buffers(tree: dict[str, Any], path: Path) -> dict[str, bytes]:
    """Read the buffer files, by URI."""
    contents = {}
    for uri, file in _buffer_files(tree, path).items():
        try:
            contents[uri] = read_bytes(file)
        except FormatError as error:
            raise FormatError(f"its buffer {uri!r}: {error}") from None
    return contents


def _buffer_files(tree: dict[str, Any], path: Path) -> dict[str, Path]:
    """List the buffer files, by URI; they must be in the folder of the glTF file or below it."""
    files = {}
    for buffer in tree.get("buffers", []):
        if (uri := buffer.get("uri")) is None:
            raise FormatError(f"its buffer {tree['buffers'].index(buffer)} has no uri; save it as glb, or with the uri")
        if not uri.startswith("data:"):
            file = (path.parent / unquote(uri)).resolve()
            if not file.is_relative_to(path.parent.resolve()):
                raise FormatError(f"its buffer {uri!r} is outside of its folder")
            files[uri] = file
    return files
