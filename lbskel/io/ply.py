"""PLY, the polygon file format of Stanford: elements with named properties, as text or binary of either byte order.

Here is the format itself: any elements, lists of any length. What the elements mean is in ``ply_shapes``.
Format: Turk 1994, http://paulbourke.net/dataformats/ply/
"""

from __future__ import annotations

__all__ = ["Element", "Lists", "PlyFile", "parse_ply", "ply_header"]

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.text import numbers_of

KINDS = {
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
ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class Lists(NamedTuple):
    """A list property of all rows: the values one row after the other, and how many each row has."""

    values: NDArray
    sizes: NDArray


class Property(NamedTuple):
    """A property: its name, the type of its values, and of their count if it is a list."""

    name: str
    kind: str
    count_kind: str = ""


Element = Mapping[str, "NDArray | Lists"]


@dataclass(frozen=True, eq=False)
class PlyFile:
    """The elements of a PLY file by name, and its comments."""

    elements: Mapping[str, Element]
    comments: Sequence[str]


def parse_ply(data: bytes) -> PlyFile:
    """The elements of a PLY file.

    Raises
    ------
    FormatError
        If the header is not one of PLY or promises what does not follow.
    """
    end = re.search(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r)", data)
    if not data.startswith(b"ply"):
        raise FormatError("not a PLY file: it must begin with ply")
    if end is None:
        raise FormatError("the header has no end_header; is the file truncated?")
    lines = data[: end.start()].decode(errors="replace").splitlines()[1:]
    comments = [line.split(None, 1)[1] for line in lines if re.match(r"(comment|obj_info)\s+\S", line)]
    order, declared = _declarations(lines)
    rest = data[end.end() :]
    body = _Body(rest if order else _numbers(rest, len(lines) + 2).tobytes(), order)
    elements = {}
    for name, (count, properties) in declared.items():
        try:
            elements[name] = _element(body, count, properties)
        except FormatError as error:
            raise FormatError(f"element {name} of {count}: {error}") from None
    return PlyFile(elements, comments)


def _declarations(lines: Sequence[str]) -> tuple[str, dict[str, tuple[int, list[Property]]]]:
    """The byte order, empty for text, and the count and properties of each element."""
    order: str | None = None
    declared: dict[str, tuple[int, list[Property]]] = {}
    for number, line in enumerate(lines, 2):
        match line.split():
            case ["format", encoding, _] if encoding in ENCODINGS:
                order = ENCODINGS[encoding]
            case ["element", name, count] if count.isdecimal() and name not in declared:
                properties: list[Property] = []
                declared[name] = (int(count), properties)
            case ["property", "list", count_kind, kind, name] if declared and {count_kind, kind} <= KINDS.keys():
                properties.append(Property(name, KINDS[kind], KINDS[count_kind]))
            case ["property", kind, name] if declared and kind in KINDS:
                properties.append(Property(name, KINDS[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise FormatError(f"line {number}: not a line of a PLY header: {line[:60]!r}")
    if order is None:
        raise FormatError("the header names no format")
    return order, declared


class _Body:
    """What follows the header, taken from the front; the numbers of a text are all parsed into float64 before."""

    def __init__(self, data: bytes, order: str):
        self.data, self.order, self.position = data, order, 0

    def dtype(self, kind: str) -> np.dtype:
        """How values of a type are stored here."""
        return np.dtype(self.order + kind if self.order else "f8")

    def holds(self, dtype: np.dtype, count: int) -> bool:
        """Whether as much is left."""
        return count * dtype.itemsize <= len(self.data) - self.position

    def take(self, dtype: np.dtype, count: int) -> NDArray:
        """The next values."""
        if not self.holds(dtype, count):
            raise FormatError("more is promised than the file holds; is it truncated?")
        values = np.frombuffer(self.data, dtype, count, self.position) if count else np.empty(0, dtype)
        self.position += count * dtype.itemsize
        return values

    def take_size(self, kind: str) -> int:
        """The next value as the length of a list."""
        size = float(self.take(self.dtype(kind), 1)[0])
        if not (size >= 0 and size.is_integer()):
            raise FormatError(f"a list cannot hold {size} values")
        return int(size)


def _element(body: _Body, count: int, properties: Sequence[Property]) -> Element:
    """The properties of all rows of an element: at once if lists are as long in every row, else row by row."""
    least = sum(body.dtype(p.count_kind or p.kind).itemsize for p in properties)
    if not count or not least:
        return {p.name: Lists(np.empty(0), np.empty(0)) if p.count_kind else np.empty(0) for p in properties}
    start = body.position
    body.take(np.dtype((np.void, least)), count)  # a view, which fails at once if more is promised than there is
    body.position = start
    layout = np.dtype([field for index, p in enumerate(properties) for field in _fields(body, index, p)])
    body.position = start
    if body.holds(layout, count):
        rows = body.take(layout, count)
        sizes = {p.name: rows[f"size {index}"] for index, p in enumerate(properties) if p.count_kind}
        if all((size == size[0]).all() for size in sizes.values()):
            columns = {p.name: rows[str(index)] for index, p in enumerate(properties)}
            return {name: Lists(c.reshape(-1), sizes[name]) if name in sizes else c for name, c in columns.items()}
    body.position = start
    return _element_by_rows(body, count, properties)


def _fields(body: _Body, index: int, property: Property) -> list[tuple]:
    """The fields of one property in the first row."""
    dtype = body.dtype(property.kind)
    if not property.count_kind:
        body.take(dtype, 1)
        return [(str(index), dtype)]
    size = body.take_size(property.count_kind)
    body.take(dtype, size)
    return [(f"size {index}", body.dtype(property.count_kind)), (str(index), dtype, (size,))]


def _element_by_rows(body: _Body, count: int, properties: Sequence[Property]) -> Element:
    """The properties of all rows of an element whose lists differ in length."""
    taken: list[list[NDArray]] = [[] for _ in properties]
    for _ in range(count):
        for values, p in zip(taken, properties, strict=True):
            size = body.take_size(p.count_kind) if p.count_kind else 1
            values.append(body.take(body.dtype(p.kind), size))
    element: dict[str, NDArray | Lists] = {}
    for values, p in zip(taken, properties, strict=True):
        flat = np.concatenate(values)
        element[p.name] = Lists(flat, np.array([len(v) for v in values])) if p.count_kind else flat
    return element


def _numbers(text: bytes, header_lines: int) -> NDArray[np.float64]:
    """All numbers of a text, or a FormatError with the line of the first word that is none."""
    try:
        return numbers_of(text)
    except ValueError as error:
        fault = error
    for word in re.finditer(rb"\S+", text):
        try:
            float(word.group())
        except ValueError:
            line = header_lines + 1 + text.count(b"\n", 0, word.start())
            raise FormatError(f"line {line}: {word.group()[:40].decode(errors='replace')!r} is no number") from None
    raise FormatError(str(fault))


def ply_header(encoding: str, comments: Sequence[str], elements: Mapping[str, tuple[int, Sequence[str]]]) -> str:
    """The header of a PLY file: for each element its count and its properties, as ``double x``."""
    lines = ["ply", f"format {encoding} 1.0", *(f"comment {comment}" for comment in comments)]
    for name, (count, properties) in elements.items():
        lines += [f"element {name} {count}", *(f"property {property}" for property in properties)]
    return "\n".join([*lines, "end_header", ""])
