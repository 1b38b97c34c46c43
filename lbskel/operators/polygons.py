"""Meshes of polygons, and their cotangent Laplacian by virtual refinement: quads need no triangulation.

Each polygon gets a virtual point, the affine combination of its corners that makes the squared areas of the fan of
triangles around it least; L = P^T L_fan P with P that combination. On triangles it is the cotangent Laplacian. Bunge,
Herholz, Kazhdan, Botsch 2020, "Polygon Laplacian made simple", https://doi.org/10.1111/cgf.13931; by libigl.
"""

from __future__ import annotations

__all__ = ["PolygonMesh", "polygon_cotangent"]

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array

from lbskel.errors import MeshError
from lbskel.geometry.mesh import PointCloud, first_few
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import LIMIT


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """A mesh of polygons: what the caller gave, checked, read-only.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
    polygons : (m, k) array_like of int, or sequence of sequences of int
        0-based vertex indices around each polygon, three or more.

    Raises
    ------
    MeshError
        If a coordinate is not finite, an index is out of range, or a polygon has fewer than three corners.

    Examples
    --------
    >>> import lbskel
    >>> square = PolygonMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> lbskel.laplacian(square).stiffness.toarray().round(12)[0]
    array([ 0.75, -0.25, -0.25, -0.25])
    """

    vertices: NDArray[np.float64]
    polygons: Sequence[ArrayLike]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", PointCloud(self.vertices).points)
        polygons = tuple(np.array(polygon, dtype=np.int64) for polygon in self.polygons)
        small = [i for i, polygon in enumerate(polygons) if polygon.ndim != 1 or len(polygon) < 3]
        if small or not polygons:
            raise MeshError(f"polygons {first_few(small)} need at least three vertex indices; leave them out")
        object.__setattr__(self, "polygons", polygons)
        bad = (self.corners < 0) | (self.corners >= len(self.vertices))
        if bad.any():
            faces = np.unique(np.searchsorted(self.starts, np.flatnonzero(bad), side="right") - 1)
            raise MeshError(
                f"polygons {first_few(faces)} use a vertex index outside 0..{len(self.vertices) - 1}; "
                "indices are 0-based, subtract 1 from those of a 1-based file"
            )

    def __repr__(self) -> str:
        return f"PolygonMesh({len(self.vertices)} vertices, {len(self.polygons)} polygons)"

    @cached_property
    def corners(self) -> NDArray[np.int64]:
        """The vertex indices of all polygons, one polygon after the other."""
        return np.concatenate(self.polygons)

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(m + 1,) where each polygon starts in :attr:`corners`, and where the last one ends."""
        return np.concatenate([[0], np.cumsum([len(np.asarray(polygon)) for polygon in self.polygons])])


def _apart(vertices: NDArray[np.float64], mesh: PolygonMesh) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """(m,) polygons whose own matrix has entries beyond LIMIT or none at all, and the area of each of all corners.

    A polygon bent or dented so far that virtual refinement takes area from a corner has it shared out evenly.
    """
    n, sizes = len(mesh.corners), np.diff(mesh.starts)
    stiffness, mass, _ = (csc_array(part) for part in igl.cotmatrix(vertices[mesh.corners], np.arange(n), mesh.starts))
    entries = stiffness.tocoo()
    is_beyond = np.where(np.abs(entries.data) <= LIMIT, 0.0, 1.0)
    polygon = np.searchsorted(mesh.starts, entries.row, side="right") - 1
    areas = mass.diagonal()
    even = np.repeat(np.add.reduceat(areas, mesh.starts[:-1]) / sizes, sizes)
    is_dented = np.repeat(np.minimum.reduceat(areas, mesh.starts[:-1]) < 0, sizes)
    return np.bincount(polygon, weights=is_beyond, minlength=len(sizes)) > 0, np.where(is_dented, even, areas)


def polygon_cotangent(mesh: PolygonMesh) -> Laplacian:
    """The cotangent Laplacian by virtual refinement with its own lumped mass; degenerate polygons have no weight."""
    V, k = unit_scale(mesh.vertices)
    degenerate, areas = _apart(V, mesh)
    n = len(V)
    sound = [polygon for polygon, bad in zip(mesh.polygons, degenerate, strict=True) if not bad]
    at_degenerate = np.repeat(degenerate, np.diff(mesh.starts))
    treated = np.unique(mesh.corners[at_degenerate])
    if not sound:
        return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=treated)
    kept = PolygonMesh(mesh.vertices, sound)
    negative = csc_array(igl.cotmatrix(V, kept.corners, kept.starts)[0])
    masses = np.bincount(kept.corners, weights=areas[~at_degenerate], minlength=n)
    return Laplacian(-negative, diagonal_matrix(np.ldexp(masses, 2 * k)), treated_vertices=treated)
