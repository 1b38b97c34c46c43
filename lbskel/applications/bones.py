"""Bones from a skeleton: few straight segments, the first at the root, joints at bends and where limbs leave the body.

Cycles are cut where they are thinnest; small components are merged into the nearest node of another. A branch becomes
as many bones as fit its length, with joints such that the bones follow its bends, and in equal parts if it has none.
The first joint of a limb is where it leaves the inscribed ball of its junction. While there are too many bones, a least
length is raised, below which branches have fewer bones and ends of limbs have none; where one bone for each main branch
(:mod:`lbskel.applications.bone_branches`) is too many, the shortest of these are dropped. The roots stay.
"""

from __future__ import annotations

__all__ = ["Bones", "bones_of"]

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.applications.bone_branches import BoneBranches, rooted_branches
from lbskel.errors import MeshError
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.spanning_tree import to_tree

# Radii of a branch for each of its bones: arms and legs of 13 to 20 radii have two; 6 to 8.4 do as well
# (benchmarks/results/rig.md, "Constants").
BONE_LENGTH = 7.0
# Weight of the squared differences of the lengths of bones, beside their squared distance from the path, both relative
# to the branch, no unit. 0.002 to 0.0028 give the same joints, 0.0014 puts elbows and knees 0.1 radii farther off (same
# table): bends count where they are clearer than 4 degrees.
EQUAL_WEIGHT = 0.002
# Nodes of a branch among which joints are chosen, or four for each bone if these are more. It bounds the cost, which is
# cubic in them: 0.02 s for a branch. By hand, joints are within 0.3 % of the branch's length of the best ones.
MAX_JOINTS = 200
GROWTH = (
    1.1  # factor by which the least length rises, no unit: the step of a search, which bounds how far it overshoots
)


@dataclass(frozen=True, eq=False)
class Bones:
    """Bones in a tree; a bone comes after its parent.

    Parameters
    ----------
    heads, tails : (b, 3) array of float
    parents : (b,) array of int
        -1 for a root.
    branches : (b,) array of int
        Number of the branch that a bone is part of; -1 for a root.
    bone_of_vertex : (n,) array of int
        The bone that the region of each vertex belongs to.
    limb_ends : (t, 3) array of float
        Ends of all limbs, also of those that got no bone since there would have been too many.
    """

    heads: NDArray[np.float64]
    tails: NDArray[np.float64]
    parents: NDArray[np.int64]
    branches: NDArray[np.int64]
    bone_of_vertex: NDArray[np.int64]
    limb_ends: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))


def bones_of(skeleton: Skeleton, *, max_bones: int) -> Bones:
    """Make bones from a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        With known radii and ``node_of_vertex``.
    max_bones : int
        Largest number of bones, roots included.

    Raises
    ------
    MeshError
        If there are more components than bones allowed.
    """
    tree = _main_components(to_tree(skeleton), max_bones)
    n_roots = tree.n_components
    if max_bones < n_roots:
        raise MeshError(f"max_bones must be at least {n_roots}, one for each component, not {max_bones}")
    least = float(np.median(tree.radii)) if len(tree.radii) else 0.0
    every = branches = rooted_branches(tree, least)
    while True:
        begins = [_first_outside(branches.skeleton, path) for path in branches.paths]
        counts = [
            _count(branches.skeleton, path[begin:], least) for path, begin in zip(branches.paths, begins, strict=True)
        ]
        if n_roots + sum(counts) <= max_bones:
            return _segmented(branches, begins, counts, every.tips)
        if max(counts) == 1 and not branches.minor.any():
            branches = branches.with_at_most(max_bones - n_roots)
        least = max(GROWTH * least, 1e-3 * tree.length)
        branches = branches.without_short(least)


def _main_components(skeleton: Skeleton, max_bones: int) -> Skeleton:
    """Contract the nodes of short components into the nearest node of another.

    Those are shorter than a bone of the longest. If that is shorter itself, as of equal bolts or boots, its length
    takes the place of a bone, and the others count as parts by rounding, as branches do; of more parts than bones the
    longest are kept.
    """
    label = skeleton.component_of_node
    lengths = np.bincount(label[skeleton.edges[:, 0]], skeleton.edge_lengths, minlength=skeleton.n_components)
    if not lengths.max() > 0:  # nodes only: the thickest
        is_main = np.zeros(len(lengths), dtype=bool)
        is_main[label[np.argmax(skeleton.radii)]] = True
    else:
        longest = np.argmax(lengths)
        bone = BONE_LENGTH * float(np.median(skeleton.radii[label == longest]))
        is_main = (lengths >= bone) | ((lengths[longest] < bone) & (np.rint(lengths / lengths[longest]) > 0))
        shorter = np.argsort(-lengths, kind="stable")[max_bones:]
        is_main[shorter] &= lengths[shorter] >= bone
    kept = np.flatnonzero(is_main[label])
    lost = np.flatnonzero(~is_main[label])
    target = np.arange(len(skeleton.nodes))
    if len(lost):
        target[lost] = kept[cKDTree(skeleton.nodes[kept]).query(skeleton.nodes[lost])[1]]
    kept_edges = skeleton.edges[is_main[label[skeleton.edges[:, 0]]]]
    return contract_nodes(replace(skeleton, edges=kept_edges), target)


