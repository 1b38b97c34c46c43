"""Distances of a skeleton to the known axis of its shape.

Distances are one-sided, from points sampled evenly along one curve to the nearest sample of the other, in units of the
true local radius: from skeleton to axis is accuracy, from axis to skeleton is coverage (the measures of the MCF-Skel
code, Tagliasacchi et al. 2012, https://doi.org/10.1111/j.1467-8659.2012.03178.x, with the local radius in place of the
diagonal).
"""

from __future__ import annotations

__all__ = ["GroundTruthDistances", "ground_truth_distances"]

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from lbskel.skeleton.edge_sampling import sample_edges
from lbskel.skeleton.skeleton import Skeleton

N_SAMPLES = 20_000  # samples along the true skeleton; a guess: their spacing, 5e-5 of its length, is far below a radius


@dataclass(frozen=True)
class GroundTruthDistances:
    """Distances of a skeleton to the true one, in units of the true local radius, and its topology.

    Parameters
    ----------
    accuracy, accuracy_95 : float
        Mean and 95th percentile of the distances from the skeleton to the true one.
    coverage, coverage_95 : float
        Mean and 95th percentile of the distances from the true skeleton to the measured one.
    is_topology_right : bool
        Whether the numbers of components and of independent cycles agree.
    n_tips, n_true_tips : int
        Nodes of degree 1 in the measured skeleton and in the true one.
    """

    accuracy: float
    accuracy_95: float
    coverage: float
    coverage_95: float
    is_topology_right: bool
    n_tips: int
    n_true_tips: int


def ground_truth_distances(skeleton: Skeleton, truth: Skeleton) -> GroundTruthDistances:
    """Measure the distances between a skeleton and the true one.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton to measure, in the coordinates of the true one; its radii are not used.
    truth : Skeleton
        The true skeleton with its radii, which are the unit of the distances.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import make
    >>> shape = make("tripod", n_vertices=800)
    >>> distances = lbskel.ground_truth_distances(lbskel.skeletonize(shape.mesh), shape.truth)
    >>> distances.is_topology_right, distances.n_tips
    (True, 3)
    """
    spacing = truth.length / N_SAMPLES
    axis, radii = sample_edges(truth, spacing)
    points, _ = sample_edges(skeleton, spacing)
    to_axis, nearest = cKDTree(axis).query(points)
    to_skeleton, _ = cKDTree(points).query(axis)
    accuracy, coverage = to_axis / radii[nearest], to_skeleton / radii
    return GroundTruthDistances(
        accuracy=float(accuracy.mean()),
        accuracy_95=float(np.percentile(accuracy, 95)),
        coverage=float(coverage.mean()),
        coverage_95=float(np.percentile(coverage, 95)),
        is_topology_right=(skeleton.n_components, skeleton.cycle_rank) == (truth.n_components, truth.cycle_rank),
        n_tips=len(skeleton.tips),
        n_true_tips=len(truth.tips),
    )
