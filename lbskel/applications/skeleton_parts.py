"""The parts of a shape as its skeleton shows them: limbs, the trunk they grow from, and where the thickness jumps.

A limb begins where its branch leaves the inscribed ball of its junction; the ball belongs to the thickest branch there,
if that is almost as thick as the ball, or else is a part of its own, such as the body of an octopus. Of branches about
as thick as the thickest, as torso and legs at a pelvis, it belongs to the one with the most of the skeleton behind it.
Two branches that continue each other straight through a junction, both about as thick as its ball, are one part.
Junctions whose balls meet are one, with the largest of these balls. Along a branch, a part ends where the radius
changes by a factor of JUMP_RATIO within two radii, as at the ball of a dumbbell, unless it tapers on, as in a claw.
"""

from __future__ import annotations

__all__ = ["parts_of_nodes"]

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order

from lbskel.geometry.graphs import connected_labels, weighted_graph
from lbskel.skeleton.skeleton import Skeleton

# Ratio of the radius of a branch to that of its junction, or of another branch, from which the two count as equally
# thick. These constants are swept in benchmarks/results/parts.md, "Constants".
SAME_RATIO = 0.8
STRAIGHT_ANGLE = 150.0  # degrees between two branches from which they are one part
JUMP_RATIO = 1.7  # radii one radius ahead and behind whose ratio ends a part
# Share of the change of the radius at a jump by which it may change again one radius further on the thin side: that is
# 1/2 in a cone, such as a claw, and 0 beside a limb of one thickness; their middle. By hand, 0.15 to 0.25 divide nine
# of ten meshes of creatures alike
MAX_TAPER = 0.25
MIN_LENGTH = 1.2  # length of a part along its branch, in its radii, below which it joins the one beside it
REACH = 3.0  # radii of a junction within which the thickness of a branch is taken
DIRECTION_REACH = 2.0  # radii of a junction within which the direction of a branch is taken


def parts_of_nodes(skeleton: Skeleton, radii: NDArray[np.float64]) -> NDArray[np.int64]:
    """(k,) number of the part of each node; parts are connected in the graph, and numbered by their first nodes.

    Parameters
    ----------
    skeleton : Skeleton
    radii : (k,) array of float
        Thickness at each node, all known.
    """
    k = len(skeleton.nodes)
    stretches = [_Stretch(skeleton, path, radii) for path in skeleton.branches]
    joined = [pair for stretch in stretches for pair in stretch.pairs_inside()]
    meeting = [stretch.path[[0, -1]] for stretch in stretches if all(stretch.is_junction) and not len(stretch.inner)]
    meet = np.array(meeting, dtype=np.int64).reshape(-1, 2)
    group = connected_labels(meet, k)
    at_group: dict[int, list[_End]] = {}
    lengths = _Lengths(skeleton)
    for stretch in stretches:
        for end in stretch.ends(lengths):
            at_group.setdefault(int(group[end.junction]), []).append(end)
    order = skeleton.junctions[np.argsort(-radii[skeleton.junctions], kind="stable")]
    for junction in order[np.unique(group[order], return_index=True)[1]].tolist():
        joined += _joined_at(junction, at_group.get(int(group[junction]), []), float(radii[junction]))
    edges = np.array(joined, dtype=np.int64).reshape(-1, 2)
    label = connected_labels(edges, k)
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number]


class _Lengths:
    """Lengths of a tree that spans the skeleton on either side of each of its edges."""

    def __init__(self, skeleton: Skeleton):
        k, component = len(skeleton.nodes), skeleton.component_of_node
        roots = np.unique(component, return_index=True)[1]
        above_all = np.stack([np.full(len(roots), k), roots], axis=1)
        edges = np.concatenate([skeleton.edges, above_all])
        graph = weighted_graph(edges, np.ones(len(edges)), k + 1)
        order, self.parent = breadth_first_order(graph, k, directed=False)
        self.below = np.zeros(k)
        for node in order[:0:-1].tolist():
            above = self.parent[node]
            if above < k:
                self.below[node] += np.linalg.norm(skeleton.nodes[node] - skeleton.nodes[above])
                self.below[above] += self.below[node]
        self.total = self.below[roots][component]

    def behind(self, node: int, following: int) -> float:
        """Return the length that hangs on a node by the edge to a following one; 0 if the edge is not in the tree."""
        if self.parent[following] == node:
            return float(self.below[following])
        return float(self.total[node] - self.below[node]) if self.parent[node] == following else 0.0


class _End:
    """A branch from the junction at one of its ends: thickness, direction, first node outside, length behind it."""

    def __init__(
        self,
        junction: int,
        first: int,
        ball: list[int],
        radius: float,
        direction: NDArray[np.float64],
        behind: float,
    ):
        self.junction, self.first, self.ball = junction, first, ball
        self.radius, self.direction, self.behind = radius, direction, behind


