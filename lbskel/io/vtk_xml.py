"""The arrays in an XML file of VTK: as text, as base64 or appended, plain or compressed with zlib or LZMA.

vtk's own reader is not used because a damaged file ends the process in it. Compressed with LZ4 is refused.
Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

__all__ = ["VtkFile", "data_array", "parse_vtk"]

import base64
import lzma
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import FormatError, choose

KINDS = {f"{name}{8 * size}": f"{code}{size}" for name, code in (("Int", "i"), ("UInt", "u")) for size in (1, 2, 4, 8)}
KINDS |= {"Float32": "f4", "Float64": "f8", "String": "u1"}
ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lzma.LZMADecompressor,
}
APPENDED = re.compile(rb"<AppendedData[^>]*encoding\s*=\s*[\"'](raw|base64)[\"'][^>]*>\s*_")


@dataclass(frozen=True, eq=False)
class VtkFile:
    """The XML part of the file, and the block of appended data with whether that is base64."""

    root: ElementTree.Element
    appended: bytes
    is_base64: bool

    def array(self, element: ElementTree.Element) -> NDArray:
        """The values of an array element, one after the other."""
        kind = choose(KINDS, element.get("type", ""), "type of array")
        place = element.get("format")
        if place == "ascii":
            return np.array((element.text or "").split(), dtype=np.float64)
        order = choose(ORDERS, self.root.get("byte_order", "LittleEndian"), "byte order")
        if place == "binary":
            data = self._block(re.sub(rb"\s", b"", (element.text or "").encode()), 0, True, order)
        elif place == "appended":
            data = self._block(self.appended, int(element.get("offset", "")), self.is_base64, order)
        else:
            raise FormatError(f"array {element.get('Name')}: unknown format {place!r}")
        return np.frombuffer(data, order + kind)

    def _block(self, data: bytes, start: int, is_base64: bool, order: str) -> bytes:
        """The bytes of an array: a head with their count, or with the sizes of compressed blocks, and then they."""
        head = np.dtype(order + choose(KINDS, self.root.get("header_type", "UInt32"), "header type"))
        if "compressor" not in self.root.attrib:
            count = int(np.frombuffer(_bytes(data, start, head.itemsize, is_base64), head)[0])
            return _bytes(data, start, head.itemsize + count, is_base64)[head.itemsize :]
        decompressor = choose(DECOMPRESSORS, self.root.attrib["compressor"], "compressor")
        n_blocks, size, _ = np.frombuffer(_bytes(data, start, 3 * head.itemsize, is_base64), head).tolist()
        head_bytes = (3 + n_blocks) * head.itemsize
        sizes = np.frombuffer(_bytes(data, start, head_bytes, is_base64), head)[3:].tolist()
        body = _bytes(data, start + _stored(head_bytes, is_base64), sum(sizes), is_base64)
        ends = np.cumsum([0, *sizes]).tolist()
        blocks = (body[a:b] for a, b in pairwise(ends))
        return b"".join(decompressor().decompress(block, size) for block in blocks)


def _stored(count: int, is_base64: bool) -> int:
    """How long so many bytes are as they are stored."""
    return -(-count // 3) * 4 if is_base64 else count


def _bytes(data: bytes, start: int, count: int, is_base64: bool) -> bytes:
    """That many bytes from a place on, or a FormatError if there are fewer."""
    part = data[start : start + _stored(count, is_base64)] if start >= 0 else b""
    part = base64.b64decode(part, validate=True) if is_base64 else part
    if len(part) < count:
        raise FormatError(f"an array of {count} bytes is promised, {len(part)} are there; is the file truncated?")
    return part[:count]


def parse_vtk(data: bytes) -> VtkFile:
    """The XML part and the appended block of a file."""
    appended, is_base64 = b"", False
    if match := APPENDED.search(data):
        appended, is_base64 = data[match.end() :], match.group(1) == b"base64"
        data = data[: match.start()] + b"</VTKFile>"
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise FormatError(f"not XML: {error}") from None
    return VtkFile(root, appended, is_base64)


def data_array(name: str, values: ArrayLike, components: int = 1) -> str:
    """The element of an array of float, of int, or of unsigned bytes, which are a string that ends with 0.

    The byte order is LittleEndian and the header type UInt64.
    """
    array = np.asarray(values)
    kind = {"f": "Float64", "u": "String"}.get(array.dtype.kind, "Int64")
    data = array.astype("<" + KINDS[kind]).tobytes()
    content = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
    tag, rows = ("Array", 1) if kind == "String" else ("DataArray", array.size // components)
    shape = f'NumberOfComponents="{components}" NumberOfTuples="{rows}"'
    return f'<{tag} type="{kind}" Name="{name}" {shape} format="binary">{content}</{tag}>\n'
