"""Measures of the shape of a skeleton itself: how much it bends, and how many of its branches say nothing."""

from __future__ import annotations

__all__ = ["mean_and_worst_branch", "median_of_known", "n_spurs", "negative_fraction", "rms_curvature"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import vector_lengths
from lbskel.skeleton.skeleton import Skeleton

# Lower bounds on the known values of a branch that has a median of its own, and on their share of its nodes: where
# neurites touch, few nodes of a branch have a cross-section of their own, and those few are not at its middle.
# benchmarks/results/judge.md
MIN_KNOWN, MIN_KNOWN_SHARE = 4, 0.5
MAX_SPUR_REACH = 1.2  # in radii of the junction: a spur is an end branch whose balls all stay within; a guess


def negative_fraction(skeleton: Skeleton, values: NDArray[np.float64]) -> float:
    """Compute the fraction of the length along which values are negative, linear between the two ends of each edge.

    Without length, it is the fraction of the nodes.

    Parameters
    ----------
    skeleton : Skeleton
    values : (k,) array of float
        For each node.
    """
    lengths = skeleton.edge_lengths
    if not lengths.any():
        return float((values < 0).mean())
    low, high = np.sort(values[skeleton.edges], axis=1).T
    rise = np.where(high > low, high - low, 1.0)
    return float(np.average(np.where(high < 0, 1.0, np.clip(-low / rise, 0, 1)), weights=lengths))


def rms_curvature(skeleton: Skeleton) -> float:
    """Compute the root mean square, along the length, of the turning angle per local radius of length, in radians.

    Parameters
    ----------
    skeleton : Skeleton
        Its radii are the local ones.
    """
    previous, middle, following = skeleton.triples
    P = skeleton.nodes
    before, after = P[middle] - P[previous], P[following] - P[middle]
    spacing = (vector_lengths(before) + vector_lengths(after)) / 2
    angles = np.arctan2(vector_lengths(np.cross(after, before)), np.einsum("ij,ij->i", after, before))
    is_long = spacing > 0
    curvatures = angles[is_long] * skeleton.radii[middle[is_long]] / spacing[is_long]
    return float(np.sqrt(np.average(curvatures**2, weights=spacing[is_long]))) if is_long.any() else 0.0


def mean_and_worst_branch(skeleton: Skeleton, values: NDArray[np.float64]) -> tuple[float | None, float | None]:
    """Compute the mean over all nodes, and the largest median over a branch; None where too little is known.

    Parameters
    ----------
    skeleton : Skeleton
    values : (k,) array of float
        For each node; NaN where it is not known.
    """
    medians = [median_of_known(values[branch]) for branch in skeleton.branches]
    is_known = ~np.isnan(values)
    mean = float(values[is_known].mean()) if is_known.any() else None
    return mean, max((median for median in medians if median is not None), default=None)


def median_of_known(values: NDArray[np.float64]) -> float | None:
    """Compute the median of the known values of a branch; None where too few are known.

    Parameters
    ----------
    values : (k,) array of float
        For each node of the branch; NaN where it is not known.
    """
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) >= max(MIN_KNOWN, MIN_KNOWN_SHARE * len(values)) else None


def n_spurs(skeleton: Skeleton) -> int:
    """Count the end branches whose balls stay within ``MAX_SPUR_REACH`` radii of their junction, but none to an anchor.

    Parameters
    ----------
    skeleton : Skeleton
    """
    ends = [branch for branch in skeleton.end_branches if branch[-1] not in skeleton.anchors]
    reaches = [vector_lengths(skeleton.nodes[b] - skeleton.nodes[b[0]]) + skeleton.radii[b] for b in ends]
    return sum(
        float(r.max()) < MAX_SPUR_REACH * float(skeleton.radii[b[0]]) for r, b in zip(reaches, ends, strict=True)
    )