class _Stretch:
    """A branch, divided into the balls at its ends and what lies between them."""

    def __init__(self, skeleton: Skeleton, path: NDArray[np.int64], radii: NDArray[np.float64]):
        self.path, self.radii, self.nodes = path, radii[path], skeleton.nodes[path]
        self.s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(self.nodes, axis=0), axis=1)))
        self.is_junction = (skeleton.degrees[path[[0, -1]]] > 2).tolist()
        length = self.s[-1]
        begin = self.radii[0] if self.is_junction[0] else -np.inf
        end = length - self.radii[-1] if self.is_junction[1] else np.inf
        self.inner = np.flatnonzero((self.s > begin) & (self.s < end))
        is_end = any(self.is_junction) and not all(self.is_junction)
        if len(self.inner) and is_end:
            outside = min(end, length) - max(begin, 0.0)
            if outside < MIN_LENGTH * np.median(self.radii[self.inner]):
                self.inner = self.inner[:0]  # it hardly leaves the ball

    def pairs_inside(self) -> list[tuple[int, int]]:
        """Pair the nodes outside the balls that are neighbors between two jumps of the thickness."""
        path = self.path.tolist()
        if not len(self.inner):
            return list(pairwise(path))  # the balls of two junctions meet, or it is all ball
        first, last = int(self.inner[0]), int(self.inner[-1])
        jumps = set(_jumps(self.s[self.inner], self.radii[self.inner]))
        return [(path[first + i], path[first + i + 1]) for i in range(last - first) if i not in jumps]

    def ends(self, lengths: _Lengths) -> list[_End]:
        """List the ends at junctions of a branch that leaves their balls."""
        found = []
        for side, is_junction in enumerate(self.is_junction):
            if is_junction and len(self.inner):
                s = self.s if side == 0 else self.s[-1] - self.s
                junction = 0 if side == 0 else -1
                near = self.inner[s[self.inner] <= REACH * self.radii[junction]]
                near = near if len(near) else self.inner[[junction]]
                ahead = near[s[near] <= DIRECTION_REACH * self.radii[junction]]
                ahead = ahead if len(ahead) else self.inner[[junction]]
                far = ahead[-1] if side == 0 else ahead[0]
                direction = self.nodes[far] - self.nodes[junction]
                found.append(
                    _End(
                        int(self.path[junction]),
                        int(self.path[self.inner[junction]]),
                        (self.path[1 : self.inner[0]] if side == 0 else self.path[self.inner[-1] + 1 : -1]).tolist(),
                        float(np.median(self.radii[near])),
                        direction / max(np.linalg.norm(direction), np.finfo(float).tiny),
                        lengths.behind(int(self.path[junction]), int(self.path[1 if side == 0 else -2])),
                    )
                )
        return found


def _joined_at(junction: int, ends: Sequence[_End], radius: float) -> list[tuple[int, int]]:
    """Pair the nodes that join the nodes of a junction's ball, branches to the ball, and branches through it.

    The junction is the thickest of those whose balls meet, and the ends are at any of these. Nodes in the ball on a
    branch as thick as the ball are part of the branch.
    """
    joined = [(end.first if end.radius >= SAME_RATIO * radius else junction, node) for end in ends for node in end.ball]
    cosine = np.cos(np.radians(STRAIGHT_ANGLE))
    thick = [end for end in ends if end.radius >= SAME_RATIO * radius]
    straight = sorted(
        ((float(a.direction @ b.direction), i, j) for (i, a), (j, b) in combinations(enumerate(thick), 2)),
    )
    pairs: list[tuple[_End, _End]] = []
    used: set[int] = set()
    for turn, i, j in straight:
        others = [end.radius for end in ends if end is not thick[i] and end is not thick[j]]
        is_thickest = max(others, default=0.0) <= SAME_RATIO * min(thick[i].radius, thick[j].radius)
        if turn <= cosine and is_thickest and not {i, j} & used:
            used |= {i, j}
            pairs.append((thick[i], thick[j]))
    joined += [(a.first, b.first) for a, b in pairs]
    if pairs:
        owner = max(pairs, key=lambda pair: pair[0].radius + pair[1].radius)[0]
        return [*joined, (junction, owner.first)]
    thickest = max((end.radius for end in ends), default=0.0)
    if thickest >= SAME_RATIO * radius:
        trunk = max((end for end in ends if end.radius >= SAME_RATIO * thickest), key=lambda end: end.behind)
        joined.append((junction, trunk.first))
    return joined


def _jumps(s: NDArray[np.float64], radii: NDArray[np.float64]) -> list[int]:
    """Positions i such that the thickness jumps between nodes i and i + 1 of a path, at arc lengths s."""
    if len(s) < 2:
        return []
    middle = (s[1:] + s[:-1]) / 2
    reach = (radii[1:] + radii[:-1]) / 2
    # medians of three places: between two nodes of which noise makes one thin there is no jump
    ahead, behind, far_ahead, far_behind = (
        np.median([np.interp(middle + share * reach, s, radii) for share in (at - side, at, at + side)], axis=0)
        for at, side in ((1, 0.5), (-1, 0.5), (2, 0.5), (-2, 0.5))
    )
    beyond = np.where(ahead < behind, far_ahead, far_behind)
    tapers = np.minimum(ahead, behind) - beyond > MAX_TAPER * np.abs(ahead - behind)
    smaller = np.minimum(ahead, behind)
    ratio = np.divide(np.maximum(ahead, behind), smaller, out=np.ones(len(s) - 1), where=smaller > 0)
    jumps: list[int] = []
    for i in np.argsort(-ratio, kind="stable").tolist():
        if ratio[i] < JUMP_RATIO:
            break
        if tapers[i]:
            continue
        thicker = max(ahead[i], behind[i])
        to_end, to_jump = (
            min(middle[i] - s[0], s[-1] - middle[i]),
            np.abs(middle[jumps] - middle[i]).min(initial=np.inf),
        )
        if min(to_end, to_jump / 2) >= MIN_LENGTH * thicker:
            jumps.append(i)
    return sorted(jumps)
