"""What a mesh file holds, before it is a Mesh: points, and polygons of any number of corners, unchecked."""

from __future__ import annotations

__all__ = ["Polygons", "mesh_of"]

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, as_mesh, first_few


def _no_indices() -> NDArray[np.int64]:
    """What a file without faces has."""
    return np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Polygons:
    """Points and polygons as a file lists them.

    Parameters
    ----------
    points : (n, 3) array of float
    corners : (c,) array of int
        0-based vertex indices of the corners, one polygon after the other.
    sizes : (m,) array of int
        How many corners each polygon has.
    notes : tuple of str
        What was done on the way in.
    first_index : int
        The number that the file gives its first vertex, for messages.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.int64] = field(default_factory=_no_indices)
    sizes: NDArray[np.int64] = field(default_factory=_no_indices)
    notes: tuple[str, ...] = ()
    first_index: int = 0


def mesh_of(polygons: Polygons) -> Mesh:
    """The Mesh of some polygons, all vertices kept in their order, polygons cut into triangles.

    Raises
    ------
    MeshError
        If a polygon names a vertex that does not exist or has fewer than three corners, or Mesh refuses the rest.
    """
    n, sizes, first = len(polygons.points), polygons.sizes, polygons.first_index
    if polygons.corners.min(initial=0) < 0 or polygons.corners.max(initial=-1) >= n:
        is_astray = (polygons.corners < 0) | (polygons.corners >= n)
        astray = np.unique(np.repeat(np.arange(len(sizes)), sizes)[is_astray])
        raise MeshError(
            f"faces {first_few(astray)} (counted from 0) name vertices that do not exist; "
            f"the file has {n} vertices, numbered {first} to {n - 1 + first}"
        )
    small = np.flatnonzero(sizes < 3)
    if len(small):
        raise MeshError(f"faces {first_few(small)} (counted from 0) have fewer than three corners")
    if (sizes == 3).all():
        return Mesh(polygons.points, polygons.corners.reshape(-1, 3), polygons.notes)
    if len(np.unique(sizes)) > 1:
        faces: Any = np.split(polygons.corners, np.cumsum(sizes)[:-1])
    else:
        faces = polygons.corners.reshape(-1, sizes[0])
    mesh = as_mesh((polygons.points, faces))
    return replace(mesh, notes=polygons.notes + mesh.notes) if polygons.notes else mesh
