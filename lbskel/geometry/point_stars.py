"""The stars of a point cloud: for each point, the triangles around it in the Delaunay triangulation of its neighbors.

They are triangles like those of a mesh, so that the loop that contracts meshes also contracts a cloud; but each belongs
to its first corner alone, since neighbors need not agree on the triangles between them. Cao, Tagliasacchi,
Olson, Zhang, Su 2010, https://doi.org/10.1109/SMI.2010.25.
"""

from __future__ import annotations

__all__ = ["MIN_VARIATION", "PointStars", "distinct_points", "ring_edges", "surface_variation"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import counted
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import Mesh

# Median surface variation from which on a group of points fills space. Groups of uniform outliers had 0.127 to 0.179,
# sparse parts of surfaces at most 0.02 (measured by hand); the bound is near their geometric mean, and 0.042 and 0.084
# are alike: rows "outliers.MIN_VARIATION" in benchmarks/results/point_constants.md
MIN_VARIATION = 0.06


@dataclass(frozen=True, eq=False, repr=False)
class PointStars(Mesh):
    """Points and the triangles of their stars, each with its center first.

    The triangles of a center follow each other, in their order around it.
    """

    def __repr__(self) -> str:
        return f"PointStars({counted(len(self.vertices), 'point')}, {counted(len(self.faces), 'triangle')})"

    def with_vertices(self, vertices: ArrayLike) -> PointStars:
        """Make the same stars of points at other positions.

        Parameters
        ----------
        vertices : (n, 3) array_like of float
        """
        return PointStars(np.asarray(vertices), self.faces, self.notes)

    @cached_property
    def is_closed(self) -> bool:
        """False: stars enclose no volume."""
        return False

    @cached_property
    def ring_edges(self) -> NDArray[np.int64]:
        """(r, 2) each center with each point of its ring, in order; a closed ring ends with its first point."""
        F = self.faces
        is_last = np.append(F[1:, 0] != F[:-1, 0], True)
        pairs = np.concatenate([F[:, :2], F[is_last][:, [0, 2]]])
        order = np.argsort(np.concatenate([np.arange(len(F)), np.flatnonzero(is_last) + 0.5]), kind="stable")
        return read_only(pairs[order])


def ring_edges(mesh: Mesh) -> NDArray[np.int64]:
    """(r, 2) each vertex with each of its neighbors: along its ring for stars, across its edges for a mesh.

    Parameters
    ----------
    mesh : Mesh
    """
    return mesh.ring_edges if isinstance(mesh, PointStars) else np.concatenate([mesh.edges, mesh.edges[:, ::-1]])


def distinct_points(points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the (m,) first of the points at each place, in ascending order, and (n,) which of these each point is.

    Parameters
    ----------
    points : (n, 3) array of float
    """
    order = np.lexsort(points.T)
    ascending = points[order]
    is_new = np.append(True, (ascending[1:] != ascending[:-1]).any(axis=1))[: len(points)]
    group = np.empty(len(points), dtype=np.int64)
    group[order] = np.cumsum(is_new) - 1
    is_first = np.zeros(len(points), dtype=bool)
    is_first[order[is_new]] = True  # the sort is stable
    first = np.flatnonzero(is_first)
    place = np.empty(len(first), dtype=np.int64)
    place[group[first]] = np.arange(len(first))
    return first, place[group]


def surface_variation(points: NDArray[np.float64], neighbors: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) smallest variance of each of some neighborhoods over the sum of all three: 0 if flat, at most 1/3.

    Pauly, Gross, Kobbelt 2002, https://doi.org/10.1109/VISUAL.2002.1183771.

    Parameters
    ----------
    points : (n, 3) array of float
    neighbors : (k, m) array of int
        The points of each neighborhood.
    """
    offsets = points[neighbors] - points[neighbors].mean(axis=1, keepdims=True)
    variances = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", offsets, offsets))
    variation: NDArray[np.float64] = variances[:, 0] / variances.sum(axis=1)
    return variation
