"""Reading and writing of numbers in text files; errors name the line.

Numbers are parsed in blocks of lines, or all at once in a file of numbers only; the faulty line is searched for only
after a block has failed to parse. Sizes declared by a file are compared with the size of the file before memory is
allocated.
"""

from __future__ import annotations

__all__ = [
    "MAX_EXACT_INTEGER",
    "Lines",
    "as_floats",
    "as_integers",
    "content_lines",
    "convert_errors",
    "decode_text",
    "format_rows",
    "known_extension",
    "parse_columns",
    "parse_index_lists",
    "parse_numbers",
    "prefix_errors",
    "read_bytes",
    "read_text",
]

import os
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel._kernels.number_parsing import parse_decimals
from lbskel.errors import FormatError, LbskelError, MeshError, MissingDependency, nearest

MAX_EXACT_INTEGER = 2.0**53  # all integers below are exact in float64, whose significand has 53 bits (IEEE 754)


def known_extension(path: str | os.PathLike[str], known: Collection[str], what: str) -> str:
    """Return the extension of a path in lower case and without its dot; a FormatError lists the known ones.

    Parameters
    ----------
    path : path-like
    known : collection of str
        The supported extensions.
    what : str
        What is read or written, for the message: ``meshes``.
    """
    suffix = Path(path).suffix.lower().removeprefix(".")
    if suffix not in known:
        fault = f"unknown extension {suffix!r}" if suffix else "is a folder" if os.path.isdir(path) else "no extension"
        raise FormatError(f"{path}: {fault}; known for {what}: {', '.join(known)}")
    return suffix


@contextmanager
def prefix_errors(path: str | os.PathLike[str]) -> Iterator[None]:
    """Prefix the message of every error of lbskel in the block with the path."""
    try:
        yield
    except MissingDependency:
        raise
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error.__cause__
    except LbskelError as error:
        raise FormatError(f"{path}: {error}") from error.__cause__


@contextmanager
def convert_errors(path: str | os.PathLike[str]) -> Iterator[None]:
    """Prefix the message of every error in the block with the path, and convert errors not of lbskel to FormatError."""
    with prefix_errors(path):
        try:
            yield
        except (LbskelError, MemoryError):
            raise
        except Exception as error:
            raise FormatError(f"cannot be read as {Path(path).suffix}: {type(error).__name__}: {error}") from error


def read_bytes(path: Path) -> bytes:
    """Read a regular file that is not empty; a FormatError if it is something else."""
    try:
        if path.is_dir():
            raise FormatError("is a folder, not a file")
        if path.exists() and not path.is_file():
            raise FormatError("is not a regular file")
        data = path.read_bytes()
    except FileNotFoundError:
        names = [each.name for each in path.parent.iterdir()] if path.parent.is_dir() else []
        raise FormatError(f"no such file{nearest(path.name, names)}") from None
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}") from None
    if not data:
        raise FormatError("the file is empty")
    return data


def decode_text(data: bytes) -> str:
    """Decode UTF-8; invalid bytes, as in material names in other encodings, become the replacement character."""
    return data.decode("utf-8-sig", errors="replace")


