"""Distances along a surface by unfolding its triangles: nearly exact, and exact where it is flat.

:mod:`lbskel._kernels.unfolding` has the formula. Vertices are visited in a given order until no distance gets smaller;
the heat that arrives from the sources is such an order, so two sweeps do most of it, without a priority queue.
"""

from __future__ import annotations

__all__ = ["UnfoldedSurface"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.unfolding import lower_distances
from lbskel.operators.intrinsic_triangulation import IntrinsicTriangulation

MAX_SWEEPS = 1_000  # a guess, against cycles caused by rounding; seven were the most on nine meshes


class UnfoldedSurface:
    """A triangulation prepared for distances from many sources.

    Parameters
    ----------
    triangulation : IntrinsicTriangulation
        Delaunay, since a front passes over long edges less well.
    n_vertices : int
    """

    def __init__(self, triangulation: IntrinsicTriangulation, n_vertices: int) -> None:
        self._vertex = np.ascontiguousarray(triangulation.faces, dtype=np.int64).ravel()
        self._length = np.ascontiguousarray(triangulation.lengths).ravel()
        self._corners = np.argsort(self._vertex, kind="stable")
        self._first = np.append(0, np.cumsum(np.bincount(self._vertex, minlength=n_vertices)))

    def distance(self, sources: NDArray[np.int64], order: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n,) distance of every vertex to the nearest of the sources; infinite where no triangles lead.

        Parameters
        ----------
        sources : (s,) array of int
        order : (k,) array of int
            The vertices to be reached, about from the nearest to the farthest.
        """
        distances = np.full(len(self._first) - 1, np.inf)
        distances[sources] = 0.0
        lower_distances(self._vertex, self._length, self._first, self._corners, order, distances, MAX_SWEEPS)
        return distances
