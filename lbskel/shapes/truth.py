"""The curve skeleton that a shape was built around, and the pair of that and a mesh."""

from __future__ import annotations

__all__ = ["Shape", "Truth"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.skeleton.skeleton import Skeleton


@dataclass(frozen=True, eq=False, repr=False)
class Truth(Skeleton):
    """A skeleton that is known because the shape was built around it: straight edges with a radius linear along each.

    Curved axes are finely sampled. Tips are the centers of the last inscribed spheres, one radius inside the surface.
    """

    @property
    def genus(self) -> int:
        """Number of handles of the shape, which are the cycles of its skeleton."""
        return self.cycle_rank

    @property
    def n_tips(self) -> int:
        """Number of ends of the shape."""
        return len(self.tips)

    def sample(self, spacing: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points evenly along every branch, both of its ends included, at most ``spacing`` apart, and their radii.

        Returns
        -------
        points : (p, 3) array of float
        radii : (p,) array of float
        """
        points, radii = [], []
        for path in self.branches:
            along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(self.nodes[path], axis=0), axis=1)))
            at = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / spacing)) + 1)
            points.append(np.stack([np.interp(at, along, axis) for axis in self.nodes[path].T], axis=1))
            radii.append(np.interp(at, along, self.radii[path]))
        return np.concatenate(points), np.concatenate(radii)


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh with the skeleton that it was built around."""

    mesh: Mesh
    truth: Truth
    name: str
