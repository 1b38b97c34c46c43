"""The smooth winding number of oriented points: near 1 inside the surface that they were sampled from, near 0 outside.

Each point is a dipole, its area times its normal, smoothed over a length of its own; the field is a solution of
Poisson's equation for the smoothed normals, as in Kazhdan, Bolitho, Hoppe 2006, "Poisson surface reconstruction",
https://doi.org/10.2312/SGP/SGP06/061-070, without a grid. It closes holes as their harmonic continuation does.
"""

from __future__ import annotations

__all__ = ["DipoleTree", "leaf_order"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.dipoles import dipole_field
from lbskel.geometry.deadline import in_slices

LEAF = 8  # points in a leaf; a guess
OPENING = (
    2.5  # distance of a node, in its radii, beyond which it counts as one dipole; it bounds the error of the field,
)
# near 0.03; benchmarks/results/point_constants.md


def leaf_order(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(p * LEAF,) number of each point in the leaves of a tree; what fills up the last leaves is -1, the last point.

    Parameters
    ----------
    points : (n, 3) array of float
    """
    n = len(points)
    size = LEAF << max(int(np.ceil(np.log2(n / LEAF))), 0)
    order = np.arange(size)
    P = points[np.minimum(order, n - 1)]
    order[n:] = -1
    while size > LEAF:  # halve each node across the widest side of its box
        parts = P.reshape(-1, size, 3)
        axis = np.argmax(np.ptp(parts, axis=1), axis=1)
        along = np.take_along_axis(parts, axis[:, None, None], axis=2)[..., 0]
        place = np.argpartition(along, size // 2, axis=1) + np.arange(0, len(P), size)[:, None]
        order, P, size = order[place.ravel()], P[place.ravel()], size // 2
    return order


@dataclass(frozen=True, eq=False)
class DipoleTree:
    """Oriented points in a search tree.

    Parameters
    ----------
    nodes, leaves : array of float
        As for :func:`lbskel._kernels.dipoles.dipole_field`.
    """

    nodes: NDArray[np.float64]
    leaves: NDArray[np.float64]

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
        order : array of int
            Of the points in the leaves, by :func:`leaf_order`.
        """
        p, is_filler = len(order) // LEAF, order < 0
        data = np.column_stack([points, moments, widths**2])[order]
        data[is_filler, 3:6] = 0
        nodes = np.zeros((2 * p, 8))
        weight = np.linalg.norm(data[:, 3:6], axis=1)
        sums = np.column_stack([weight[:, None] * data[:, :3], data[:, 3:6], weight * data[:, 6], weight])
        first, size = p, LEAF
        while first >= 1:
            groups, P = sums.reshape(first, size, 8).sum(axis=1), data[:, :3].reshape(first, size, 3)
            known = groups[:, 7:] > 0
            divisor = np.where(known, groups[:, 7:], 1.0)
            center = np.where(known, groups[:, :3] / divisor, P.mean(axis=1))
            level = nodes[first : 2 * first]
            level[:, :3], level[:, 3:6], level[:, 6] = center, groups[:, 3:6], groups[:, 6] / divisor[:, 0]
            level[:, 7] = np.sqrt(((P - center[:, None]) ** 2).sum(axis=2).max(axis=1))
            first, size = first // 2, size * 2
        return cls(nodes, np.ascontiguousarray(data))

    def field(self, queries: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(q,) winding numbers and (q, 3) their gradients.

        Parameters
        ----------
        queries : (q, 3) array of float
        """
        queries = np.ascontiguousarray(queries)
        (values,) = in_slices(lambda some: (dipole_field(self.nodes, self.leaves, some, LEAF, OPENING),), queries)
        return values[:, 0], values[:, 1:]
