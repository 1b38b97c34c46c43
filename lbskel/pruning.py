"""Simplifying a skeleton's graph: spurs cut, near junctions merged, branches evenly resampled.

Every function takes a skeleton and returns one; ``node_of_vertex`` follows what happens to the nodes. A branch that
belongs to a cycle is never cut and a cycle never closed, so the cycle rank stays.
"""

from __future__ import annotations

__all__ = ["cut_swallowed", "merge_into", "merge_junctions", "prune", "resample"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.mesh import Mesh
from lbskel.skeleton import Skeleton

FINER = 4  # pieces at most for each that a branch had: what is flat has no radius to go by


def _regroup(skeleton: Skeleton, group: NDArray[np.int64], keeper: NDArray[np.int64]) -> Skeleton:
    """Nodes of one group become one node, at the place of its keeper."""
    return replace(
        skeleton,
        nodes=skeleton.nodes[keeper],
        edges=group[skeleton.edges],
        radii=skeleton.radii[keeper],
        node_of_vertex=group[skeleton.node_of_vertex],
    )


def merge_into(skeleton: Skeleton, target: NDArray[np.int64]) -> Skeleton:
    """Each node goes into its target, a node that is its own target."""
    keeper, group = np.unique(target, return_inverse=True)
    return _regroup(skeleton, group, keeper)


def reaches(skeleton: Skeleton, mesh: Mesh, branch: NDArray[np.int64]) -> float:
    """How far from a branch's first node the vertices lie that its other nodes stand for."""
    on_branch = np.zeros(len(skeleton.nodes), dtype=bool)
    on_branch[branch[1:]] = True
    far = mesh.vertices[on_branch[skeleton.node_of_vertex]] - skeleton.nodes[branch[0]]
    return float(np.linalg.norm(far, axis=1).max(initial=0.0))


def prune(skeleton: Skeleton, mesh: Mesh, *, ratio: float = 1.5) -> Skeleton:
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
        ends = [b if skeleton.degrees[b[0]] > 1 else b[::-1] for b in skeleton.branches]
        ends = [b for b in ends if skeleton.degrees[b[-1]] == 1 and skeleton.degrees[b[0]] >= 3]
        if not ends:
            return skeleton
        spare = [reaches(skeleton, mesh, b) / max(skeleton.radii[b[0]], 1e-300) for b in ends]
        shortest = int(np.argmin(spare))
        if spare[shortest] > ratio:
            return skeleton
        target = np.arange(len(skeleton.nodes))
        target[ends[shortest][1:]] = ends[shortest][0]
        skeleton = merge_into(skeleton, target)


def cut_swallowed(skeleton: Skeleton) -> Skeleton:
    """Cut the end branches that never leave the inscribed ball of their junction.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii.
    """
    target = np.arange(len(skeleton.nodes))
    for branch in skeleton.branches:
        way = branch if skeleton.degrees[branch[-1]] == 1 else branch[::-1]
        far = np.linalg.norm(skeleton.nodes[way] - skeleton.nodes[way[0]], axis=1).max()
        if skeleton.degrees[way[-1]] == 1 and skeleton.degrees[way[0]] >= 3 and far < skeleton.radii[way[0]]:
            target[way] = way[0]
    return merge_into(skeleton, target)


def merge_junctions(skeleton: Skeleton, *, ratio: float = 1.0) -> Skeleton:
    """Make one of two junctions that are joined by a branch shorter than their radius.

    The one with the larger radius keeps its place. The shortest branch goes first.
    """
    while True:
        lengths = {}
        pairs = [(int(b[0]), int(b[-1])) for b in skeleton.branches]
        for index, branch in enumerate(skeleton.branches):
            a, b = pairs[index]
            if a == b or skeleton.degrees[a] < 3 or skeleton.degrees[b] < 3:
                continue
            beside = [len(other) for k, other in enumerate(skeleton.branches) if k != index and set(pairs[k]) == {a, b}]
            if beside and min(beside) < 4:  # it would become a loop of fewer than three nodes
                continue
            P = skeleton.nodes[branch]
            length = np.linalg.norm(np.diff(P, axis=0), axis=1).sum()
            if length < ratio * max(skeleton.radii[a], skeleton.radii[b]):
                lengths[index] = length
        if not lengths:
            return skeleton
        branch = skeleton.branches[min(lengths, key=lambda index: (lengths[index], index))]
        keeper = branch[0] if skeleton.radii[branch[0]] >= skeleton.radii[branch[-1]] else branch[-1]
        target = np.arange(len(skeleton.nodes))
        target[branch] = keeper
        skeleton = merge_into(skeleton, target)


def resample(skeleton: Skeleton, *, spacing: float) -> Skeleton:
    """Space the nodes evenly along each branch; junctions, tips and loops stay.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float
        Distance between nodes aimed at, in median radii of each branch.

    Raises
    ------
    UnknownChoice
        If the spacing is not positive.
    """
    if not spacing > 0:
        raise UnknownChoice(f"spacing must be positive, not {spacing}")
    fixed = np.flatnonzero(skeleton.degrees != 2)
    loops = [int(b[0]) for b in skeleton.branches if b[0] == b[-1] and skeleton.degrees[b[0]] == 2]
    fixed = np.union1d(fixed, np.array(loops, dtype=np.int64))
    new_of = np.full(len(skeleton.nodes), -1)
    new_of[fixed] = np.arange(len(fixed))
    nodes, radii, edges = [skeleton.nodes[fixed]], [skeleton.radii[fixed]], []
    n_nodes, ends_seen = len(fixed), set()
    for branch in skeleton.branches:
        P, ends = skeleton.nodes[branch], frozenset((int(branch[0]), int(branch[-1])))
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(P, axis=0), axis=1))])
        least = 3 if len(ends) == 1 else 2 if ends in ends_seen else 1
        ends_seen.add(ends)
        apart = max(spacing * float(np.median(skeleton.radii[branch])), along[-1] / (FINER * (len(branch) - 1)))
        n_pieces = max(least, round(along[-1] / apart)) if apart > 0 else least
        at = np.linspace(0, along[-1], n_pieces + 1)
        inner = at[1:-1]
        nodes.append(np.stack([np.interp(inner, along, P[:, axis]) for axis in range(3)], axis=1))
        radii.append(np.interp(inner, along, skeleton.radii[branch]))
        chain = np.concatenate([[new_of[branch[0]]], n_nodes + np.arange(len(inner)), [new_of[branch[-1]]]])
        n_nodes += len(inner)
        edges.append(np.stack([chain[:-1], chain[1:]], axis=1))
        nearest = np.rint(along[1:-1] / max(along[-1], 1e-300) * n_pieces).astype(np.int64)
        new_of[branch[1:-1]] = chain[nearest]
    return replace(
        skeleton,
        nodes=np.concatenate(nodes),
        edges=np.concatenate(edges) if edges else np.empty((0, 2), dtype=np.int64),
        radii=np.concatenate(radii),
        node_of_vertex=new_of[skeleton.node_of_vertex],
    )
