"""Points of a cloud that belong to no surface: far from all others, or scattered in groups of their own.

A point is an outlier if its distance to its neighbors is several times their distance to their own: a local outlier
factor (Breunig, Kriegel, Ng, Sander 2000, https://doi.org/10.1145/335191.335388) with the distance to one neighbor as
inverse density, so that a cloud that is dense here and sparse there loses nothing. A point is compared with the densest
fifth of its neighbors, since the neighbors of an outlier may be outliers too. A point with another beside it, as in two
scans of one surface, is no outlier.

Where outliers are many, far from the surface all neighbors are outliers. The remaining points fall into groups, linked
where two points are about as near as their neighbors. A group much sparser than the cloud consists of outliers if it
fills space, and is a sparse part of the surface if its neighborhoods are flat.
"""

from __future__ import annotations

__all__ = ["find_outliers"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.point_stars import MIN_VARIATION, surface_variation
from lbskel.preprocess.point_neighborhoods import Neighborhoods

N_NEIGHBORS = 6  # the distance to this neighbor is the inverse density of a point; a guess
# Share of the points nearby that are denser than the one that a point is compared with, no unit. It bounds how large a
# cluster of outliers may hide itself from below, and which points at the ends of limbs are outliers from above: with
# 0.14 and 0.28 clouds are a twentieth less accurate; benchmarks/results/point_constants.md
QUANTILE = 0.2
# The second finds the few outliers that the first has left alone, whose neighbors were outliers; the error of clouds is
# a hundredth larger without it, benchmarks/results/point_constants.md
N_PASSES = 2
N_LINKS = 12  # neighbors that a point may be linked with, and whose plane is that of its group; a guess


def find_outliers(cloud: Neighborhoods, limit: float) -> tuple[NDArray[np.bool_], Neighborhoods]:
    """Tell which points are outliers, and return the others.

    Parameters
    ----------
    cloud : Neighborhoods
    limit : float
        Largest distance to the neighbors, relative to that of the denser points nearby, of a point that is no outlier.

    Returns
    -------
    is_outlier : (n,) array of bool
    kept : Neighborhoods
        The same object where no point is an outlier.
    """
    is_outlier, kept = np.zeros(len(cloud.points), dtype=bool), cloud
    last = None
    for is_bad in [_is_sparse] * N_PASSES + [_is_scattered]:
        if len(kept.points) <= N_LINKS:
            break
        if (is_bad, kept) == last:  # as before, and nothing was found
            continue
        last = is_bad, kept
        bad = is_bad(kept, limit)
        if bad.any():
            is_outlier[~is_outlier] = bad
            kept = Neighborhoods(cloud.points[~is_outlier])
    return is_outlier, kept


def _is_sparse(cloud: Neighborhoods, limit: float) -> NDArray[np.bool_]:
    """(n,) whether the distance to a neighbor is too large relative to that of the denser points nearby."""
    distances = cloud.nearest(N_NEIGHBORS + 1)[0]
    reach = distances[:, N_NEIGHBORS]
    rank = round(QUANTILE * (cloud.n_wide - 2))
    # as many of all points are as dense as those nearby that a point is compared with: it must be sparser than these
    (rows,) = np.nonzero(reach > limit * np.partition(reach, rank)[rank])
    nearby = reach[cloud.wide(rows)[:, 1:]]
    is_sparse = np.zeros(len(reach), dtype=bool)
    dense = np.partition(nearby, rank, axis=1)[:, rank]
    is_sparse[rows] = (reach[rows] > limit * dense) & (limit * distances[rows, 1] > dense)
    return is_sparse


def _is_scattered(cloud: Neighborhoods, limit: float) -> NDArray[np.bool_]:
    """(n,) whether a point is in a group that fills space, many times sparser than the cloud."""
    points = cloud.points
    distances, neighbors = cloud.nearest(N_LINKS + 1)
    reach = distances[:, N_NEIGHBORS]
    typical = float(np.median(reach))
    if not (reach > limit * typical).any():  # so no group has a median above that
        return np.zeros(len(points), dtype=bool)
    links = np.stack([np.repeat(np.arange(len(points)), N_LINKS), neighbors[:, 1:].ravel()], axis=1)
    is_near = distances[:, 1:].ravel() <= limit * reach[links].min(axis=1)
    graph = weighted_graph(links[is_near], np.ones(np.count_nonzero(is_near), dtype=np.int8), len(points))
    n_groups, group = connected_components(graph, directed=False)
    is_scattered = np.zeros(n_groups, dtype=bool)
    order = np.argsort(group, kind="stable")
    for number, members in enumerate(np.split(order, np.cumsum(np.bincount(group))[:-1])):
        if np.median(reach[members]) > limit * typical:
            is_scattered[number] = np.median(surface_variation(points, neighbors[members])) > MIN_VARIATION
    answer: NDArray[np.bool_] = is_scattered[group]
    return answer
