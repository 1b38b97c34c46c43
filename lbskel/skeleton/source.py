"""Whether a skeleton was made from a mesh or a cloud: the number of vertices that it maps, and where it lies."""

from __future__ import annotations

__all__ = ["require_map", "require_near"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.skeleton.skeleton import Skeleton

ELSEWHERE = "the skeleton is not in the shape: give the mesh or cloud that it was made from, in the same units"


def require_map(skeleton: Skeleton, points: NDArray[np.float64]) -> None:
    """Raise MeshError unless a skeleton maps as many vertices as there are points, to nodes near them.

    Half of all distances must be at most the diagonal of the points' bounding box, as those from any place in the box
    are. A skeleton in units that are ten times larger is farther, also around the same origin; one in smaller units is
    not told.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float
        The vertices of the mesh.
    """
    if len(skeleton.node_of_vertex) != len(points):
        raise MeshError(
            f"the skeleton maps {len(skeleton.node_of_vertex)} vertices to its nodes, and the mesh has "
            f"{len(points)}: give the mesh that the skeleton was made from"
        )
    if len(points) and len(skeleton.nodes):
        distances = np.linalg.norm(points - skeleton.nodes[skeleton.node_of_vertex], axis=1)
        if np.median(distances) > np.linalg.norm(np.ptp(points, axis=0)):
            raise MeshError(ELSEWHERE)


def require_near(skeleton: Skeleton, points: NDArray[np.float64]) -> None:
    """Raise MeshError if all nodes are farther from the bounding box of points than half of its diagonal.

    Parameters
    ----------
    skeleton : Skeleton
    points : (n, 3) array of float
        Those of a shape.
    """
    if len(skeleton.nodes) == 0 or len(points) == 0:
        return
    low, high = points.min(axis=0), points.max(axis=0)
    outside = np.maximum(0, np.maximum(low - skeleton.nodes, skeleton.nodes - high))
    if np.linalg.norm(outside, axis=1).min() > np.linalg.norm(high - low) / 2:
        raise MeshError(ELSEWHERE)
