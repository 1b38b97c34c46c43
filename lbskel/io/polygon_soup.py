"""The content of a mesh file before validation: points, and polygons with any number of corners."""

from __future__ import annotations

__all__ = ["PolygonSoup", "mesh_from_polygons"]

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, counted, first_few
from lbskel.geometry.mesh import Mesh, as_mesh


def _no_indices() -> NDArray[np.int64]:
    """Return an empty array, for a file without faces."""
    return np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class PolygonSoup:
    """Points and polygons as a file lists them, not validated.

    Parameters
    ----------
    points : (n, 3) array of float
        Positions, in the units of the file.
    corners : (c,) array of int
        0-based vertex indices of the corners of all polygons, concatenated.
    sizes : (m,) array of int
        Number of corners of each polygon.
    notes : tuple of str
        What the reader changed, one sentence each.
    first_index : int
        Index of the first vertex in the file (0 or 1), for messages.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.int64] = field(default_factory=_no_indices)
    sizes: NDArray[np.int64] = field(default_factory=_no_indices)
    notes: tuple[str, ...] = ()
    first_index: int = 0


def mesh_from_polygons(polygons: PolygonSoup) -> Mesh:
    """Convert to a Mesh: all vertices are kept in their order, polygons are triangulated.

    Parameters
    ----------
    polygons : PolygonSoup

    Raises
    ------
    MeshError
        If a polygon uses a vertex that does not exist or has fewer than three corners, or Mesh rejects the rest.
    """
    n, sizes, first = len(polygons.points), polygons.sizes, polygons.first_index
    if polygons.corners.min(initial=0) < 0 or polygons.corners.max(initial=-1) >= n:
        is_invalid = (polygons.corners < 0) | (polygons.corners >= n)
        invalid = np.unique(np.repeat(np.arange(len(sizes)), sizes)[is_invalid])
        raise MeshError(
            f"faces {first_few(invalid)} (0-based) use vertices that do not exist; "
            f"the file has {counted(n, 'vertex')}, numbered {first} to {n - 1 + first}"
        )
    too_small = np.flatnonzero(sizes < 3)
    if len(too_small):
        raise MeshError(f"faces {first_few(too_small)} (0-based) have fewer than three corners")
    if (sizes == 3).all():
        return Mesh(polygons.points, polygons.corners.reshape(-1, 3), polygons.notes)
    if len(np.unique(sizes)) > 1:
        faces: Any = np.split(polygons.corners, np.cumsum(sizes)[:-1])
    else:
        faces = polygons.corners.reshape(-1, sizes[0])
    mesh = as_mesh((polygons.points, faces))
    return replace(mesh, notes=polygons.notes + mesh.notes) if polygons.notes else mesh
