"""Point clouds as frozen values, validated when they are made."""

from __future__ import annotations

__all__ = ["PointCloud"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import counted
from lbskel.geometry.arrays import checked_points
from lbskel.geometry.exchange import CloudExchange


@dataclass(frozen=True, eq=False)
class PointCloud(CloudExchange):
    """Points sampled from a surface: validated, read-only.

    Parameters
    ----------
    points : (n, 3) array_like of float
        In the caller's units.

    Raises
    ------
    MeshError
        If there is no point or a coordinate is not finite.

    Examples
    --------
    >>> import lbskel
    >>> lbskel.PointCloud([[0, 0, 0], [1, 2, 3]])
    PointCloud(2 points)
    """

    points: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", checked_points(self.points, "points"))

    def __repr__(self) -> str:
        return f"PointCloud({counted(len(self.points), 'point')})"
