"""The nearest points of each point of a cloud, found once and cached."""

from __future__ import annotations

__all__ = ["Neighborhoods"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

# Nearest points of each point, the point itself included: benchmarks/results/point_constants.md
N_NEAREST = 41


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

    def nearest(self, k: int | None = None) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(n, k) distances and (n, k) indices of the nearest points, each point itself first; n columns if n < k.

        Parameters
        ----------
        k : int, optional
            At most N_NEAREST, which is the default.
        """
        distances, neighbors = self._table
        return distances[:, :k], neighbors[:, :k]
