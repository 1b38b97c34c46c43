"""The branches of a skeleton that get bones, and which of them go first where there are too many.

A branch at a root is a main one, and so is one that hangs on a main branch and reaches at least as far as half of it.
Others, such as fingers, toes and ears, are ends of limbs: two bones of the branch that they hang on are longer.
"""

from __future__ import annotations

__all__ = ["BoneBranches", "rooted_branches"]

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lbskel.applications.branch_tree import branch_order
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class BoneBranches:
    """Branches of a tree, from the roots outwards; one that has a root inside is two.

    Parameters
    ----------
    skeleton : Skeleton
        A tree for each component.
    roots : (c,) array of int
        One node for each component, or none if they are not chosen yet.
    is_main : (k,) array of bool
        Whether each node is on a main branch.
    """

    skeleton: Skeleton
    roots: NDArray[np.int64]
    is_main: NDArray[np.bool_]

    @cached_property
    def paths(self) -> tuple[NDArray[np.int64], ...]:
        """The nodes of each branch, the end nearer to the root first."""
        is_root = self._is_root
        found: list[NDArray[np.int64]] = []
        for path in branch_order(self.skeleton, roots=self.roots if len(self.roots) else None).paths:
            inside = np.flatnonzero(is_root[path[1:-1]]) + 1
            if len(inside):
                found += [path[: inside[0] + 1][::-1], path[inside[0] :]]
            else:
                found.append(path)
        return tuple(found)

    @cached_property
    def lengths(self) -> NDArray[np.float64]:
        """(b,) length of each branch."""
        nodes = self.skeleton.nodes
        return np.array([np.linalg.norm(np.diff(nodes[path], axis=0), axis=1).sum() for path in self.paths])

    @property
    def minor(self) -> NDArray[np.bool_]:
        """(b,) whether each branch is no main one: what hangs on it is none either."""
        return np.array([not self.is_main[path[1]] for path in self.paths], dtype=bool)

    @property
    def tips(self) -> NDArray[np.float64]:
        """(t, 3) ends of the limbs, without the roots."""
        tips: NDArray[np.float64] = self.skeleton.nodes[(self.skeleton.degrees == 1) & ~self._is_root]
        return tips

    @property
    def _is_root(self) -> NDArray[np.bool_]:
        is_root = np.zeros(len(self.skeleton.nodes), dtype=bool)
        is_root[self.roots] = True
        return is_root

    def without_short(self, least: float) -> BoneBranches:
        """Contract end branches, and then others, that are no main ones and shorter than a length."""
        current = self
        while len(rows := np.flatnonzero((current.lengths < least) & current.minor)):
            current = current.without(rows)
        return current

    def without(self, rows: NDArray[np.int64]) -> BoneBranches:
        """Contract those of some branches that end at a tip, and of the others those that share no end with another.

        The former go into their junctions, the latter into their ends at the root: none gets longer by the others.
        """
        degrees, is_root, target = self.skeleton.degrees, self._is_root, np.arange(len(self.skeleton.nodes))
        is_tip, is_base = (degrees == 1) & ~is_root, (degrees > 2) | is_root
        has_changed, others = np.zeros(len(target), dtype=bool), []
        for row in rows.tolist():
            path = self.paths[row]
            limb = path if is_tip[path[-1]] else path[::-1]
            if is_base[limb[0]] and is_tip[limb[-1]]:
                target[limb[1:]] = limb[0]
                has_changed[limb[0]] = True
            else:
                others.append(path)
        for path in others:
            if not has_changed[path[[0, -1]]].any():
                target[path[1:]] = path[0]
                has_changed[path[[0, -1]]] = True
        is_kept = target == np.arange(len(target))
        roots = (np.cumsum(is_kept) - 1)[self.roots]
        return BoneBranches(contract_nodes(self.skeleton, target), roots, self.is_main[is_kept])

    def with_at_most(self, n: int) -> BoneBranches:
        """Contract the shortest branches, whichever they are, until there are n at most."""
        current = self
        while (excess := len(current.paths) - n) > 0:
            # a limb that leaves a junction of three makes one branch of the other two
            current = current.without(np.argsort(current.lengths, kind="stable")[: (excess + 1) // 2])
        return current


def rooted_branches(tree: Skeleton, least: float) -> BoneBranches:
    """Contract branches shorter than a length, choose the roots, and tell the main branches.

    Parameters
    ----------
    tree : Skeleton
        Without cycles.
    least : float
        In units of the mesh.
    """
    none = np.empty(0, dtype=np.int64)
    kept = BoneBranches(tree, none, np.zeros(len(tree.nodes), dtype=bool)).without_short(least).skeleton
    roots = _roots(kept)
    is_main = np.zeros(len(kept.nodes), dtype=bool)
    is_main[roots] = True
    branches = BoneBranches(kept, roots, is_main)
    paths, lengths = branches.paths, branches.lengths.tolist()
    rows_from: dict[int, list[int]] = {}
    for row, path in enumerate(paths):
        rows_from.setdefault(int(path[0]), []).append(row)
    waiting = deque(row for root in roots.tolist() for row in rows_from.get(root, []))
    outwards: list[tuple[int, list[int]]] = []
    while waiting:
        row = waiting.popleft()
        outwards.append((row, rows_from.get(int(paths[row][-1]), [])))
        waiting += outwards[-1][1]
    reach = list(lengths)
    for row, following in reversed(outwards):
        reach[row] += max((reach[each] for each in following), default=0.0)
    for row, following in outwards:
        if paths[row][0] in roots:
            is_main[paths[row]] = True
        for each in following:
            if is_main[paths[row][1]] and reach[each] >= lengths[row] / 2:
                is_main[paths[each]] = True
    return branches


def _roots(skeleton: Skeleton) -> NDArray[np.int64]:
    """(c,) the root of each component: the junction, or tip if there is none, fewest of its radii from the middle.

    The thickest one may be another after a change of the pose or of the mesh: hips and chest may be as thick.
    """
    component, length, tiny = skeleton.component_of_node, np.zeros(len(skeleton.nodes)), np.finfo(np.float64).tiny
    np.add.at(length, skeleton.edges.ravel(), np.repeat(skeleton.edge_lengths, 2))
    sums = np.stack([np.bincount(component, length * x) for x in skeleton.nodes.T], axis=1)
    middle = sums / np.maximum(np.bincount(component, length), tiny)[:, None]
    with np.errstate(over="ignore"):  # an anchor on the surface has radius 0
        in_radii = np.linalg.norm(skeleton.nodes - middle[component], axis=1) / np.maximum(skeleton.radii, tiny)
    rank = np.minimum(np.where(skeleton.degrees == 2, -1, skeleton.degrees), 3)
    order = np.lexsort((in_radii, -rank, component))
    return order[np.unique(component[order], return_index=True)[1]]