def _length(skeleton: Skeleton, path: NDArray[np.int64]) -> float:
    return float(np.linalg.norm(np.diff(skeleton.nodes[path], axis=0), axis=1).sum())


def _count(skeleton: Skeleton, path: NDArray[np.int64], least: float) -> int:
    """Count the bones of a branch."""
    length = _length(skeleton, path)
    radius = max(float(skeleton.radii[path].mean()), np.finfo(np.float64).tiny)
    wanted = min(length / (BONE_LENGTH * radius), length / max(least, np.finfo(np.float64).tiny))
    return max(1, min(round(wanted), len(path) - 1))


def _segmented(
    branches_of: BoneBranches, begins: Sequence[int], counts: Sequence[int], limb_ends: NDArray[np.float64]
) -> Bones:
    """Divide every branch into its number of bones, from the root outwards."""
    skeleton, roots, paths = branches_of.skeleton, branches_of.roots, branches_of.paths
    bone_of_node = np.full(len(skeleton.nodes), -1)
    heads: list[NDArray[np.float64]] = []
    tails: list[NDArray[np.float64]] = []
    parents: list[int] = []
    branches: list[int] = []
    for root in roots.tolist():
        bone_of_node[root] = len(heads)
        heads.append(skeleton.nodes[root])
        tails.append(skeleton.nodes[root] + [0, skeleton.radii[root], 0])
        parents.append(-1)
        branches.append(-1)
    rows_from: dict[int, list[int]] = {}
    for row, path in enumerate(paths):
        rows_from.setdefault(int(path[0]), []).append(row)
    waiting = [row for root in roots.tolist() for row in rows_from.get(root, [])]
    heapify(waiting)
    while waiting:
        row = heappop(waiting)
        path, begin = paths[row], begins[row]
        parent = int(bone_of_node[path[0]])
        bone_of_node[path[1:begin]] = parent
        for first, last in pairwise(_joints(skeleton.nodes[path[begin:]], counts[row])):
            own = path[begin + first : begin + last + 1]
            bone_of_node[own if first == 0 and begin else own[1:]] = len(heads)
            heads.append(skeleton.nodes[path[begin + first]])
            tails.append(skeleton.nodes[path[begin + last]])
            parents.append(parent)
            branches.append(row)
            parent = len(heads) - 1
        for following in rows_from.get(int(path[-1]), []):
            heappush(waiting, following)
    bone_of_vertex = bone_of_node[skeleton.node_of_vertex]
    return Bones(np.array(heads), np.array(tails), np.array(parents), np.array(branches), bone_of_vertex, limb_ends)


def _first_outside(skeleton: Skeleton, path: NDArray[np.int64]) -> int:
    """Find the position on a branch at which its first bone begins: 0, or the first outside of the junction's ball."""
    radius = float(skeleton.radii[path[0]])
    if skeleton.degrees[path[0]] < 3:
        return 0
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(skeleton.nodes[path], axis=0), axis=1)))
    outside = np.flatnonzero(s > radius)
    return int(outside[0]) if len(outside) > 1 else 0


def _joints(nodes: NDArray[np.float64], n: int) -> list[int]:
    """Positions of the joints on a path, its ends included, that divide it into n bones at the least cost."""
    kept = np.unique(np.linspace(0, len(nodes) - 1, min(len(nodes), max(MAX_JOINTS, 4 * n))).round().astype(np.int64))
    P, k = nodes[kept], len(kept)
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(P, axis=0), axis=1)))
    if n == 1 or not s[-1] > 0:
        return [0, len(nodes) - 1]
    s, P = s / s[-1], (P - P[0]) / s[-1]
    share = np.gradient(s)
    cost = np.full((k, k), np.inf)
    for i in range(k - 1):
        offset = P[i:] - P[i]  # of the nodes in between, along the second axis, and of the ends, along the first
        squared = (offset * offset).sum(axis=1)
        along = np.clip(offset @ offset.T / np.maximum(squared, np.finfo(np.float64).tiny)[:, None], 0, 1)
        away = sum((x - along * x[:, None]) ** 2 for x in offset.T)
        cost[i, i + 1 :] = (np.tril(away) @ share[i:])[1:] + EQUAL_WEIGHT * (s[i + 1 :] - s[i] - 1 / n) ** 2
    best, previous = cost[0].copy(), []
    for _ in range(n - 1):
        through = best[:, None] + cost
        previous.append(through.argmin(axis=0))
        best = through.min(axis=0)
    joints = [k - 1]
    for before in reversed(previous):
        joints.append(int(before[joints[-1]]))
    return [int(kept[joint]) for joint in (0, *reversed(joints))]
