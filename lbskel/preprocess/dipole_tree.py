"""The smooth winding number of oriented points: near 1 inside the surface that they were sampled from, near 0 outside.

Each point is a dipole, its area times its normal, smoothed over a length of its own; the field is a solution of
Poisson's equation for the smoothed normals, as in Kazhdan, Bolitho, Hoppe 2006, "Poisson surface reconstruction",
https://doi.org/10.2312/SGP/SGP06/061-070, without a grid. Where points are missing the field is harmonic, which closes
the hole.
"""

from __future__ import annotations

__all__ = ["DipoleTree", "leaf_order"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.dipoles import dipole_field
from lbskel.geometry.deadline import in_slices

LEAF = 8  # points in a leaf; a guess
# Lower bound on the distance of a node that counts as one dipole, in its radii, which bounds the error of the field:
# with 3.5 clouds are a twentieth more accurate and take longer, with 1.75 a twelfth less accurate;
# benchmarks/results/point_constants.md
OPENING = 2.5


def leaf_order(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(p * LEAF,) numbers of the points in the order of a tree's leaves; -1, the last point, fills up the last leaves.

    Parameters
    ----------
    points : (n, 3) array of float
    """
    n = len(points)
    size = LEAF << max(int(np.ceil(np.log2(n / LEAF))), 0)
    order = np.arange(size)
    P = points.T.take(np.minimum(order, n - 1), axis=1)
    order[n:] = -1
    while size > LEAF:  # halve each node across the widest side of its box
        parts = P.reshape(3, -1, size)
        axis = np.argmax(np.ptp(parts, axis=2), axis=0)
        along = parts[axis, np.arange(len(axis))]
        place = (np.argpartition(along, size // 2, axis=1) + np.arange(0, len(order), size)[:, None]).ravel()
        order, P, size = order[place], P.take(place, axis=1), size // 2
    return order


@dataclass(frozen=True, eq=False)
class DipoleTree:
    """Oriented points in a search tree.

    Parameters
    ----------
    nodes, leaves : array of float
        As for :func:`lbskel._kernels.dipoles.dipole_field`.
    order : (p * LEAF,) array of int
        Numbers of the points in the leaves, by :func:`leaf_order`.
    """

    nodes: NDArray[np.float64]
    leaves: NDArray[np.float64]
    order: NDArray[np.int64]

    @classmethod
    def of(
        cls,
        points: NDArray[np.float64],
        moments: NDArray[np.float64],
        widths: NDArray[np.float64],
        order: NDArray[np.int64],
    ) -> DipoleTree:
        """Build the tree of dipoles.

        Parameters
        ----------
        points : (n, 3) array of float
        moments : (n, 3) array of float
            Outward normals, each as long as the area of its point.
        widths : (n,) array of float
            Lengths over which the dipoles are smoothed.
        order : (p * LEAF,) array of int
            Order of the points in the leaves, by :func:`leaf_order`.
        """
        p, is_filler = len(order) // LEAF, order < 0
        data = np.column_stack([points, moments, widths**2])[order]
        data[is_filler, 3:6] = 0
        P, M, squares = np.split(np.ascontiguousarray(data.T), [3, 6])
        weight = np.linalg.norm(M, axis=0)
        sums = np.concatenate([weight * P, M, weight * squares, weight[None]]).reshape(8, p, LEAF).sum(axis=2)
        nodes = np.zeros((2 * p, 8))
        first = p
        while first >= 1:
            parts = P.reshape(3, first, -1)
            known = sums[7] > 0
            divisor = np.where(known, sums[7], 1.0)
            center = np.where(known, sums[:3] / divisor, parts[:, :, 0])
            level = nodes[first : 2 * first]
            level[:, :3], level[:, 3:6], level[:, 6] = center.T, sums[3:6].T, sums[6] / divisor
            level[:, 7] = np.sqrt(((parts - center[:, :, None]) ** 2).sum(axis=0).max(axis=1))
            first, sums = first // 2, sums[:, ::2] + sums[:, 1::2]
        return cls(nodes, np.ascontiguousarray(data), order)

    def values(self, queries: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """(q,) winding numbers at some positions, or at the points themselves.

        Parameters
        ----------
        queries : (q, 3) array of float, optional
        """
        return (self._field_at_points(has_gradient=False) if queries is None else self._field(queries))[:, 0]

    def gradients(self) -> NDArray[np.float64]:
        """(n, 3) gradients of the winding number at the points."""
        return self._field_at_points(has_gradient=True)[:, 1:]

    def _field_at_points(self, *, has_gradient: bool) -> NDArray[np.float64]:
        """(n, 4) or (n, 1) field at the points, found in the order of the leaves, where each is near the one before."""
        is_point = self.order >= 0
        in_order = self._field(self.leaves[is_point, :3], has_gradient=has_gradient)
        field = np.empty_like(in_order)
        field[self.order[is_point]] = in_order
        return field

    def _field(self, queries: NDArray[np.float64], *, has_gradient: bool = False) -> NDArray[np.float64]:
        """(q, 4) winding numbers and their gradients, or (q, 1) winding numbers."""
        (field,) = in_slices(
            lambda some: (dipole_field(self.nodes, self.leaves, some, LEAF, OPENING, has_gradient),),
            np.ascontiguousarray(queries),
        )
        return field
