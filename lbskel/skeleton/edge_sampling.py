"""Evenly spaced points along the edges of a skeleton, for measures weighted by length."""

from __future__ import annotations

__all__ = ["sample_edges"]

import numpy as np
from numpy.typing import NDArray

from lbskel.skeleton.skeleton import Skeleton


def sample_edges(skeleton: Skeleton, spacing: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sample points along every edge, and the radii there by linear interpolation.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float
        Upper bound on the distance between points of one edge, in the skeleton's units. The points are the midpoints of
        equal pieces.

    Returns
    -------
    points : (p, 3) array of float
        The nodes if there are no edges at all.
    radii : (p,) array of float
    """
    if len(skeleton.edges) == 0:
        return skeleton.nodes, skeleton.radii
    n_pieces = np.maximum(1, np.ceil(skeleton.edge_lengths / spacing).astype(np.int64))
    edge = np.repeat(np.arange(len(n_pieces)), n_pieces)
    piece = np.arange(len(edge)) - np.repeat(np.cumsum(n_pieces) - n_pieces, n_pieces)
    share = (piece + 0.5) / n_pieces[edge]
    i, j = skeleton.edges[edge].T
    points = (1 - share)[:, None] * skeleton.nodes[i] + share[:, None] * skeleton.nodes[j]
    return points, (1 - share) * skeleton.radii[i] + share * skeleton.radii[j]
