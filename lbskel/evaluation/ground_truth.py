"""Distances of a skeleton to the known axis of its shape.

Distances are one-sided, from points sampled evenly along one curve to the closest point of the other, in units of the
true local radius: from skeleton to axis is accuracy, from axis to skeleton is coverage (the measures of the MCF-Skel
code, Tagliasacchi et al. 2012, https://doi.org/10.1111/j.1467-8659.2012.03178.x, with the local radius in place of the
diagonal).
"""

from __future__ import annotations

__all__ = ["GroundTruthDistances", "ground_truth_distances"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.edge_sampling import sample_edges
from lbskel.skeleton.skeleton import Skeleton

N_SAMPLES = 20_000  # along the true skeleton; a guess: so many distances, each exact, have a mean known to 1e-3 of it
MAX_SAMPLES = 1_000_000  # along the measured one, which may be far longer, such as in other units; a guess
END_DISTANCE = 3.0  # from tips and junctions, in their radii, where radii are compared: a radius there has no one value


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
    length_error : float
        Length of the measured skeleton relative to the true one, minus 1.
    radius_error : float
        Mean absolute difference of the two radii, relative to the true one, along the measured skeleton where the
        nearest point of the true one is farther than three radii from its tips and junctions. NaN if the radii of the
        measured one are not known or there is no such part.

    Examples
    --------
    >>> import lbskel
    >>> line = lbskel.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [0.5, 0.5])
    >>> lifted = lbskel.Skeleton([[0, 0, 0.1], [1, 0, 0.1]], [[0, 1]], [0.5, 0.5])
    >>> round(lbskel.ground_truth_distances(lifted, line).accuracy, 3)
    0.2
    """

    accuracy: float
    accuracy_95: float
    coverage: float
    coverage_95: float
    is_topology_right: bool
    n_tips: int
    n_true_tips: int
    length_error: float
    radius_error: float


def ground_truth_distances(skeleton: Skeleton, truth: Skeleton) -> GroundTruthDistances:
    """Measure the distances between a skeleton and the true one.

    A node without an edge beside others with edges has no length: it counts for coverage and for the topology.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton to measure, in the coordinates of the true one.
    truth : Skeleton
        The true skeleton with its radii, which are the unit of the distances.

    Raises
    ------
    MeshError
        If the true skeleton has no length or a radius that is not positive, or if the other one has no node.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import make
    >>> shape = make("tripod", n_vertices=800)
    >>> distances = lbskel.ground_truth_distances(lbskel.skeletonize(shape.mesh), shape.truth)
    >>> distances.is_topology_right, distances.n_tips
    (True, 3)
    """
    if not truth.length > 0:
        raise MeshError("the true skeleton has no length: give one with edges between nodes at different positions")
    if not (truth.radii > 0).all():
        raise MeshError("the true skeleton needs a positive radius at every node: distances are in its radii")
    if len(skeleton.nodes) == 0:
        raise MeshError("the skeleton to measure has no nodes")
    spacing = truth.length / N_SAMPLES
    axis, radii = sample_edges(truth, spacing)
    points, measured_radii = sample_edges(skeleton, max(spacing, skeleton.length / MAX_SAMPLES))
    to_axis, nearest, true_radii = nearest_on_edges(truth, points)
    accuracy, coverage = to_axis / true_radii, nearest_on_edges(skeleton, axis)[0] / radii
    differences = np.abs(measured_radii / true_radii - 1)[_on_tubes(truth, nearest)]
    return GroundTruthDistances(
        accuracy=float(accuracy.mean()),
        accuracy_95=float(np.percentile(accuracy, 95)),
        coverage=float(coverage.mean()),
        coverage_95=float(np.percentile(coverage, 95)),
        is_topology_right=(skeleton.n_components, skeleton.cycle_rank) == (truth.n_components, truth.cycle_rank),
        n_tips=len(skeleton.tips),
        n_true_tips=len(truth.tips),
        length_error=skeleton.length / truth.length - 1,
        radius_error=float(differences.mean()) if len(differences) else float("nan"),
    )


def _on_tubes(truth: Skeleton, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points are far enough from all tips and junctions for a radius to be that of a tube."""
    ends = np.append(truth.tips, truth.junctions)
    near = cKDTree(points).query_ball_point(truth.nodes[ends], END_DISTANCE * truth.radii[ends])
    on_tubes = np.ones(len(points), dtype=bool)
    for found in near:
        on_tubes[found] = False
    return on_tubes
