"""Faces in a tree of boxes, so that a search leaves out most of a mesh at a glance.

The faces of each box are parted across its longest side, half and half, as libigl does it; but the tree is complete and
has no pointers, and a leaf has a few faces. It is built in a third of the time of libigl's and searched in two thirds
(measured), and its rays meet faces of any size: libigl's pass through those with an area under some 1e-6.
"""

from __future__ import annotations

__all__ = ["AABBTree", "build_aabb_tree"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.bvh import bounding_boxes, nearest_points, spatial_order
from lbskel._kernels.ray_casting import first_hits, winding_numbers

ROUNDING = 1e-12  # of the largest coordinate, by which each box is larger, so that none is missed by rounding


@dataclass(frozen=True, eq=False)
class AABBTree:
    """Triangles in a tree.

    Parameters
    ----------
    order : (m,) array of int
        The faces, leaf by leaf.
    corners : (m, 9) array of float
        The three corners of each, in that order.
    bounds : (2 p, 6) array of float
        The lowest and the highest corner of each box: row 1 is the root, those of row i are rows 2 i and 2 i + 1, and
        the last half are leaves.
    """

    order: NDArray[np.int64]
    corners: NDArray[np.float64]
    bounds: NDArray[np.float64]

    def nearest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(k,) distance of each point from the faces, and (k, 3) the place on them that is nearest."""
        return nearest_points(self.corners, self.bounds, np.ascontiguousarray(points, dtype=np.float64))

    def windings(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """(k,) how often the faces wind round each point, where they are closed and oriented alike.

        They are counted along a ray: those that it leaves by, less those that it enters by. Sides that it runs through
        belong to one of their two faces: Haines 1994, "Point in polygon strategies", Graphics Gems IV, pages 24 to 46.
        """
        return winding_numbers(self.corners, self.bounds, np.ascontiguousarray(points, dtype=np.float64))

    def first_hits(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(k,) the face that each ray meets first, or -1, and how many lengths of its direction on; infinite for none.

        Möller, Trumbore 1997, "Fast, minimum storage ray/triangle intersection",
        https://doi.org/10.1080/10867651.1997.10487468.
        """
        rays = (np.ascontiguousarray(each, dtype=np.float64) for each in (origins, directions))
        return first_hits(self.corners, self.order, self.bounds, *rays)


def build_aabb_tree(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> AABBTree:
    """The tree of some triangles."""
    order = spatial_order(vertices, faces)
    return AABBTree(order, *bounding_boxes(vertices, faces, order, ROUNDING * float(np.abs(vertices).max())))
