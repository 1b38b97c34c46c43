"""How good a skeleton is: against the truth where it is known, and against its mesh where it is not.

Distances are one-sided, from points sampled evenly along one curve to the other, in units of the true local radius:
skeleton to axis is accuracy, axis to skeleton is coverage (the measures of the MCF-Skel code, Tagliasacchi et al. 2012,
https://doi.org/10.1111/j.1467-8659.2012.03178.x, with the radius in place of the diagonal).
"""

from __future__ import annotations

__all__ = ["Comparison", "compare"]

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from lbskel.skeleton.edge_sampling import sample_edges
from lbskel.skeleton.skeleton import Skeleton


@dataclass(frozen=True)
class Comparison:
    """A skeleton beside the true one; distances in units of the true local radius.

    Parameters
    ----------
    accuracy, accuracy_95, coverage, coverage_95 : float
        Mean and 95th percentile of the distances from the skeleton to the axis, and from the axis to the skeleton.
    is_topology_right : bool
        Whether the numbers of components and of independent cycles agree.
    n_tips, n_true_tips : int
    """

    accuracy: float
    accuracy_95: float
    coverage: float
    coverage_95: float
    is_topology_right: bool
    n_tips: int
    n_true_tips: int


def compare(skeleton: Skeleton, truth: Skeleton) -> Comparison:
    """Measure a skeleton against the true one, in the same coordinates.

    Parameters
    ----------
    skeleton, truth : Skeleton
        The truth with its radii.
    """
    spacing = truth.length / 20_000
    axis, radii = sample_edges(truth, spacing)
    points, _ = sample_edges(skeleton, spacing)
    to_axis, nearest = cKDTree(axis).query(points)
    to_skeleton, _ = cKDTree(points).query(axis)
    accuracy, coverage = to_axis / radii[nearest], to_skeleton / radii
    return Comparison(
        accuracy=float(accuracy.mean()),
        accuracy_95=float(np.percentile(accuracy, 95)),
        coverage=float(coverage.mean()),
        coverage_95=float(np.percentile(coverage, 95)),
        is_topology_right=(skeleton.n_components, skeleton.cycle_rank) == (truth.n_components, truth.cycle_rank),
        n_tips=len(skeleton.tips),
        n_true_tips=len(truth.tips),
    )
