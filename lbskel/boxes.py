"""Faces in a tree of boxes, so that a search leaves out most of a mesh at a glance.

Faces are put along a curve that fills space (Morton 1966, "A computer oriented geodetic data base") by their first
corners; each run of a few is a leaf, and each two nodes in a row have one above them. That is built in a tenth of the
time of a tree split by medians, and is searched as fast (measured against libigl's, whose rays miss faces with an area
under some 1e-6).
"""

from __future__ import annotations

__all__ = ["Boxes", "boxes_of"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.kernels.rays import first_hits
from lbskel.kernels.trees import nearest_places, tree_of
from lbskel.ordering import stable_order

BITS = 10  # of each coordinate along the curve
ROUNDING = 1e-12  # of the largest coordinate, by which each box is larger, so that none is missed by rounding


@dataclass(frozen=True, eq=False)
class Boxes:
    """Triangles in a tree.

    Parameters
    ----------
    order : (m,) array of int
        The faces along the curve.
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
        return nearest_places(self.corners, self.bounds, np.ascontiguousarray(points))

    def first_hits(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(k,) the face that each ray meets first, or -1, and how many lengths of its direction on; infinite for none.

        Möller, Trumbore 1997, "Fast, minimum storage ray/triangle intersection",
        https://doi.org/10.1080/10867651.1997.10487468.
        """
        rays = np.ascontiguousarray(origins), np.ascontiguousarray(directions)
        return first_hits(self.corners, self.order, self.bounds, *rays)


def _along_curve(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) place of points along the curve."""
    low, size = points.min(axis=0), np.ptp(points, axis=0).max()
    cells = ((points - low) * ((2**BITS - 1) / size if size > 0 else 0.0)).astype(np.int64)
    numbers = np.arange(2**BITS)
    spread = np.sum([(numbers >> bit & 1) << (3 * bit) for bit in range(BITS)], axis=0)
    return spread[cells[:, 0]] | spread[cells[:, 1]] << 1 | spread[cells[:, 2]] << 2


def boxes_of(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Boxes:
    """The tree of some triangles."""
    order = stable_order(_along_curve(vertices)[faces[:, 0]])
    return Boxes(order, *tree_of(vertices, faces, order, ROUNDING * float(np.abs(vertices).max())))
