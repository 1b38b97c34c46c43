"""Distances of points to the edges of a skeleton: exact closest points on segments, and the radii there."""

from __future__ import annotations

__all__ = ["nearest_on_edges"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.bvh import build_aabb_tree
from lbskel.geometry.normals import row_dots
from lbskel.skeleton.skeleton import Skeleton


def nearest_on_edges(
    skeleton: Skeleton, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Find the closest point of a skeleton: on its edges, or an isolated node.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float

    Returns
    -------
    distances : (n,) array of float
        In the units of the skeleton.
    nearest : (n, 3) array of float
        The closest points.
    radii : (n,) array of float
        Radii there, by linear interpolation along the edge.
    """
    if len(points) == 0:
        return np.empty(0), np.empty((0, 3)), np.empty(0)
    isolated = np.flatnonzero(skeleton.degrees == 0)
    i, j = np.concatenate([skeleton.edges, np.stack([isolated, isolated], axis=1)]).T
    faces = np.stack([i, j, j], axis=1)  # an edge is a triangle without area
    distances, nearest, edge = build_aabb_tree(skeleton.nodes, faces).nearest_faces(points)
    i, j = i[edge], j[edge]
    starts = skeleton.nodes.take(i, axis=0)
    along = skeleton.nodes.take(j, axis=0) - starts
    lengths = np.maximum(row_dots(along, along), np.finfo(np.float64).tiny)
    share = np.clip(row_dots(nearest - starts, along) / lengths, 0.0, 1.0)
    return distances, nearest, (1 - share) * skeleton.radii[i] + share * skeleton.radii[j]
