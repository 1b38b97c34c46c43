"""From files to numbers, with the place of the fault in every error.

Numbers of text files are read a block of lines at a time, or all at once where nothing else is in it; only where that
does not parse is the line at fault looked for. Sizes that a file promises are compared with what it holds before
anything is allocated.
"""

from __future__ import annotations

__all__ = [
    "EXACT_WHOLE",
    "Lines",
    "array_of",
    "as_integers",
    "lines_of",
    "naming",
    "numbers_of",
    "ragged",
    "read_bytes",
    "read_text",
    "reading",
    "suffix_in",
    "table",
    "text_of",
]

import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel._kernels.number_parsing import numbers_in
from lbskel.errors import FormatError, LbskelError, MeshError, MissingDependency

EXACT_WHOLE = 2.0**53  # whole numbers below are exact in float64


def suffix_in(path: str | os.PathLike[str], known: Collection[str], what: str) -> str:
    """The extension of a path, lower case and without its dot, or a FormatError that lists those that are known."""
    suffix = Path(path).suffix.lower().removeprefix(".")
    if suffix not in known:
        place = f"unknown extension {suffix!r}" if suffix else "is a folder" if os.path.isdir(path) else "no extension"
        raise FormatError(f"{path}: {place}; known for {what}: {', '.join(known)}")
    return suffix


@contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Put the path in front of every error of lbskel inside."""
    try:
        yield
    except MissingDependency:
        raise
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error.__cause__
    except LbskelError as error:
        raise FormatError(f"{path}: {error}") from error.__cause__


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Put the path in front of every error inside, and make those of other packages FormatErrors."""
    with naming(path):
        try:
            yield
        except LbskelError:
            raise
        except Exception as error:
            raise FormatError(f"not readable as {Path(path).suffix}: {type(error).__name__}: {error}") from error


def read_bytes(path: Path) -> bytes:
    """The content of a regular file that is not empty, or a FormatError."""
    try:
        if path.is_dir():
            raise FormatError("is a folder, not a file")
        if path.exists() and not path.is_file():
            raise FormatError("is not a regular file")
        data = path.read_bytes()
    except FileNotFoundError:
        raise FormatError("no such file") from None
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}") from None
    if not data:
        raise FormatError("the file is empty")
    return data


def text_of(data: bytes) -> str:
    """The content of a text file; bytes that are no UTF-8, as old names of materials are, become a replacement sign."""
    return data.decode("utf-8-sig", errors="replace")


def read_text(path: Path) -> str:
    """The content of a regular file that is not empty as text, or a FormatError."""
    return text_of(read_bytes(path))


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of a file with the numbers, from 1, that an editor shows for them."""

    texts: list[str]
    numbers: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.texts)

    def __getitem__(self, rows: slice | NDArray[np.int64]) -> Lines:
        texts = self.texts[rows] if isinstance(rows, slice) else [self.texts[row] for row in rows.tolist()]
        return Lines(texts, self.numbers[rows])


def lines_of(text: str, comment: str = "#") -> Lines:
    """The lines that hold something, without comments."""
    texts = text.splitlines()
    if comment in text:
        texts = [line.split(comment, 1)[0] for line in texts]
    texts = list(map(str.strip, texts))
    return Lines(list(filter(None, texts)), 1 + np.flatnonzero(np.fromiter(map(len, texts), dtype=np.int64)))


def numbers_of(text: str | bytes | memoryview) -> NDArray[np.float64]:
    """All numbers of a text, whatever white space is between them.

    Raises
    ------
    ValueError
        If something else stands there.
    """
    return numbers_in(text.encode() if isinstance(text, str) else text)


def table(lines: Lines, columns: range, what: str) -> NDArray[np.float64]:
    """The numbers in some columns of each line.

    Raises
    ------
    FormatError
        If a line has fewer columns or something else than a number there; the message names the line.
    """
    if not len(lines) or not len(columns):
        return np.empty((len(lines), len(columns)))
    if (numbers := _parse(lines.texts, columns)) is not None:
        return numbers
    low, high = 0, len(lines)  # the first line at fault is in low..high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _parse(lines.texts[low:middle], columns) is None else (middle, high)
    raise FormatError(f"line {lines.numbers[low]}: {what} expected, found {lines.texts[low][:60]!r}")


def _parse(texts: list[str], columns: range) -> NDArray[np.float64] | None:
    """The numbers in those columns, None where the lines do not hold them."""
    if not all(texts):  # loadtxt passes over empty lines
        return None
    try:
        return np.loadtxt(texts, usecols=columns, comments=None, ndmin=2)
    except ValueError:
        return None


def ragged(lines: Lines, sizes: NDArray[np.int64], first: int, what: str) -> NDArray[np.int64]:
    """The whole numbers of lines that hold several each, one line after the other.

    Parameters
    ----------
    lines : Lines
    sizes : (n,) array of int
        How many numbers each line holds.
    first : int
        Column of the first of them.
    what : str
        What they are, for the message.
    """
    lengths = np.fromiter(map(len, lines.texts), dtype=np.int64, count=len(lines))
    for row in np.flatnonzero((sizes < 0) | (sizes > lengths))[:1]:
        raise FormatError(f"line {lines.numbers[row]}: holds no {sizes[row]} {what}")
    starts = np.cumsum(sizes) - sizes
    values = np.empty(sizes.sum(), dtype=np.int64)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        numbers = table(lines[rows], range(first, first + size), f"{size} {what}")
        values[starts[rows][:, None] + np.arange(size)] = as_integers(numbers, what, lines.numbers[rows])
    return values


def as_integers(
    values: NDArray[np.float64], what: str, line_numbers: NDArray[np.int64] | None = None
) -> NDArray[np.int64]:
    """The values as int64, or a FormatError that names the line, or the row, of the first that is not whole."""
    bad = ~(np.abs(values) < EXACT_WHOLE) | (values != np.floor(values))
    rows = np.flatnonzero(bad.any(axis=tuple(range(1, bad.ndim))))
    if len(rows):
        place = "row" if line_numbers is None else "line"
        number = rows[0] if line_numbers is None else line_numbers[rows[0]]
        raise FormatError(f"{place} {number}: {what} must be whole numbers")
    return values.astype(np.int64)


def array_of(values: ArrayLike, what: str, width: int = 0) -> NDArray[np.float64]:
    """An (n,) array, or (n, width) where a width is given, of what a structured file holds; None becomes NaN."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{what}: not an array of numbers: {error}") from None
    if array.size == 0:
        return np.empty((0, width) if width else 0)
    if array.ndim != (2 if width else 1) or (width and array.shape[1] != width):
        raise FormatError(f"{what}: the shape must be {f'(n, {width})' if width else '(n,)'}, not {array.shape}")
    return array
