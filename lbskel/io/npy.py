"""NPY and NPZ, the binary formats of numpy, with an (n, 3) array of points: further columns are ignored.

An NPZ file has the array under the name ``points``, or no other array.
"""

from __future__ import annotations

__all__ = ["encode_npy", "read_npy", "read_npz"]

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import as_floats, read_bytes


def read_npy(path: Path) -> PolygonSoup:
    """Read the points of an NPY file."""
    loaded = _load(path)
    if not isinstance(loaded, np.ndarray):
        raise FormatError("not an NPY file: it holds several arrays; name it .npz")
    return _points_of(loaded)


def encode_npy(values: NDArray[Any]) -> bytes:
    """Encode an array as an NPY file."""
    data = io.BytesIO()
    np.save(data, values, allow_pickle=False)
    return data.getvalue()


def read_npz(path: Path) -> PolygonSoup:
    """Read the points of an NPZ file."""
    loaded = _load(path)
    if isinstance(loaded, np.ndarray):
        raise FormatError("not an NPZ file: it holds one array; name it .npy")
    with loaded:
        names = ["points"] if "points" in loaded.files else loaded.files
        if len(names) != 1:
            raise FormatError(
                f"has no array 'points' but {', '.join(names) or 'nothing'}; save the points by that name"
            )
        try:
            return _points_of(loaded[names[0]])
        except ValueError as error:
            raise FormatError(f"the array {names[0]!r} cannot be read: {error}") from None


def _load(path: Path) -> Any:
    """Load the file without its pickles, which could run any code."""
    data = read_bytes(path)
    try:
        return np.load(io.BytesIO(data), allow_pickle=False)
    except (ValueError, EOFError, OSError) as error:
        raise FormatError(f"not a file of numpy arrays: {error}") from None


def _points_of(array: Any) -> PolygonSoup:
    if array.ndim != 2 or array.shape[1] < 3 or array.dtype.kind not in "iuf":
        raise FormatError(f"points need an (n, 3) array of numbers, not one of {array.dtype} and shape {array.shape}")
    return PolygonSoup(as_floats(array[:, :3], "points", 3))
