"""The nearest points of each point of a cloud, found once and cached, those farther away only where they are needed."""

from __future__ import annotations

__all__ = ["Neighborhoods"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.point_tree import PointTree

# Nearest points of a point that is looked at more closely, the point itself included:
# benchmarks/results/point_constants.md
N_NEAREST = 41
N_TOGETHER = 24  # neighbors of every point that are found in one search: as many as the level of the surface takes


@dataclass(frozen=True, eq=False)
class Neighborhoods:
    """Points with a search tree and their nearest neighbors.

    Parameters
    ----------
    points : (n, 3) array of float
        Distinct.
    """

    points: NDArray[np.float64]

    @cached_property
    def tree(self) -> PointTree:
        """Search tree of the points."""
        return PointTree(self.points)

    def nearest(self, k: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(n, k) distances and (n, k) indices of the nearest points, each point itself first; n columns if n < k.

        Parameters
        ----------
        k : int
        """
        table: tuple[NDArray[np.float64], NDArray[np.int64]] | None = self.__dict__.get("_table")
        if table is None or table[0].shape[1] < min(k, len(self.points)):
            table = self.__dict__["_table"] = self.tree.neighbors(max(k, N_TOGETHER))
        distances, neighbors = table
        return distances[:, :k], neighbors[:, :k]

    @property
    def n_wide(self) -> int:
        """Number of points in a wide neighborhood, the point itself included."""
        return min(N_NEAREST, len(self.points))

    @cached_property
    def _wide(self) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """(n, N_NEAREST) neighbors, and (n,) whether they have been found."""
        n = len(self.points)
        return np.empty((n, self.n_wide), dtype=np.int64), np.zeros(n, dtype=bool)

    def wide(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """(r, N_NEAREST) indices of the nearest points of some points, each point itself first.

        Parameters
        ----------
        rows : (r,) array of int
        """
        neighbors, is_known = self._wide
        missing = rows[~is_known[rows]]
        if len(missing):
            neighbors[missing] = self.tree.nearest(self.points[missing], self.n_wide)[1]
            is_known[missing] = True
        found: NDArray[np.int64] = neighbors[rows]
        return found
