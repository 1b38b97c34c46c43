"""Ground truth: the curve skeleton that a shape is built around, and the shape's mesh together with it."""

from __future__ import annotations

__all__ = ["Shape", "Truth"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.skeleton.skeleton import Skeleton


@dataclass(frozen=True, eq=False, repr=False)
class Truth(Skeleton):
    """A skeleton that is known because the shape was built around it: straight edges, along which the radius is linear.

    Curved axes are finely sampled. A tip is the center of the last inscribed sphere, one radius inside the surface.
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
        """Sample every branch evenly, both ends included.

        Parameters
        ----------
        spacing : float
            Largest distance between neighboring points of a branch, in the units of the shape.

        Returns
        -------
        points : (p, 3) array of float
            Positions on the edges, branch by branch.
        radii : (p,) array of float
            Interpolated radii.
        """
        points, radii = [], []
        for path in self.branches:
            arc_length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(self.nodes[path], axis=0), axis=1)))
            sampled = np.linspace(0.0, arc_length[-1], int(np.ceil(arc_length[-1] / spacing)) + 1)
            points.append(np.stack([np.interp(sampled, arc_length, axis) for axis in self.nodes[path].T], axis=1))
            radii.append(np.interp(sampled, arc_length, self.radii[path]))
        return np.concatenate(points), np.concatenate(radii)


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh with the skeleton that it was built around.

    Parameters
    ----------
    mesh : Mesh
    truth : Truth
        In the coordinates of the mesh.
    name : str
        Key in :data:`lbskel.shapes.SHAPES`, or the kind of a shape that is not in it.
    """

    mesh: Mesh
    truth: Truth
    name: str
