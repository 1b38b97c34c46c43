"""PLY, the polygon file format of Stanford: elements with named properties, as text or binary of either byte order.

This module parses any elements with lists of any length; :mod:`lbskel.io.ply_mesh` interprets them.
Format: Turk 1994, http://paulbourke.net/dataformats/ply/
"""

from __future__ import annotations

__all__ = ["Element", "Lists", "PlyFile", "encode_ply_header", "parse_ply"]

import re
from codecs import BOM_UTF8
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.text import parse_numbers

DTYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("int64", "long"), "i8"),
    **dict.fromkeys(("uint64", "ulong"), "u8"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class Lists(NamedTuple):
    """A list property of all rows of an element.

    Parameters
    ----------
    values : (c,) array
        The lists of all rows, concatenated.
    sizes : (n,) array of int
        Length of the list of each row.
    """

    values: NDArray[Any]
    sizes: NDArray[Any]


class Property(NamedTuple):
    """A declared property: its name, the dtype of its values, and for a list the dtype of its length."""

    name: str
    dtype: str
    size_dtype: str = ""


Element: TypeAlias = Mapping[str, NDArray[Any] | Lists]


@dataclass(frozen=True, eq=False)
class PlyFile:
    """The content of a PLY file.

    Parameters
    ----------
    elements : mapping of str to Element
        For each element, its properties by name.
    comments : sequence of str
        The comments of the header.
    """

    elements: Mapping[str, Element]
    comments: Sequence[str]


def parse_ply(data: bytes) -> PlyFile:
    """Parse the content of a PLY file.

    Raises
    ------
    FormatError
        If the header is invalid, or the data are invalid or shorter than it declares.
    """
    data = data.removeprefix(BOM_UTF8)
    end = re.search(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r)", data)
    if not data.startswith(b"ply"):
        raise FormatError("not a PLY file: it must begin with ply")
    if end is None:
        raise FormatError("the header has no end_header; is the file truncated?")
    lines = re.split("\r\n|\n|\r", data[: end.start()].decode(errors="replace"))[1:]
    comments = [line.split(None, 1)[1] for line in lines if re.match(r"(comment|obj_info)\s+\S", line)]
    order, declared = _parse_header(lines)
    rest = data[end.end() :]
    body = _Body(rest if order else _parse_text_body(rest, len(lines) + 2).tobytes(), order)
    elements = {}
    for name, (count, properties) in declared.items():
        try:
            elements[name] = _parse_element(body, count, properties)
        except FormatError as error:
            raise FormatError(f"element {name} of {count}: {error}") from None
    return PlyFile(elements, comments)


def _parse_header(lines: Sequence[str]) -> tuple[str, dict[str, tuple[int, list[Property]]]]:
    """Parse the byte order, empty for text, and for each element its number of rows and its properties."""
    order: str | None = None
    declared: dict[str, tuple[int, list[Property]]] = {}
    for number, line in enumerate(lines, 2):
        match line.split():
            case ["format", encoding, _] if encoding in BYTE_ORDERS:
                order = BYTE_ORDERS[encoding]
            case ["element", name, count] if count.isdecimal() and name not in declared:
                properties: list[Property] = []
                declared[name] = (int(count), properties)
            case ["property", "list", size_type, kind, name] if declared and {size_type, kind} <= DTYPES.keys():
                properties.append(Property(name, DTYPES[kind], DTYPES[size_type]))
            case ["property", kind, name] if declared and kind in DTYPES:
                properties.append(Property(name, DTYPES[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise FormatError(f"line {number}: not a line of a PLY header: {line[:60]!r}")
    if order is None:
        raise FormatError("the header names no format")
    return order, declared


class _Body:
    """The data after the header, read front to back; the numbers of a text file are parsed to float64 first."""

    def __init__(self, data: bytes, order: str):
        self.data, self.order, self.position = data, order, 0

    def dtype(self, kind: str) -> np.dtype[Any]:
        """Return the dtype in which values of a declared dtype are stored here."""
        return np.dtype(self.order + kind if self.order else "f8")

    def has(self, dtype: np.dtype[Any], count: int) -> bool:
        """Tell whether that many values are left."""
        return count * dtype.itemsize <= len(self.data) - self.position

    def take(self, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
        """Read the next values."""
        if not self.has(dtype, count):
            raise FormatError("the header declares more data than the file has; is it truncated?")
        values = np.frombuffer(self.data, dtype, count, self.position) if count else np.empty(0, dtype)
        self.position += count * dtype.itemsize
        return values

    def take_size(self, kind: str) -> int:
        """Read the next value as the length of a list."""
        size = float(self.take(self.dtype(kind), 1)[0])
        if not (size >= 0 and size.is_integer()):
            raise FormatError(f"a list cannot have {size} values")
        return int(size)


def _parse_element(body: _Body, count: int, properties: Sequence[Property]) -> Element:
    """Parse the rows of an element: in one block if no list varies in length between rows, else row by row."""
    min_row_bytes = sum(body.dtype(p.size_dtype or p.dtype).itemsize for p in properties)
    if not count or not min_row_bytes:
        return {p.name: Lists(np.empty(0), np.empty(0)) if p.size_dtype else np.empty(0) for p in properties}
    start = body.position
    body.take(np.dtype((np.void, min_row_bytes)), count)  # a view; raises if fewer bytes are left than declared
    body.position = start
    layout = np.dtype([field for index, p in enumerate(properties) for field in _row_fields(body, index, p)])
    body.position = start
    if body.has(layout, count):
        rows = body.take(layout, count)
        sizes = {p.name: rows[f"size {index}"] for index, p in enumerate(properties) if p.size_dtype}
        if all((size == size[0]).all() for size in sizes.values()):
            columns = {p.name: rows[str(index)] for index, p in enumerate(properties)}
            return {name: Lists(c.reshape(-1), sizes[name]) if name in sizes else c for name, c in columns.items()}
    body.position = start
    return _parse_rows(body, count, properties)


def _row_fields(body: _Body, index: int, declared: Property) -> list[tuple[Any, ...]]:
    """Return the dtype fields of one property, with the list length of the first row."""
    dtype = body.dtype(declared.dtype)
    if not declared.size_dtype:
        body.take(dtype, 1)
        return [(str(index), dtype)]
    size = body.take_size(declared.size_dtype)
    body.take(dtype, size)
    return [(f"size {index}", body.dtype(declared.size_dtype)), (str(index), dtype, (size,))]


def _parse_rows(body: _Body, count: int, properties: Sequence[Property]) -> Element:
    """Parse the rows of an element whose lists vary in length."""
    taken: list[list[NDArray[Any]]] = [[] for _ in properties]
    for _ in range(count):
        for values, p in zip(taken, properties, strict=True):
            size = body.take_size(p.size_dtype) if p.size_dtype else 1
            values.append(body.take(body.dtype(p.dtype), size))
    element: dict[str, NDArray[Any] | Lists] = {}
    for values, p in zip(taken, properties, strict=True):
        flat = np.concatenate(values)
        element[p.name] = Lists(flat, np.array([len(v) for v in values])) if p.size_dtype else flat
    return element


def _parse_text_body(text: bytes, header_lines: int) -> NDArray[np.float64]:
    """Parse the numbers after the header; a FormatError names the line of the first other word."""
    try:
        return parse_numbers(text)
    except ValueError as error:
        fault = error
    for word in re.finditer(rb"\S+", text):
        try:
            float(word.group())
        except ValueError:
            line = header_lines + 1 + text.count(b"\n", 0, word.start())
            raise FormatError(f"line {line}: {word.group()[:40].decode(errors='replace')!r} is not a number") from None
    raise FormatError(str(fault))


def encode_ply_header(encoding: str, comments: Sequence[str], elements: Mapping[str, tuple[int, Sequence[str]]]) -> str:
    """Encode the header of a PLY file.

    Parameters
    ----------
    encoding : str
        A key of BYTE_ORDERS.
    comments : sequence of str
        Without line breaks.
    elements : mapping of str to (int, sequence of str)
        For each element its number of rows and its properties, each as ``double x`` or ``list uchar int i``.
    """
    lines = ["ply", f"format {encoding} 1.0", *(f"comment {comment}" for comment in comments)]
    for name, (count, properties) in elements.items():
        lines += [f"element {name} {count}", *(f"property {declared}" for declared in properties)]
    return "\n".join([*lines, "end_header", ""])
