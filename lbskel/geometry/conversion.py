"""What users hold, taken apart: mesh objects of packages not imported here, and polygons, which become triangles."""

from __future__ import annotations

__all__ = ["arrays_of", "triangulate"]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, first_few


def arrays_of(data: Any) -> tuple[Any, Any]:
    """Vertices and faces, unchecked, of a pair or of a trimesh, pyvista or meshio mesh.

    Raises
    ------
    MeshError
        If it is none of these.
    """
    if isinstance(data, tuple | list) and len(data) == 2:
        return data[0], data[1]
    if hasattr(data, "vertices") and hasattr(data, "faces"):  # trimesh, PyGEL, skeletor
        return data.vertices, data.faces
    if hasattr(data, "points") and hasattr(data, "cells_dict"):  # meshio
        blocks = [data.cells_dict[kind] for kind in ("triangle", "quad") if kind in data.cells_dict]
        return data.points, [row for block in blocks for row in block] if len(blocks) > 1 else (blocks or [[]])[0]
    if hasattr(data, "points") and hasattr(data, "faces"):  # pyvista
        faces = np.asarray(data.faces)
        return data.points, _rows_of_flat(faces) if faces.ndim == 1 else faces
    raise MeshError(
        f"cannot take a mesh from {type(data).__name__}; "
        "give (vertices, faces), a path, or an object with .vertices and .faces"
    )


def _rows_of_flat(flat: NDArray[Any]) -> list[NDArray[Any]]:
    """The polygons of a flat list that has before each polygon how many corners it has."""
    rows, position = [], 0
    while position < len(flat):
        size = int(flat[position])
        if size < 1:
            raise MeshError(f"entry {position} of the faces must be a number of corners, not {size}")
        rows.append(flat[position + 1 : position + 1 + size])
        position += size + 1
    return rows


def triangulate(faces: Any) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Triangles of polygons, each cut into a fan from its first corner, and the polygon that each came from.

    Takes an (m, k) array, in which -1 at the end of a row of more than three means no corner, or a sequence of index
    sequences.

    Raises
    ------
    MeshError
        If a polygon has fewer than three corners, or it is no such sequence.
    """
    corners, sizes = _flat_polygons(faces)
    small = np.flatnonzero(sizes < 3)
    if len(small):
        raise MeshError(f"faces {first_few(small)} have fewer than three corners; leave them out")
    fans = sizes - 2
    first = np.repeat(np.cumsum(sizes) - sizes, fans)
    along = np.arange(fans.sum()) - np.repeat(np.cumsum(fans) - fans, fans)
    return corners[np.stack([first, first + along + 1, first + along + 2], axis=1)], np.repeat(
        np.arange(len(fans)), fans
    )


def _flat_polygons(faces: Any) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The corners of all polygons one after the other, and how many each has."""
    try:
        given = np.asarray(faces)
    except ValueError:  # polygons of several sizes
        given = np.empty(0, dtype=object)
    if given.dtype.kind in "iuf" and given.ndim == 2:
        k = given.shape[1]
        is_corner = (given != -1) | (k == 3)
        sizes = np.where(is_corner, np.arange(1, k + 1), 0).max(axis=1, initial=0)
        return given[np.arange(k) < sizes[:, None]], sizes
    try:
        polygons = [np.asarray(polygon) for polygon in faces]
    except TypeError:
        raise MeshError(f"faces must be a sequence of index sequences, not {type(faces).__name__}") from None
    if any(polygon.ndim != 1 for polygon in polygons):
        raise MeshError("each face must be a sequence of at least three vertex indices")
    corners = np.concatenate(polygons) if polygons else np.empty(0, dtype=np.int64)
    return corners, np.array([len(polygon) for polygon in polygons], dtype=np.int64)
