"""Centering: nodes moved to the centerlines of their branches.

A node inside a branch belongs at the centroid of the surface's cross-section there, which depends neither on how the
surface is sampled nor on how far it was contracted (:mod:`lbskel.refinement.centerlines`). Near a junction, where a
plane cuts several branches, the branch is continued smoothly, and as straight as possible, to the junction
(:mod:`lbskel.refinement.junctions`).
"""

from __future__ import annotations

__all__ = ["fit_to_centerlines", "recenter", "second_differences"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.bends import contract_corner_spurs
from lbskel.refinement.centerlines import SectionCenters, find_section_centers
from lbskel.refinement.junctions import place_junctions
from lbskel.refinement.tunnel_sides import keep_sides, paths_that_pass
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import factorize

# Weight of a branch's squared second differences, against a weight of 1 on each section's centroid: less follows noise,
# more cuts bends. Rows "bending weight of centers" in benchmarks/results/refinement.md
BENDING_WEIGHT = 0.5
# Weight of the place of a node without a section, and inverse weight of a junction's place, against a weight of 1 on
# each section's centroid. Rows "weight of gaps" in the same table
POSITION_WEIGHT = 3e-3


def recenter(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move every node to the centerline of its branch, and junctions to where the centerlines meet.

    The spurs in sharp bends are contracted (:mod:`lbskel.refinement.bends`).

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

    Between its last section and its junction, and between sections, a branch is weakly drawn to the straight line.
    Where the result would leave the surface, the branch stays parallel to its present course. A loop without a known
    section stays as it is: nothing else would hold it open.

    Parameters
    ----------
    skeleton : Skeleton
    centers : SectionCenters
        Of the same nodes.
    surface : Surface
    """
    is_junction = skeleton.degrees >= 3
    is_held = centers.is_known | _on_loops_without_sections(skeleton, centers)
    weight = np.where(is_held, 1.0, POSITION_WEIGHT)
    weight[is_junction] = 1 / POSITION_WEIGHT
    is_gap = ~(is_held | is_junction)
    nodes = _smoothing_spline(skeleton, _across_gaps(skeleton, centers.positions, is_gap, surface), weight)
    is_outside = is_gap & ~surface.contains(nodes)
    if is_outside.any():
        branch_of = skeleton.branch_of_node
        is_parallel = is_gap & np.isin(branch_of, branch_of[is_outside])
        moved = skeleton.nodes + _smoothing_spline(skeleton, centers.positions - skeleton.nodes, weight)
        nodes[is_parallel] = moved[is_parallel]
    return replace(skeleton, nodes=keep_sides(skeleton, nodes, surface))


def _on_loops_without_sections(skeleton: Skeleton, centers: SectionCenters) -> NDArray[np.bool_]:
    """(n,) whether a node is on a branch that ends where it begins, and of which no section is known."""
    is_on_loop = np.zeros(len(skeleton.nodes), dtype=bool)
    for branch in skeleton.branches:
        own = branch[skeleton.degrees[branch] == 2]
        is_on_loop[own] = branch[0] == branch[-1] and not centers.is_known[own].any()
    return is_on_loop


def _across_gaps(
    skeleton: Skeleton, positions: NDArray[np.float64], is_gap: NDArray[np.bool_], surface: Surface
) -> NDArray[np.float64]:
    """(n, 3) positions of the nodes, those of gaps evenly on the straight line between the nodes around them.

    A gap whose line passes a tunnel on another side than its nodes keeps its positions.
    """
    along, begins = skeleton.flat_branches
    held = np.flatnonzero(~is_gap[along])
    branch = np.searchsorted(begins, held, "right")
    first, last = np.stack([held[:-1], held[1:]])[:, (np.diff(held) > 1) & (np.diff(branch) == 0)]
    gaps = [along[begin : end + 1] for begin, end in zip(first.tolist(), last.tolist(), strict=True)]
    olds, lines = [skeleton.nodes[gap] for gap in gaps], [positions[gap[[0, -1]]] for gap in gaps]
    straight = np.array(positions)
    for gap, (begin, end), passes in zip(gaps, lines, paths_that_pass(olds, lines, surface), strict=True):
        if not passes:
            share = np.arange(1, len(gap) - 1)[:, None] / (len(gap) - 1)
            straight[gap[1:-1]] = begin + share * (end - begin)
    return straight


def _smoothing_spline(
    skeleton: Skeleton, target: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Fit a discrete smoothing spline to every branch, by weighted targets and squared second differences."""
    second = second_differences(skeleton)
    A = BENDING_WEIGHT * (second.T @ second) + diags_array(weight)
    return factorize(A.tocsc()).solve(weight[:, None] * target)


def second_differences(skeleton: Skeleton) -> csr_array:
    """(r, k) matrix of the second differences along the branches, a row for each of :attr:`Skeleton.triples`.

    Parameters
    ----------
    skeleton : Skeleton
    """
    previous, middle, following = skeleton.triples
    rows = np.tile(np.arange(len(middle)), 3)
    values = np.repeat([1.0, -2.0, 1.0], len(middle))
    shape = (len(middle), len(skeleton.nodes))
    return coo_array((values, (rows, np.concatenate([previous, middle, following]))), shape=shape).tocsr()
