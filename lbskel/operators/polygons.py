"""Polygon meshes and their cotangent Laplacian by virtual refinement: quads need no triangulation.

Each polygon gets a virtual point, the affine combination of its corners that minimizes the sum of the squared areas of
the triangle fan around it. L = P^T L_fan P, where P maps values at the corners to values at the corners and virtual
points. On triangles this is the cotangent Laplacian. Bunge, Herholz, Kazhdan, Botsch 2020, "Polygon Laplacian made
simple", https://doi.org/10.1111/cgf.13931; by libigl.
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

from lbskel.errors import MeshError, counted, first_few
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import PointCloud
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import EPSILON, MAX_COTANGENT, MAX_HEIGHT


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """A mesh of polygons, checked and read-only.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Positions, in the caller's units.
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
        try:
            polygons = tuple(_whole_numbers(polygon, i) for i, polygon in enumerate(self.polygons))
        except TypeError:
            raise MeshError("polygons must be a sequence of sequences of vertex indices") from None
        if not polygons:
            raise MeshError("there is no polygon; give at least one")
        small = [i for i, polygon in enumerate(polygons) if polygon.ndim != 1 or len(polygon) < 3]
        if small:
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
        return f"PolygonMesh({counted(len(self.vertices), 'vertex')}, {counted(len(self.polygons), 'polygon')})"

    @cached_property
    def corners(self) -> NDArray[np.int64]:
        """(c,) vertex indices of all polygons, concatenated."""
        return read_only(np.concatenate(self.polygons))

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(m + 1,) index into :attr:`corners` where each polygon starts, and the end of the last one."""
        return read_only(np.concatenate([[0], np.cumsum([len(np.asarray(polygon)) for polygon in self.polygons])]))


def _whole_numbers(polygon: ArrayLike, number: int) -> NDArray[np.int64]:
    """Return a read-only copy of the vertex indices of a polygon; a MeshError names it by its number."""
    try:
        given = np.array(polygon, dtype=np.float64)
        if not (given == np.floor(given)).all():
            raise ValueError
    except (TypeError, ValueError):
        raise MeshError(f"polygon {number} must be a list of whole numbers, not {polygon!r}") from None
    return read_only(given.astype(np.int64))


def _degenerate_polygons(
    vertices: NDArray[np.float64], mesh: PolygonMesh, rounding: float
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Find the (m,) degenerate polygons, and the area of each corner, given the rounding of the coordinates.

    Degenerate is a polygon that uses a vertex twice, is on a line up to the rounding of the coordinates, or whose own
    matrix has entries beyond MAX_COTANGENT or NaN.

    If virtual refinement gives a strongly bent or dented polygon a negative corner area, its area is divided evenly.
    """
    n, sizes = len(mesh.corners), np.diff(mesh.starts)
    stiffness, mass, _ = (csc_array(part) for part in igl.cotmatrix(vertices[mesh.corners], np.arange(n), mesh.starts))
    entries = stiffness.tocoo()
    is_beyond = np.where(np.abs(entries.data) <= MAX_COTANGENT, 0.0, 1.0)
    polygon = np.searchsorted(mesh.starts, entries.row, side="right") - 1
    areas = mass.diagonal()
    even_areas = np.repeat(np.add.reduceat(areas, mesh.starts[:-1]) / sizes, sizes)
    has_negative = np.repeat(np.minimum.reduceat(areas, mesh.starts[:-1]) < 0, sizes)
    is_repeated = np.array([len(set(polygon.tolist())) < len(polygon) for polygon in map(np.asarray, mesh.polygons)])
    has_beyond = np.bincount(polygon, weights=is_beyond, minlength=len(sizes)) > 0
    is_degenerate = is_repeated | has_beyond | _is_on_a_line(vertices, mesh, rounding)
    return is_degenerate, np.where(has_negative, even_areas, areas)


def _is_on_a_line(vertices: NDArray[np.float64], mesh: PolygonMesh, rounding: float) -> NDArray[np.bool_]:
    """Return the (m,) mask of polygons whose fan around the mean of their corners is as flat as a degenerate face."""
    P, sizes = vertices[mesh.corners], np.diff(mesh.starts)
    following = np.arange(1, len(P) + 1)
    following[mesh.starts[1:] - 1] = mesh.starts[:-1]
    sides, center = P[following] - P, np.add.reduceat(P, mesh.starts[:-1]) / sizes[:, None]
    double_areas = np.linalg.norm(np.cross(P - np.repeat(center, sizes, axis=0), sides), axis=1)
    heights = MAX_HEIGHT * rounding * np.linalg.norm(sides, axis=1)
    is_flat: NDArray[np.bool_] = np.add.reduceat(double_areas - heights, mesh.starts[:-1]) <= 0
    return is_flat


def polygon_cotangent(mesh: PolygonMesh) -> Laplacian:
    """Build the cotangent Laplacian by virtual refinement with its lumped mass; degenerate polygons are left out.

    The mass of a polygon is the sum of the areas of its fan of triangles. Where the virtual point does not see all
    sides of a concave polygon these overlap, and the mass is larger than the polygon's area: 9 for a U of area 7.
    Divide such polygons for masses that sum to the area.

    Parameters
    ----------
    mesh : PolygonMesh
    """
    # the virtual points of libigl are exact to the size of the coordinates
    low, high = (bound(mesh.vertices[mesh.corners], axis=0) for bound in (np.min, np.max))
    V, k = unit_scale(mesh.vertices - (low / 2 + high / 2))
    rounding = EPSILON * float(np.ldexp(max(np.abs(low).max(), np.abs(high).max()), -k))
    degenerate, areas = _degenerate_polygons(V, mesh, rounding)
    n = len(V)
    valid = [polygon for polygon, bad in zip(mesh.polygons, degenerate, strict=True) if not bad]
    is_degenerate_corner = np.repeat(degenerate, np.diff(mesh.starts))
    treated = np.unique(mesh.corners[is_degenerate_corner])
    if not valid:
        return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=treated)
    kept = PolygonMesh(mesh.vertices, valid)
    negative = csc_array(igl.cotmatrix(V, kept.corners, kept.starts)[0])
    masses = np.bincount(kept.corners, weights=areas[~is_degenerate_corner], minlength=n)
    return Laplacian(-negative, diagonal_matrix(np.ldexp(masses, 2 * k)), treated_vertices=treated)
