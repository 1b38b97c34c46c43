"""Tangents of branches at their sections next to the junctions where they meet."""

from __future__ import annotations

__all__ = ["MAX_SINE", "BranchLines", "branch_lines", "nearest_points", "with_chords"]

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.refinement.centerlines import SectionCenters
from lbskel.skeleton.skeleton import Skeleton

# Upper bound on the sections next to a junction that give the direction of a branch. More are steadier where it is
# straight, and less like the bend where it is not. Rows "sections next to a junction" in
# benchmarks/results/refinement.md
N_SECTIONS = 5
# Share of the trace of a system of lines below which an eigenvalue leaves its direction undetermined. That of a trunk
# and two limbs, each at an angle to it, is a third of the squared sine: 5 degrees. "Junctions placed" in
# benchmarks/refinement_trials.py: with 5.6 degrees an acute fork is not extended
MIN_SHARE = 0.0025

# Upper bound on the sine of the angle between a line and the direction to a place that it points to, or another line
# that it continues. Rows of it, for junctions and for trunks, in benchmarks/results/robustness.md: 0.3 to 0.44 are
# alike there, and 0.33 to 0.44 in the rows "merged up to a sine" in refinement.md, where with 0.3 a tube has a wrong
# graph; with 0.2 palms of hands have two junctions, with 0.5 one creature more has a wrong graph; by hand, from 0.44 on
# a coarse star of limbs has one junction for two
MAX_SINE = 0.36

EPSILON, TINY = float(np.finfo(np.float64).eps), float(np.finfo(np.float64).tiny)

SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


