"""The arrays of an XML file of VTK: as text, base64 or appended data, plain or compressed with zlib or LZMA.

vtk's own reader is not used because it ends the process on a damaged file. LZ4 compression is not supported.
Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

__all__ = ["VtkFile", "encode_array", "find_array", "parse_vtk"]

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

from lbskel.errors import FormatError, choose, counted

DTYPES = {f"{name}{8 * size}": f"{code}{size}" for name, code in (("Int", "i"), ("UInt", "u")) for size in (1, 2, 4, 8)}
DTYPES |= {"Float32": "f4", "Float64": "f8", "String": "u1"}
BYTE_ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lzma.LZMADecompressor,
}
APPENDED = re.compile(rb"<AppendedData[^>]*encoding\s*=\s*[\"'](raw|base64)[\"'][^>]*>\s*_")


@dataclass(frozen=True, eq=False)
class VtkFile:
    """A parsed file.

    Parameters
    ----------
    root : Element
        The XML tree.
    appended : bytes
        The appended data; empty if there are none.
    is_base64 : bool
        Whether the appended data are encoded as base64.
    """

    root: ElementTree.Element
    appended: bytes
    is_base64: bool

    def array(self, element: ElementTree.Element) -> NDArray[Any]:
        """Decode the values of a DataArray or Array element, as a flat array."""
        dtype = choose(DTYPES, element.get("type", ""), "type of array")
        encoding = element.get("format")
        if encoding == "ascii":
            return np.array((element.text or "").split(), dtype=np.float64)
        order = choose(BYTE_ORDERS, self.root.get("byte_order", "LittleEndian"), "byte order")
        if encoding == "binary":
            data = self._decode(re.sub(rb"\s", b"", (element.text or "").encode()), 0, True, order)
        elif encoding == "appended":
            data = self._decode(self.appended, int(element.get("offset", "")), self.is_base64, order)
        else:
            raise FormatError(f"array {element.get('Name')}: unknown format {encoding!r}")
        return np.frombuffer(data, order + dtype)

    def _decode(self, data: bytes, start: int, is_base64: bool, order: str) -> bytes:
        """Decode one array, whose header has its number of bytes or the sizes of its compressed blocks."""
        head = np.dtype(order + choose(DTYPES, self.root.get("header_type", "UInt32"), "header type"))
        if "compressor" not in self.root.attrib:
            count = int(np.frombuffer(_decode_bytes(data, start, head.itemsize, is_base64), head)[0])
            return _decode_bytes(data, start, head.itemsize + count, is_base64)[head.itemsize :]
        if (compressor := self.root.attrib["compressor"]) not in DECOMPRESSORS:
            raise FormatError(f"is compressed by {compressor}, which is not supported; save it with ZLib, or without")
        decompressor = DECOMPRESSORS[compressor]
        n_blocks, size, _ = np.frombuffer(_decode_bytes(data, start, 3 * head.itemsize, is_base64), head).tolist()
        head_bytes = (3 + n_blocks) * head.itemsize
        sizes = np.frombuffer(_decode_bytes(data, start, head_bytes, is_base64), head)[3:].tolist()
        body = _decode_bytes(data, start + _encoded_length(head_bytes, is_base64), sum(sizes), is_base64)
        ends = np.cumsum([0, *sizes]).tolist()
        blocks = (body[a:b] for a, b in pairwise(ends))
        return b"".join(decompressor().decompress(block, size) for block in blocks)


def _encoded_length(count: int, is_base64: bool) -> int:
    """Return the length of ``count`` bytes after encoding."""
    return -(-count // 3) * 4 if is_base64 else count


def _decode_bytes(data: bytes, start: int, count: int, is_base64: bool) -> bytes:
    """Decode ``count`` bytes from a position on; raise FormatError if there are fewer."""
    part = data[start : start + _encoded_length(count, is_base64)] if start >= 0 else b""
    part = base64.b64decode(part, validate=True) if is_base64 else part
    if len(part) < count:
        raise FormatError(f"an array declares {counted(count, 'byte')} and has {len(part):,}; is the file truncated?")
    return part[:count]


def find_array(file: VtkFile, section: ElementTree.Element | None, name: str | None) -> NDArray[np.float64] | None:
    """Find an array of a section by name, or its first array if the name is None; None if there is none."""
    for element in section if section is not None else ():
        if name in (None, element.get("Name")):
            return file.array(element).astype(np.float64)
    return None


def parse_vtk(data: bytes) -> VtkFile:
    """Parse the content of a file into its XML tree and its appended data.

    Raises
    ------
    FormatError
        If it is not XML.
    """
    appended, is_base64 = b"", False
    if match := APPENDED.search(data):
        appended, is_base64 = data[match.end() :], match.group(1) == b"base64"
        data = data[: match.start()] + b"</VTKFile>"
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise FormatError(f"not XML: {error}") from None
    return VtkFile(root, appended, is_base64)


def encode_array(name: str, values: ArrayLike, components: int = 1) -> str:
    """Encode an array as an XML element, for a file with byte order LittleEndian and header type UInt64.

    Parameters
    ----------
    name : str
        The name of the array.
    values : array_like
        Floats, integers, or unsigned bytes: the latter are a string that ends with a zero byte.
    components : int
        Number of values per tuple.
    """
    array = np.asarray(values)
    kind = {"f": "Float64", "u": "String"}.get(array.dtype.kind, "Int64")
    data = array.astype("<" + DTYPES[kind]).tobytes()
    content = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
    tag, rows = ("Array", 1) if kind == "String" else ("DataArray", array.size // components)
    shape = f'NumberOfComponents="{components}" NumberOfTuples="{rows}"'
    return f'<{tag} type="{kind}" Name="{name}" {shape} format="binary">{content}</{tag}>\n'
