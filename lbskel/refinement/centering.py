"""Centering: nodes moved to the centerlines of their branches.

A node inside a branch belongs at the centroid of the surface's cross-section there, which depends neither on how the
surface is sampled nor on how far it was contracted (:mod:`lbskel.refinement.centerlines`). Near a junction, where a
plane cuts several branches, the branch goes on smoothly, and as straight as that allows, to the junction
(:mod:`lbskel.refinement.junctions`).
"""

from __future__ import annotations

__all__ = ["fit_to_centerlines", "recenter"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.bends import contract_corner_spurs
from lbskel.refinement.centerlines import SectionCenters, find_section_centers
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.junctions import place_junctions
from lbskel.refinement.tunnel_sides import keep_sides, paths_that_pass
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import factorize

BENDING_WEIGHT = 1.0  # of a branch's squared second differences, against a weight of 1 on each section's centroid; a
# guess, benchmarks/results/constants.md
POSITION_WEIGHT = 3e-3  # of the place of a node without a section, and inverse weight of a junction's place, against a
# weight of 1 on each section's centroid; benchmarks/results/refinement.md


def recenter(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move every node to the centerline of its branch, and junctions to where the centerlines meet.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches near their centerlines, since sections are cut across them.
    surface : Surface
        In the same coordinates.
    """
    centers = find_section_centers(skeleton, surface)
    fitted = fit_to_centerlines(skeleton, place_junctions(skeleton, centers, surface), surface)
    return contract_corner_spurs(fitted, skeleton, centers, surface)


def fit_to_centerlines(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> Skeleton:
    """Fit a smooth curve to the section centers of every branch and to its junctions; tips move with their branch.

    Between its last section and its junction, and between sections, a branch is drawn to the straight line, weakly.
    Where that would leave the surface, it stays parallel to its present course.

    Parameters
    ----------
    skeleton : Skeleton
    centers : SectionCenters
        Of the same nodes.
    surface : Surface
    """
    is_junction = skeleton.degrees >= 3
    weight = np.where(centers.is_known, 1.0, POSITION_WEIGHT)
    weight[is_junction] = 1 / POSITION_WEIGHT
    targets = _across_gaps(skeleton, replace(centers, is_known=centers.is_known | is_junction), surface)
    nodes = _smoothing_spline(skeleton, targets, weight)
    is_gap = ~(centers.is_known | is_junction)
    is_outside = is_gap & ~surface.contains(nodes)
    if is_outside.any():
        branch_of = skeleton.branch_of_node
        is_parallel = is_gap & np.isin(branch_of, branch_of[is_outside])
        moved = skeleton.nodes + _smoothing_spline(skeleton, centers.positions - skeleton.nodes, weight)
        nodes[is_parallel] = moved[is_parallel]
    return replace(skeleton, nodes=keep_sides(skeleton, nodes, surface))


def _across_gaps(skeleton: Skeleton, centers: SectionCenters, surface: Surface) -> NDArray[np.float64]:
    """(n, 3) places of the nodes, those between two known ones straight between these.

    Not where that leaves the surface, or passes another side of a tunnel than the nodes.
    """
    nodes, begins = skeleton.flat_branches
    number = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    known = np.flatnonzero(centers.is_known[nodes])
    is_gap = (np.diff(known) > 1) & (np.diff(number[known]) == 0)
    firsts, lasts = known[:-1][is_gap], known[1:][is_gap]
    ends = np.stack([nodes[firsts], nodes[lasts]], axis=1)
    olds = [skeleton.nodes[nodes[first : last + 1]] for first, last in zip(firsts, lasts, strict=True)]
    may_not = segments_outside(centers.positions, ends, surface)
    may_not |= paths_that_pass(olds, list(centers.positions[ends]), surface)
    firsts, lasts = firsts[~may_not], lasts[~may_not]
    sizes = lasts - firsts - 1
    gap = np.repeat(np.arange(len(firsts)), sizes)
    between = np.arange(len(gap)) + (firsts + 1 - np.cumsum(sizes) + sizes)[gap]
    lengths = np.cumsum(
        np.linalg.norm(np.diff(skeleton.nodes[nodes], axis=0, prepend=skeleton.nodes[nodes[:1]]), axis=1)
    )
    shares = ((lengths[between] - lengths[firsts][gap]) / (lengths[lasts] - lengths[firsts])[gap])[:, None]
    P = np.array(centers.positions)
    P[nodes[between]] = (1 - shares) * P[nodes[firsts]][gap] + shares * P[nodes[lasts]][gap]
    return P


def _smoothing_spline(
    skeleton: Skeleton, target: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Fit a discrete smoothing spline to every branch, by weighted targets and squared second differences."""
    previous, middle, following = skeleton.triples
    rows = np.tile(np.arange(len(middle)), 3)
    values = np.repeat([1.0, -2.0, 1.0], len(middle))
    shape = (len(middle), len(skeleton.nodes))
    second = coo_array((values, (rows, np.concatenate([previous, middle, following]))), shape=shape).tocsc()
    A = BENDING_WEIGHT * (second.T @ second) + diags_array(weight)
    return factorize(A.tocsc()).solve(weight[:, None] * target)
