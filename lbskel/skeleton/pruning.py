"""Simplifying a skeleton's graph: spurs cut, near junctions merged.

Every function takes a skeleton and returns one; ``node_of_vertex`` follows what happens to the nodes. A branch that
belongs to a cycle is never cut and a cycle never closed, so the cycle rank stays; anchors stay too.
"""

from __future__ import annotations

__all__ = ["MIN_BRANCH_RATIO", "merge_junctions", "prune", "prune_contained_branches"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.skeleton.editing import contract_nodes
from lbskel.skeleton.skeleton import Skeleton

MIN_BRANCH_RATIO = 1.5  # local radii that an end branch must reach from its junction to be kept
SWALLOWED = 1.75  # radii of a junction within which all balls of a branch lie that says nothing new

STANDS_OUT = 0.65  # radii of a junction from which on a tip tells where its branch leads


def branch_reach(skeleton: Skeleton, mesh: Mesh, branch: NDArray[np.int64]) -> float:
    """How far from a branch's first node the vertices lie that its other nodes stand for."""
    on_branch = np.zeros(len(skeleton.nodes), dtype=bool)
    on_branch[branch[1:]] = True
    far = mesh.vertices[on_branch[skeleton.node_of_vertex]] - skeleton.nodes[branch[0]]
    return float(np.linalg.norm(far, axis=1).max(initial=0.0))


def prune(skeleton: Skeleton, mesh: Mesh, *, ratio: float = MIN_BRANCH_RATIO) -> Skeleton:
    """Cut the end branches that do not stand out of the shape.

    An end branch is a spur where the vertices it stands for reach no further than ``ratio`` times the radius from its
    junction. The shortest goes first, and what it stood for goes to the junction.

    Parameters
    ----------
    skeleton : Skeleton
        With mean radii, or inscribed ones, at its nodes.
    mesh : Mesh
    ratio : float
        In local radii.
    """
    while True:
        ends = [b for b in skeleton.end_branches if not np.isin(b[1:], skeleton.anchors).any()]
        if not ends:
            return skeleton
        spare = [branch_reach(skeleton, mesh, b) / max(skeleton.radii[b[0]], 1e-300) for b in ends]
        shortest = int(np.argmin(spare))
        if spare[shortest] > ratio:
            return skeleton
        target = np.arange(len(skeleton.nodes))
        target[ends[shortest][1:]] = ends[shortest][0]
        skeleton = contract_nodes(skeleton, target)


def prune_contained_branches(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """Cut the end branches whose inscribed balls hardly stand out of that of their junction.

    One whose tip is away from the junction stays if the vertices that it stands for do stand out: its limb is there,
    though the tip is not at its end.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii.
    mesh : Mesh
    """
    target = np.arange(len(skeleton.nodes))
    for way in skeleton.end_branches:
        radius, far = skeleton.radii[way[0]], np.linalg.norm(skeleton.nodes[way] - skeleton.nodes[way[0]], axis=1)
        if (far + skeleton.radii[way]).max() >= SWALLOWED * radius or np.isin(way[1:], skeleton.anchors).any():
            continue
        if far[-1] < STANDS_OUT * radius or branch_reach(skeleton, mesh, way) < SWALLOWED * radius:
            target[way] = way[0]
    return contract_nodes(skeleton, target)


def merge_junctions(skeleton: Skeleton, *, ratio: float = 1.0) -> Skeleton:
    """Make one of two junctions that are joined by a branch shorter than their radius.

    The one with the larger radius keeps its place. The shortest branch goes first, but none that would take a loop with
    it: of three junctions in a ring no two become one.
    """
    while True:
        lengths = {}
        for index, branch in enumerate(skeleton.branches):
            a, b = branch[0], branch[-1]
            if a == b or skeleton.degrees[a] < 3 or skeleton.degrees[b] < 3:
                continue
            if np.isin(branch, skeleton.anchors).any():
                continue
            P = skeleton.nodes[branch]
            length = np.linalg.norm(np.diff(P, axis=0), axis=1).sum()
            if length < ratio * max(skeleton.radii[a], skeleton.radii[b]):
                lengths[index] = length
        for index in sorted(lengths, key=lambda index: (lengths[index], index)):
            branch = skeleton.branches[index]
            keeper = branch[0] if skeleton.radii[branch[0]] >= skeleton.radii[branch[-1]] else branch[-1]
            target = np.arange(len(skeleton.nodes))
            target[branch] = keeper
            merged = contract_nodes(skeleton, target)
            if merged.cycle_rank == skeleton.cycle_rank:
                skeleton = merged
                break
        else:
            return skeleton
