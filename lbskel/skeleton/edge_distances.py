"""Distances of points to the edges of a skeleton: exact closest points on segments, and the radii there."""

from __future__ import annotations

__all__ = ["nearest_on_edges"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.skeleton.skeleton import Skeleton


def nearest_on_edges(
    skeleton: Skeleton, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Find the closest point on the edges of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float

    Returns
    -------
    distances : (n,) array of float
        In the units of the skeleton.
    nearest : (n, 3) array of float
        The closest points: on edges, so that isolated nodes do not count, or nodes if there are no edges at all.
    radii : (n,) array of float
        Radii there, by linear interpolation along the edge.
    """
    simplices = skeleton.edges if len(skeleton.edges) else np.arange(len(skeleton.nodes))[:, None]
    squares, edge, nearest = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points, dtype=np.float64), np.array(skeleton.nodes), np.array(simplices)
    )
    i, j = simplices[edge][:, 0], simplices[edge][:, -1]
    along = skeleton.nodes[j] - skeleton.nodes[i]
    lengths = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((nearest - skeleton.nodes[i]) * along).sum(axis=1) / lengths, 0.0, 1.0)
    return np.sqrt(squares), nearest, (1 - share) * skeleton.radii[i] + share * skeleton.radii[j]