def read_text(path: Path) -> str:
    """Read a regular file that is not empty as text; a FormatError if it is something else."""
    return decode_text(read_bytes(path))


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of a file with their line numbers.

    Parameters
    ----------
    texts : list of str
    numbers : (n,) array of int
        1-based line numbers, as an editor shows them.
    """

    texts: list[str]
    numbers: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.texts)

    def __getitem__(self, rows: slice | NDArray[np.int64]) -> Lines:
        texts = self.texts[rows] if isinstance(rows, slice) else [self.texts[row] for row in rows.tolist()]
        return Lines(texts, self.numbers[rows])


def content_lines(text: str, comment: str = "#") -> Lines:
    """Return the lines that are not empty after comments are removed."""
    texts = text.splitlines()
    if comment in text:
        texts = [line.split(comment, 1)[0] for line in texts]
    texts = list(map(str.strip, texts))
    return Lines(list(filter(None, texts)), 1 + np.flatnonzero(np.fromiter(map(len, texts), dtype=np.int64)))


def parse_numbers(text: str | bytes | memoryview) -> NDArray[np.float64]:
    """Parse a text of numbers separated by any white space.

    Raises
    ------
    ValueError
        If the text contains anything else.
    """
    numbers: NDArray[np.float64] = parse_decimals(text.encode() if isinstance(text, str) else text)
    return numbers


def parse_columns(lines: Lines, columns: Sequence[int], what: str, delimiter: str | None = None) -> NDArray[np.float64]:
    """Parse the numbers in some columns of each line, as an (n, len(columns)) array.

    Parameters
    ----------
    lines : Lines
        Lines of columns.
    columns : sequence of int
        0-based columns; others are ignored.
    what : str
        What the columns are, for the message.
    delimiter : str, optional
        What separates the columns, one character; white space by default.

    Raises
    ------
    FormatError
        If a line has too few columns or a column is not a number; the message names the line.
    """
    if not len(lines) or not len(columns):
        return np.empty((len(lines), len(columns)))
    if (numbers := _parse_block(lines.texts, columns, delimiter)) is not None:
        return numbers
    low, high = 0, len(lines)  # the first faulty line is in low..high, found by bisection
    while high - low > 1:
        middle = (low + high) // 2
        is_faulty = _parse_block(lines.texts[low:middle], columns, delimiter) is None
        low, high = (low, middle) if is_faulty else (middle, high)
    raise FormatError(f"line {lines.numbers[low]}: {what} expected, found {lines.texts[low][:60]!r}")


def _parse_block(texts: list[str], columns: Sequence[int], delimiter: str | None) -> NDArray[np.float64] | None:
    """Parse the numbers in some columns of each line; None if a line is faulty."""
    if not all(texts):  # loadtxt skips empty lines
        return None
    try:
        return np.loadtxt(texts, delimiter=delimiter, usecols=columns, comments=None, ndmin=2)
    except ValueError:
        return None


def parse_index_lists(lines: Lines, sizes: NDArray[np.int64], first: int, what: str) -> NDArray[np.int64]:
    """Parse one list of integers per line, and concatenate the lists.

    Parameters
    ----------
    lines : Lines
    sizes : (n,) array of int
        Length of the list of each line.
    first : int
        0-based column in which the lists begin.
    what : str
        What the integers are, for the message.

    Raises
    ------
    FormatError
        If a line has fewer columns, or one that is not an integer; the message names the line.
    """
    lengths = np.fromiter(map(len, lines.texts), dtype=np.int64, count=len(lines))
    for row in np.flatnonzero((sizes < 0) | (sizes > lengths))[:1]:
        raise FormatError(f"line {lines.numbers[row]}: cannot have {sizes[row]} {what}")
    starts = np.cumsum(sizes) - sizes
    values = np.empty(sizes.sum(), dtype=np.int64)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        numbers = parse_columns(lines[rows], range(first, first + size), f"{size} {what}")
        values[starts[rows][:, None] + np.arange(size)] = as_integers(numbers, what, lines.numbers[rows])
    return values


def as_integers(
    values: NDArray[np.float64], what: str, line_numbers: NDArray[np.int64] | None = None
) -> NDArray[np.int64]:
    """Convert to int64; a FormatError names the line, or the row, of the first value that is not an integer.

    Parameters
    ----------
    values : (n,) or (n, k) array of float
    what : str
        What the values are, for the message.
    line_numbers : (n,) array of int, optional
        1-based line of each row in the file.
    """
    bad = ~(np.abs(values) < MAX_EXACT_INTEGER) | (values != np.floor(values))
    rows = np.flatnonzero(bad.any(axis=tuple(range(1, bad.ndim))))
    if len(rows):
        unit = "row" if line_numbers is None else "line"
        number = rows[0] if line_numbers is None else line_numbers[rows[0]]
        raise FormatError(f"{unit} {number}: {what} must be whole numbers")
    return values.astype(np.int64)


def as_floats(values: ArrayLike, what: str, width: int = 0) -> NDArray[np.float64]:
    """Convert the nested lists of a structured file to an array; None becomes NaN.

    Parameters
    ----------
    values : array_like
    what : str
        What the values are, for the message.
    width : int
        Number of columns of an (n, width) array; 0 for an (n,) array.

    Raises
    ------
    FormatError
        If the values are not numbers, or the array has another shape.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{what}: not an array of numbers: {error}") from None
    if array.size == 0:
        return np.empty((0, width) if width else 0)
    if array.ndim != (2 if width else 1) or (width and array.shape[1] != width):
        raise FormatError(f"{what}: the shape must be {f'(n, {width})' if width else '(n,)'}, not {array.shape}")
    return array


def format_rows(prefix: str, rows: NDArray[Any]) -> str:
    """Format one line per row: the prefix and the shortest decimals that parse to the same float64."""
    return "".join(prefix + " ".join(map(repr, row)) + "\n" for row in rows.tolist())
