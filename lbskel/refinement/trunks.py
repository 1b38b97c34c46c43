"""Limbs along a trunk: where each leaves, by where its line meets that of the trunk.

Two branches that meet in a junction may be one tube that passes through it: their lines continue each other, and the
ball of the junction is not much larger than they are. Of several such tubes the thickest is the trunk. Contraction
joins the other branches to it in any order, several at one place or far from where they leave. Each leaves where its
line passes the axis of the trunk; a tube that crosses the trunk has one line. Limbs that are nearer to each other than
both the sum of their radii and the radius of the junction share a junction, and others have one each. A palm, whose
ball is larger than every limb, has no trunk. Where a limb as thick as the ball leaves at each of two junctions, these
are on one tube that bends between them, and no palm.
"""

from __future__ import annotations

__all__ = ["Trunk", "find_trunk", "judge_pairs", "split_junctions_along_trunks"]

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.branch_lines import MAX_SINE, BranchLines, branch_lines, with_chords
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.inscribed_balls import MIN_BALL_RATIO
from lbskel.refinement.radii import inscribed_radii
from lbskel.skeleton.skeleton import Skeleton

# Lower bound on the radius of a trunk over that of the ball at its junction, and on that of a tube that crosses it over
# that of the trunk. Rows in benchmarks/results/robustness.md: 0.4 to 0.8 are alike; by hand, of 99 other creatures 83
# graphs are right with 0.5 to 0.7, 81 with 0.8 and 80 with 0.9
MIN_THICKNESS = 0.6
# Upper bound on the distance of a limb's place from the gap between the trunk's sections on both sides, in radii of the
# trunk: a section beside the foot of a limb may be the trunk's own. Rows in the same table: with 0, half of the
# creatures are right that are with 2, and more is alike; by hand, without a bound prongs leave their handle five radii
# off
MAX_REACH = 2.0


@dataclass(frozen=True, eq=False)
class Trunk:
    """A tube that passes through a junction, and the places where the other branches leave it.

    Parameters
    ----------
    ends : (2,) array of int
        Rows of the two lines of the trunk.
    limbs : (l,) array of int
        Rows of the other lines.
    numbers : (l,) array of int
        For each limb the row of its place.
    places : (p, 3) array of float
        On the axis of the trunk, in order from its first end to its second.
    """

    ends: NDArray[np.int64]
    limbs: NDArray[np.int64]
    numbers: NDArray[np.int64]
    places: NDArray[np.float64]


def find_trunk(lines: BranchLines, ball: float, surface: Surface) -> Trunk | None:
    """Find the trunk among the lines of a junction, or of a pair of junctions; None if there is none, or no limb.

    Parameters
    ----------
    lines : BranchLines
    ball : float
        Radius of the ball at the junction, or of the larger one of two.
    surface : Surface
    """
    M, D = lines.means, lines.directions
    ways = normalized((M[None] - M[:, None]).reshape(-1, 3)).reshape(len(M), len(M), 3)
    cosines = np.einsum("abi,ai->ab", ways, D)
    continues = np.minimum(cosines, cosines.T) >= np.sqrt(1 - MAX_SINE**2)
    if len(M) < 3 or not continues.any():
        return None
    radii = surface.distance(lines.starts)
    thickness = np.where(continues, np.minimum(radii[:, None], radii), 0.0)
    first, last = np.unravel_index(thickness.argmax(), thickness.shape)
    origin, axis, thick = M[first], ways[first, last], thickness[first, last]
    limbs = np.delete(np.arange(len(M)), [first, last])
    directions = _directions_across(limbs, thickness >= MIN_THICKNESS * thick, ways, D)
    along = directions @ axis
    if (1 - along**2 < MAX_SINE**2).any():
        return None
    to_limb = M[limbs] - origin
    heights = (to_limb @ axis - along * np.einsum("li,li->l", to_limb, directions)) / (1 - along**2)
    begin, end = (lines.starts[[first, last]] - origin) @ axis + thick * np.array([-MAX_REACH, MAX_REACH])
    places = origin + heights[:, None] * axis
    if heights.min() < begin or heights.max() > end or not surface.contains(places).all():
        return None
    ball = max(ball, float(surface.distance(places).max()))
    if thick < MIN_THICKNESS * ball:
        return None
    order = np.argsort(heights, kind="stable")
    overlaps = np.diff(heights[order]) <= np.minimum(ball, radii[limbs][order][1:] + radii[limbs][order][:-1])
    numbers = np.empty(len(limbs), dtype=np.int64)
    numbers[order] = np.append(0, np.cumsum(~overlaps))
    means = np.bincount(numbers, heights) / np.bincount(numbers)
    return Trunk(np.array([first, last]), limbs, numbers, origin + means[:, None] * axis)


