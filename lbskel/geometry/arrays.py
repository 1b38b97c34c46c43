"""Validation of coordinate and index arrays, read-only arrays, and arrays as values for JSON."""

from __future__ import annotations

__all__ = ["checked_points", "checked_triangles", "finite_numbers", "read_only", "to_builtin"]

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import MeshError, first_few

EMPTY = {"vertices": "the mesh is empty: ", "points": "the cloud is empty: "}  # the beginning of a message


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it.

    Parameters
    ----------
    array : ndarray
        Changed in place.
    """
    array.setflags(write=False)
    return array


def to_builtin(value: Any) -> Any:
    """Convert numpy scalars and arrays inside a value to Python's, and numbers that are not finite to None, for JSON.

    Parameters
    ----------
    value : object
        Mappings, lists and tuples are converted too.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): to_builtin(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [to_builtin(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def checked_points(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """Copy coordinates to a read-only (n, 3) float64 array.

    Parameters
    ----------
    values : (n, 3) array_like of float
    what : str
        Their name in messages, in the plural.

    Raises
    ------
    MeshError
        If there are none, the shape is another, or a coordinate is complex or not finite; the message names the rows.
    """
    points = np.array(_real_numbers(values, what), order="C")
    if points.size == 0:
        raise MeshError(f"{EMPTY.get(what, '')}there are no {what}")
    if points.ndim != 2 or points.shape[1] != 3:
        hint = "; for a planar shape add a column of zeros" if points.ndim == 2 and points.shape[1] == 2 else ""
        raise MeshError(f"{what} must have shape (n, 3), not {points.shape}{hint}")
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        faces = " with their faces" if what == "vertices" else ""
        raise MeshError(f"{what} {first_few(bad)} have NaN or infinite coordinates, counted from 0; remove them{faces}")
    return read_only(points)


def refuse_masked(values: ArrayLike, what: str) -> None:
    """Raise MeshError for an array with masked entries, which would count as numbers.

    Parameters
    ----------
    values : array_like
    what : str
        Their name in messages, in the plural.
    """
    if np.ma.is_masked(values):
        raise MeshError(f"{what} have masked entries; leave these out, or give them numbers")


def _real_numbers(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """Return real numbers as a float64 array, without a copy if they are one; raise MeshError if they are not real."""
    refuse_masked(values, what)
    try:
        given = np.asarray(values)
        if given.dtype.kind != "c":  # whose imaginary parts would be dropped
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(f"{what} must be an array of numbers: {error}") from None
    raise MeshError(f"{what} must be real numbers, not complex ones")


def finite_numbers(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """Return finite numbers as a float64 array of any shape; raise MeshError if they are something else.

    Parameters
    ----------
    values : array_like of float
    what : str
        Their name in messages, in the plural.
    """
    numbers = _real_numbers(values, what)
    if not np.isfinite(numbers).all():
        raise MeshError(f"{what} must be finite numbers, not NaN or infinite")
    return numbers


def checked_triangles(values: ArrayLike, n_vertices: int) -> NDArray[np.int64]:
    """Copy vertex indices to a read-only (m, 3) int64 array.

    Parameters
    ----------
    values : (m, 3) array_like of int
    n_vertices : int

    Raises
    ------
    MeshError
        If there are none, the shape is another, or an index is not whole or out of range; the message names the faces.
    """
    refuse_masked(values, "faces")
    try:
        given = np.asarray(values)
    except ValueError:  # rows of different lengths
        raise MeshError(
            "faces must have shape (m, 3), not rows of different lengths; as_mesh() cuts polygons"
        ) from None
    if given.size == 0:
        raise MeshError("the mesh is empty: it has no faces; a set of points is a PointCloud")
    if given.ndim != 2 or given.shape[1] != 3:
        raise MeshError(f"faces must have shape (m, 3), not {given.shape}; as_mesh() triangulates quads")
    if given.dtype.kind not in "iu" and not (given.dtype.kind == "f" and np.all(given == np.floor(given))):
        raise MeshError(f"faces must be whole numbers, not {given.dtype}")
    faces = np.array(given, dtype=np.int64, order="C")
    if faces.min() < 0 or faces.max() >= n_vertices:
        bad = np.flatnonzero(((faces < 0) | (faces >= n_vertices)).any(axis=1))
        raise MeshError(
            f"faces {first_few(bad)} use a vertex index outside 0..{n_vertices - 1}; "
            "indices are 0-based, subtract 1 from those of a 1-based file"
        )
    return read_only(faces)