@dataclass(frozen=True, eq=False)
class BranchLines:
    """Tangents of branches next to their junctions: one row per junction and branch with enough sections.

    Parameters
    ----------
    junctions, branches : (l,) array of int
        The node of the junction, and the index of the branch.
    is_first : (l,) array of bool
        Whether the junction is the first node of the branch, or the last: a loop has two lines at one junction.
    starts : (l, 3) array of float
        Center of the branch's section nearest to the junction.
    means : (l, 3) array of float
        Point of the line at the mean arc length of the sections that gave it.
    directions : (l, 3) array of float
        Unit vectors towards the junction.
    """

    junctions: NDArray[np.int64]
    branches: NDArray[np.int64]
    is_first: NDArray[np.bool_]
    starts: NDArray[np.float64]
    means: NDArray[np.float64]
    directions: NDArray[np.float64]

    def at(self, junctions: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows of the lines at g groups of e junctions, given as (g, e) nodes, by group; and the group of each row."""
        order = np.argsort(self.junctions, kind="stable")
        begins, ends = (np.searchsorted(self.junctions, junctions.ravel(), side, sorter=order) for side in SIDES)
        sizes = ends - begins
        rows = order[np.arange(sizes.sum()) + np.repeat(begins - np.cumsum(sizes) + sizes, sizes)]
        groups = np.repeat(np.repeat(np.arange(len(junctions)), junctions.shape[1]), sizes)
        by_group = np.lexsort((rows, groups))
        return rows[by_group], groups[by_group]

    def take(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> BranchLines:
        """Select some of the rows."""
        return BranchLines(
            self.junctions[rows],
            self.branches[rows],
            self.is_first[rows],
            self.starts[rows],
            self.means[rows],
            self.directions[rows],
        )


def branch_lines(skeleton: Skeleton, centers: SectionCenters, *, with_single: bool = False) -> BranchLines:
    """Find the line of every branch at each of its junctions: the tangent at the section nearest to it.

    Parameters
    ----------
    skeleton : Skeleton
    centers : SectionCenters
        Of the same nodes. A branch with fewer than two sections of its own has no line.
    with_single : bool
        Whether a branch between two different junctions needs one section only. Its line then has the direction of the
        skeleton there.
    """
    nodes, begins = skeleton.flat_branches
    number = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    is_own = centers.is_known[nodes]
    is_own[np.concatenate([begins[:-1], begins[1:] - 1])] = False
    place, number = np.flatnonzero(is_own), number[is_own]
    count = np.bincount(number, minlength=len(begins) - 1)
    first = np.cumsum(count) - count
    used = np.minimum(count, N_SECTIONS)
    P, branch, ends = centers.positions[nodes], np.arange(len(count)), skeleton.branch_ends.T
    is_inner = (skeleton.degrees[ends] >= 3).all(axis=0) & (ends[0] != ends[1])
    is_line = used >= np.where(is_inner & with_single, 1, 2)
    parts = []
    for is_forward, junction in zip((True, False), ends, strict=True):
        has_line = (skeleton.degrees[junction] >= 3) & is_line
        sizes, step = used[has_line], 1 if is_forward else -1
        nearest = (first if is_forward else first + count - 1)[has_line]
        at = place[nearest]
        means, starts, directions = P[at], P[at], np.zeros((len(at), 3))
        single = sizes == 1
        directions[single] = np.subtract(*skeleton.nodes[nodes[np.stack([at - step, at + step])[:, single]]])
        for size in range(2, N_SECTIONS + 1):
            rows = np.flatnonzero(sizes == size)
            points = P[place[nearest[rows, None] + step * np.arange(size)]]
            means[rows], directions[rows] = _tangents(points)
        length = vector_lengths(directions)
        kept = length > 0
        directions = directions[kept] / length[kept, None]
        numbers = 2 * branch[has_line][kept] + (not is_forward)
        parts.append((junction[has_line][kept], numbers, starts[kept], means[kept], directions))
    junctions, numbers, starts, means, directions = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(numbers)
    branches, is_last = np.divmod(numbers[order], 2)
    return BranchLines(junctions[order], branches, is_last == 0, starts[order], means[order], directions[order])


def with_chords(lines: BranchLines, skeleton: Skeleton) -> BranchLines:
    """Add a line at each end without one of the branches between two junctions: the chord from the other junction.

    Parameters
    ----------
    lines : BranchLines
    skeleton : Skeleton
    """
    ends = skeleton.branch_ends
    is_missing = np.repeat((skeleton.degrees[ends] >= 3).all(axis=1) & (ends[:, 0] != ends[:, 1]), 2)
    is_missing[2 * lines.branches + ~lines.is_first] = False
    branches, is_last = np.divmod(np.flatnonzero(is_missing), 2)
    at, beyond = ends[branches, is_last], ends[branches, 1 - is_last]
    starts = skeleton.nodes[beyond]
    return BranchLines(
        np.concatenate([lines.junctions, at]),
        np.concatenate([lines.branches, branches]),
        np.concatenate([lines.is_first, is_last == 0]),
        np.concatenate([lines.starts, starts]),
        np.concatenate([lines.means, starts]),
        np.concatenate([lines.directions, normalized(skeleton.nodes[at] - starts)]),
    )


def _tangents(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find the tangents at the first of each of (l, k, 3) rows of points.

    A line and a parabola are fitted by the distance along the points. The bend of the parabola counts by a share, so
    that the tangents of bent rows follow the bend, and those of straight ones are as steady as lines.

    Returns
    -------
    points : (l, 3) array of float
        Those of the tangents at the mean distance along the points.
    directions : (l, 3) array of float
        From the last point to the first, of any length; zero where all points coincide.
    """
    steps = vector_lengths(np.diff(points, axis=1, prepend=points[:, :1]))
    t = np.cumsum(steps, axis=1)
    t /= np.maximum(t[:, -1:], TINY)
    t -= t.mean(axis=1, keepdims=True)
    moments = np.maximum((t**2).sum(axis=1, keepdims=True), TINY)
    means, velocities = points.mean(axis=1), np.einsum("lk,lki->li", t, points) / moments
    if points.shape[1] <= 3:  # a parabola leaves three points no variance to compare its bend with
        return means, -velocities
    skews = (t**3).sum(axis=1, keepdims=True) / moments
    q = t**2 - moments / t.shape[1] - skews * t  # orthogonal to t and to constants
    squares = (q**2).sum(axis=1, keepdims=True)
    q = np.where(squares > EPSILON, q, 0.0)  # rounding, where all points lie at two places
    bends = np.einsum("lk,lki->li", q, points) / np.maximum(squares, EPSILON)
    fitted = means[:, None] + t[:, :, None] * velocities[:, None] + q[:, :, None] * bends[:, None]
    bends *= _share_of_bend(squares * (bends**2).sum(axis=1, keepdims=True), points - fitted)
    tangents = velocities + (2 * t[:, :1] - skews) * bends
    return means + t[:, :1] * (velocities - tangents) + q[:, :1] * bends, -tangents


def _share_of_bend(explained: NDArray[np.float64], residuals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(l, 1) share of the squares that bends explain, (l, 1), that noise does not: an empirical Wiener filter.

    Noise adds to them, on average, what it leaves of each of the other degrees of freedom.
    """
    left = (residuals**2).sum(axis=(1, 2))[:, None] / (residuals.shape[1] - 3)
    share: NDArray[np.float64] = np.maximum(1 - left / np.maximum(explained, TINY), 0)
    return share


def nearest_points(
    lines: BranchLines, groups: NDArray[np.int64], anchors: NDArray[np.float64], radii: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(g, 3) the point with the least weighted sum of squared distances to the lines of each group, or its anchor.

    A line's weight is the inverse square of the distance over which it is extended, which counts as at least the
    radius. In directions that the lines leave undetermined, the point stays at the anchor.

    Parameters
    ----------
    lines : BranchLines
    groups : (l,) array of int
        The group of each line.
    anchors : (g, 3) array of float
        Where the point of each group is expected: the contracted position of its junction.
    radii : (g,) array of float
    """
    distances = vector_lengths(lines.starts - anchors[groups])
    projections = np.eye(3) - lines.directions[:, :, None] * lines.directions[:, None, :]
    projections /= np.maximum(distances, radii[groups])[:, None, None] ** 2
    moments = np.einsum("lij,lj->li", projections, lines.means - anchors[groups])
    A, b, points = np.zeros((len(anchors), 3, 3)), np.zeros((len(anchors), 3)), np.array(anchors)
    np.add.at(A, groups, projections)
    np.add.at(b, groups, moments)
    known = np.bincount(groups, minlength=len(anchors)) > 0
    values, vectors = np.linalg.eigh(A[known])
    is_determined = values > MIN_SHARE * values.sum(axis=1, keepdims=True)
    inverses = np.divide(1.0, values, out=np.zeros_like(values), where=is_determined)
    points[known] += np.einsum("gij,gj,gkj,gk->gi", vectors, inverses, vectors, b[known])
    return points