def _directions_across(
    limbs: NDArray[np.int64], crosses: NDArray[np.bool_], ways: NDArray[np.float64], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(l, 3) directions of the limbs; two that are one tube have that from one to the other."""
    found = np.array(directions[limbs])
    is_free = np.ones(len(limbs), dtype=bool)
    for row, other in np.argwhere(np.triu(crosses[np.ix_(limbs, limbs)])).tolist():
        if is_free[row] and is_free[other]:
            is_free[[row, other]] = False
            found[[row, other]] = ways[limbs[row], limbs[other]]
    return found


def judge_pairs(
    skeleton: Skeleton,
    lines: BranchLines,
    inner: NDArray[np.int64],
    sines: NDArray[np.float64],
    surface: Surface,
) -> NDArray[np.float64]:
    """Judge pairs of junctions by the trunk that passes through both, where there is one.

    Parameters
    ----------
    skeleton : Skeleton
    lines : BranchLines
        Of its branches.
    inner : (i,) array of int
        The branches between the junctions of each pair.
    sines : (i,) array of float
        How well a pair fits one place without a trunk, infinite if it does not.
    surface : Surface

    Returns
    -------
    sines : (i,) array of float
        Zero for a pair whose limbs overlap, or leave the trunk in another order than that of the junctions; infinite
        for a pair that is right, as on a tube that bends between its junctions.
    """
    sines = np.array(sines)
    ends, lines = skeleton.branch_ends[inner], with_chords(lines, skeleton)
    rows, groups = lines.at(ends)
    is_outer = lines.branches[rows] != inner[groups]
    rows, groups = rows[is_outer], groups[is_outer]
    begins = np.searchsorted(groups, np.arange(len(inner) + 1))
    for pair, ball in enumerate(skeleton.radii[ends].max(axis=1).tolist()):
        outer = lines.take(rows[begins[pair] : begins[pair + 1]])
        trunk = find_trunk(outer, ball, surface)
        if trunk is not None:
            is_at_first = outer.junctions == outer.junctions[trunk.ends[0]]
            near, far = trunk.numbers[is_at_first[trunk.limbs]], trunk.numbers[~is_at_first[trunk.limbs]]
            if not is_at_first[trunk.ends[1]] and len(near) and len(far):
                sines[pair] = np.inf if near.max() < far.min() else 0.0
                continue
        with_thick_limb = outer.junctions[surface.distance(outer.starts) >= MIN_BALL_RATIO * ball]
        if np.isin(ends[pair], with_thick_limb).all():
            sines[pair] = np.inf
    return sines


def split_junctions_along_trunks(
    skeleton: Skeleton, centers: SectionCenters, surface: Surface
) -> tuple[Skeleton, SectionCenters]:
    """Give limbs that leave a trunk at several places junctions of their own.

    Parameters
    ----------
    skeleton : Skeleton
    centers : SectionCenters
        Of the same nodes.
    surface : Surface

    Returns
    -------
    skeleton : Skeleton
        The same one; or one with new junctions, which come last, with inscribed radii alone.
    centers : SectionCenters
    """
    lines, junctions = with_chords(branch_lines(skeleton, centers), skeleton), skeleton.junctions
    rows, groups = lines.at(junctions[:, None])
    begins = np.searchsorted(groups, np.arange(len(junctions) + 1))
    nodes, added, edges = np.array(skeleton.nodes), list[NDArray[np.float64]](), np.array(skeleton.edges)
    n_nodes = len(nodes)
    for number in np.flatnonzero(np.diff(begins) >= 4).tolist():
        junction, own = int(junctions[number]), lines.take(rows[begins[number] : begins[number + 1]])
        [ball] = surface.distance(nodes[[junction]]).tolist()
        trunk = find_trunk(own, ball, surface)
        if trunk is None or len(trunk.places) == 1:
            continue
        chain = np.append(junction, n_nodes + np.arange(len(trunk.places) - 1))
        n_nodes += len(chain) - 1
        beside = [
            skeleton.branches[branch][1 if is_first else -2]
            for branch, is_first in zip(own.branches, own.is_first, strict=True)
        ]
        node_of_line = np.empty(len(beside), dtype=np.int64)
        node_of_line[trunk.ends], node_of_line[trunk.limbs] = chain[[0, -1]], chain[trunk.numbers]
        for row in np.flatnonzero((edges == junction).any(axis=1)).tolist():
            other = skeleton.edges[row].sum() - junction  # which may be split too
            nearest = chain[vector_lengths(trunk.places - skeleton.nodes[other]).argmin()]
            edges[row, edges[row] == junction] = node_of_line[beside.index(other)] if other in beside else nearest
        edges = np.concatenate([edges, np.stack([chain[:-1], chain[1:]], axis=1)])
        nodes[junction] = trunk.places[0]
        added.append(trunk.places[1:])
    if not added:
        return skeleton, centers
    new = np.concatenate(added)
    nodes = np.concatenate([nodes, new])
    is_known = np.concatenate([centers.is_known, np.zeros(len(new), dtype=bool)])
    positions = np.concatenate([centers.positions, new])
    positions[junctions] = nodes[junctions]
    bare = replace(skeleton, nodes=nodes, edges=edges, radii=np.zeros(len(nodes)), mean_radii=np.empty(0))
    return inscribed_radii(bare, surface), SectionCenters(is_known, positions)
