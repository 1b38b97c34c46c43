"""Vertex and face arrays of the mesh objects of other packages, and triangulation of polygons.

The packages are not imported; their objects are recognized by their attributes.
"""

from __future__ import annotations

__all__ = ["arrays_of", "triangulate"]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, first_few

# Corners of faces, by the names of meshio and the numbers of VTK
N_CORNERS: dict[Any, int] = {
    **dict.fromkeys(("triangle", "triangle6", "triangle7", 5), 3),
    **dict.fromkeys(("quad", "quad8", "quad9", 9), 4),
}


def arrays_of(data: Any) -> tuple[Any, Any]:
    """Extract vertices and faces, unchecked, from a pair or from a trimesh, pyvista or meshio mesh.

    Parameters
    ----------
    data : pair of array_like, or mesh object

    Raises
    ------
    MeshError
        If it is none of these, or its flat list of polygons is malformed.
    """
    if isinstance(data, tuple | list) and len(data) == 2:
        return data[0], data[1]
    if hasattr(data, "vertices") and hasattr(data, "faces"):  # trimesh, PyGEL, skeletor
        return data.vertices, data.faces
    if hasattr(data, "points") and hasattr(data, "cells_dict"):  # meshio, or an unstructured grid of pyvista
        blocks = [_corners(kind, cells) for kind, cells in data.cells_dict.items() if _is_flat(kind)]
        return data.points, [row for block in blocks for row in block] if len(blocks) > 1 else (blocks or [[]])[0]
    if hasattr(data, "points") and hasattr(data, "faces"):  # pyvista
        faces = np.asarray((data.triangulate() if getattr(data, "n_strips", 0) else data).faces)
        return data.points, _rows_of_flat(faces) if faces.ndim == 1 else faces
    raise MeshError(
        f"cannot take a mesh from {type(data).__name__}; "
        "give (vertices, faces), a path, or an object with .vertices and .faces"
    )


def _is_flat(kind: Any) -> bool:
    """Whether a kind of cells is a face, by its name in meshio or its number in VTK."""
    return kind in N_CORNERS or str(kind).startswith("polygon")


def _corners(kind: Any, cells: Any) -> Any:
    """Take the corners of faces, without the nodes on their sides and in their middles."""
    return cells[:, : N_CORNERS[kind]] if kind in N_CORNERS else cells


def _rows_of_flat(flat: NDArray[Any]) -> list[NDArray[Any]]:
    """Split a flat list of polygons, each preceded by its number of corners."""
    rows, position = [], 0
    while position < len(flat):
        size = int(flat[position])
        if size < 1:
            raise MeshError(f"entry {position} of the faces must be a number of corners, not {size}")
        rows.append(flat[position + 1 : position + 1 + size])
        position += size + 1
    return rows


def triangulate(faces: Any) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Triangulate polygons as fans from their first corners.

    Parameters
    ----------
    faces : (m, k) array of int, or sequence of index sequences
        In rows of more than three corners, -1 at the end means that there is no corner.

    Returns
    -------
    triangles : (t, 3) array of int
    polygon : (t,) array of int
        The polygon that each triangle came from.

    Raises
    ------
    MeshError
        If a polygon has fewer than three corners, or the faces are not a sequence of index sequences.
    """
    corners, sizes = _flat_polygons(faces)
    small = np.flatnonzero(sizes < 3)
    if len(small):
        raise MeshError(f"faces {first_few(small)} have fewer than three corners; leave them out")
    n_triangles = sizes - 2
    first = np.repeat(np.cumsum(sizes) - sizes, n_triangles)
    step = np.arange(n_triangles.sum()) - np.repeat(np.cumsum(n_triangles) - n_triangles, n_triangles)
    triangles = corners[np.stack([first, first + step + 1, first + step + 2], axis=1)]
    return triangles, np.repeat(np.arange(len(n_triangles)), n_triangles)


def _flat_polygons(faces: Any) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Concatenate the corners of all polygons, and count those of each."""
    try:
        given = np.asarray(faces)
    except ValueError:  # polygons of different sizes
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
