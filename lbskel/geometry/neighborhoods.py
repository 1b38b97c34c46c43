"""The nearest points of each point of a cloud, found once for all that asks for them."""

from __future__ import annotations

__all__ = ["Neighborhoods"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

N_NEAREST = 41  # as many as any caller asks for: each point and the 40 that an outlier is compared with


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
    def tree(self) -> cKDTree:
        """Search tree of the points."""
        return cKDTree(self.points)

    @cached_property
    def _table(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        k = min(N_NEAREST, len(self.points))
        distances, neighbors = self.tree.query(self.points, k=k)
        return distances.reshape(-1, k), neighbors.reshape(-1, k)

    def nearest(self, k: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(n, k) distances of the nearest points, and their numbers; a point is its own first, all if there are fewer.

        Parameters
        ----------
        k : int
            At most N_NEAREST.
        """
        distances, neighbors = self._table
        return distances[:, :k], neighbors[:, :k]
