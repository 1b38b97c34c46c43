"""The coordinates in which a mesh is contracted: its own, centered, at unit size, and mirrored if that is canonical."""

from __future__ import annotations

__all__ = ["UnitFrame"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class UnitFrame:
    """A change of coordinates by translation, uniform scale and reflection.

    Parameters
    ----------
    center : (3,) array of float
        The origin of the unit coordinates, in the caller's.
    scale : float
        The unit of length, in the caller's.
    mirror : (3,) array of float
        Factors on the coordinates, 1 or -1.

    Examples
    --------
    >>> import numpy as np
    >>> frame = UnitFrame(np.array([1.0, 0, 0]), 2.0, np.array([-1.0, 1, 1]))
    >>> frame.to_unit(np.array([[5.0, 0, 4]])).tolist()
    [[-2.0, 0.0, 2.0]]
    """

    center: NDArray[np.float64]
    scale: float
    mirror: NDArray[np.float64]

    def to_unit(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert (k, 3) points in the caller's coordinates to unit coordinates."""
        return (points - self.center) / self.scale * self.mirror

    def from_unit(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert (k, 3) points in unit coordinates to the caller's."""
        return points * self.mirror * self.scale + self.center
