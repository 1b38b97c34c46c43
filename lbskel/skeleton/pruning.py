"""Simplifying a skeleton's graph: short end branches are removed, close junctions are merged.

``prune`` and ``merge_junctions`` return a skeleton whose ``node_of_vertex`` has the nodes that take the place of those
removed. Branches on a cycle are never removed and no cycle is contracted, so the cycle rank is kept; anchors are kept
too.
"""

from __future__ import annotations

__all__ = [
    "MIN_BRANCH_RATIO",
    "adjacent_junctions",
    "closes_a_cycle",
    "farthest_vertices",
    "inner_branch_lengths",
    "merge_junctions",
    "prune",
    "without_stubs",
]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, UnknownChoice, is_number
from lbskel.geometry.components import find_crumbs
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import group_medians, is_among, stable_float_order
from lbskel.skeleton.editing import contract_branches, contract_nodes
from lbskel.skeleton.joining import with_present_joining_edges
from lbskel.skeleton.skeleton import Skeleton

MIN_BRANCH_RATIO = 1.5  # default distance from its junction that an end branch reaches, in local radii; a guess


def farthest_vertices(
    skeleton: Skeleton, mesh: Mesh, branches: list[NDArray[np.int64]]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(b,) vertex farthest from the first node of each branch, of those mapped to its other nodes, and (b,) distances.

    A branch without vertices has vertex 0 at distance 0.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    mesh : Mesh
    branches : list of b (k,) arrays of int
        Nodes of each branch; no two branches share a node other than their first.
    """
    branch_of_node = np.full(len(skeleton.nodes), -1)
    for number, branch in enumerate(branches):
        branch_of_node[branch[1:]] = number
    branch_of_vertex = branch_of_node[skeleton.node_of_vertex]
    used = mesh.used_vertices  # others may be anywhere
    on_branch = used[branch_of_vertex[used] >= 0]
    first = np.array([branch[0] for branch in branches], dtype=np.int64)
    offsets = mesh.vertices[on_branch] - skeleton.nodes[first[branch_of_vertex[on_branch]]]
    distances = vector_lengths(offsets)
    ascending = on_branch[stable_float_order(distances)]
    vertices, reaches = np.zeros(len(branches), dtype=np.int64), np.zeros(len(branches))
    vertices[branch_of_vertex[ascending]] = ascending  # the last assignment counts
    np.maximum.at(reaches, branch_of_vertex[on_branch], distances)
    return vertices, reaches


def prune(skeleton: Skeleton, mesh: Any, *, min_branch_ratio: float = MIN_BRANCH_RATIO) -> Skeleton:
    """Remove the end branches whose surface does not reach far enough from their junction.

    A branch is removed if no vertex that is mapped to it is farther from its junction than ``min_branch_ratio`` times
    the radius there; vertices of components too small for a skeleton do not count. At each junction the shortest go
    first, until two branches are left, and their vertices go to the junction. Branches with an anchor stay.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``. Its radii may be inscribed or mean ones.
    mesh : Mesh, (vertices, faces), path or mesh object
        The mesh that ``node_of_vertex`` belongs to.
    min_branch_ratio : float
        In radii of the junction.

    Raises
    ------
    MeshError
        If the skeleton has no map, or one for another number of vertices than the mesh has.
    UnknownChoice
        If the ratio is negative or NaN.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import make
    >>> mesh = make("tripod", n_vertices=800).mesh
    >>> skeleton = lbskel.skeletonize(mesh)
    >>> len(skeleton.tips), len(lbskel.prune(skeleton, mesh, min_branch_ratio=50).tips)
    (3, 2)
    """
    if not (is_number(min_branch_ratio) and min_branch_ratio >= 0):
        raise UnknownChoice(f"min_branch_ratio must be a number of local radii, 0 or more, not {min_branch_ratio!r}")
    mesh = as_mesh(mesh)
    if len(skeleton.node_of_vertex) != len(mesh.vertices):
        raise MeshError(
            f"prune needs the mesh that the skeleton's node_of_vertex belongs to: the map has "
            f"{len(skeleton.node_of_vertex)} vertices and the mesh {len(mesh.vertices)}"
        )
    is_counted = ~find_crumbs(mesh)[mesh.component_of_vertex[mesh.faces[:, 0]]]
    if 0 < np.count_nonzero(is_counted) < len(is_counted):
        mesh = Mesh(mesh.vertices, mesh.faces[is_counted])
    return with_present_joining_edges(skeleton, _pruned(skeleton, mesh, min_branch_ratio))


def _pruned(skeleton: Skeleton, mesh: Mesh, min_branch_ratio: float) -> Skeleton:
    """Remove the shortest end branches of each junction, until none is short or two branches are left."""
    while True:
        is_anchor = np.zeros(len(skeleton.nodes), dtype=bool)
        is_anchor[skeleton.anchors] = True
        ends = [branch for branch in skeleton.end_branches if not is_anchor[branch[1:]].any()]
        if not ends:
            return skeleton
        junctions = np.array([b[0] for b in ends])
        ratios = farthest_vertices(skeleton, mesh, ends)[1] / np.maximum(skeleton.radii[junctions], 1e-300)
        order = np.lexsort((ratios, junctions))
        rank = np.arange(len(order)) - np.searchsorted(junctions[order], junctions[order])
        # two branches are left at each junction
        shortest = order[rank < skeleton.degrees[junctions[order]] - 2]
        short = shortest[ratios[shortest] <= min_branch_ratio]
        if len(short) == 0:
            return skeleton
        skeleton = contract_branches(skeleton, [ends[end] for end in short.tolist()])


def without_stubs(before: Skeleton, joined: Skeleton) -> Skeleton:
    """Contract what is left of a branch beyond a joining edge that leaves it next to its tip.

    That is at most MIN_BRANCH_RATIO radii long; a branch with an anchor stays.

    Parameters
    ----------
    before : Skeleton
    joined : Skeleton
        With the same nodes, and additional edges between the components.
    """
    piece, shortest = before.component_of_node, dict[int, tuple[float, NDArray[np.int64]]]()
    for end in joined.end_branches:
        junction = int(end[0])
        is_left = before.degrees[junction] == 2 and (piece[end] == piece[junction]).all()
        if is_left and not is_among(end[1:], joined.anchors).any():
            reach = float(vector_lengths(joined.nodes[end] - joined.nodes[junction]).max())
            if reach <= MIN_BRANCH_RATIO * joined.radii[junction] and reach < shortest.get(junction, (np.inf,))[0]:
                shortest[junction] = reach, end
    return contract_branches(joined, [end for _, end in shortest.values()])


def merge_junctions(skeleton: Skeleton, *, ratio: float = 1.0) -> Skeleton:
    """Merge pairs of junctions that are joined by a branch shorter than their radius, and whose limbs overlap there.

    Two thin limbs on a thick one have room beside each other, and do not overlap, where the branch between their
    junctions is at least as long as the sum of their radii. The radius of a limb is the median of its nodes outside of
    the junction's ball. At each junction the thinnest branch counts, that between the two included. The junction with
    the larger radius keeps its position. The shortest branch goes first, unless that would remove a cycle: the three
    junctions of a triangle are never merged.

    Parameters
    ----------
    skeleton : Skeleton
    ratio : float
        Length of the branch below which its junctions are merged, as a multiple of the smaller of two lengths: the
        larger radius of the two junctions, and the sum of the radii of the thinnest branches at them.

    Raises
    ------
    UnknownChoice
        If the ratio is negative or NaN.

    Examples
    --------
    >>> import lbskel
    >>> nodes = [[-2, 1, 0], [-2, -1, 0], [0, 0, 0], [0.2, 0, 0], [2, 1, 0], [2, -1, 0]]
    >>> near = lbskel.Skeleton(nodes, [[0, 2], [1, 2], [2, 3], [3, 4], [3, 5]], [1] * 6)
    >>> len(near.junctions), len(lbskel.merge_junctions(near).junctions)
    (2, 1)
    """
    if not (is_number(ratio) and ratio >= 0):
        raise UnknownChoice(f"ratio must be a number of local radii, 0 or more, not {ratio!r}")
    while True:
        is_anchor = np.zeros(len(skeleton.nodes), dtype=bool)
        is_anchor[skeleton.anchors] = True
        lengths, ends = inner_branch_lengths(skeleton)
        known = np.where(np.isnan(skeleton.radii), 0.0, skeleton.radii)
        limits = np.minimum(known[ends].max(axis=1), _thinnest_branches(skeleton)[ends].sum(axis=1))
        short = np.flatnonzero(lengths < ratio * limits)
        short = short[np.argsort(lengths[short], kind="stable")]
        first, beside = adjacent_junctions(skeleton)
        target, is_touched = np.arange(len(skeleton.nodes)), np.zeros(len(skeleton.nodes), dtype=bool)
        for index in short.tolist():
            branch = skeleton.branches[index]
            if is_anchor[branch].any() or is_touched[branch[[0, -1]]].any() or closes_a_cycle(skeleton, branch):
                continue
            # the branches beside it change, so that theirs have to wait
            is_touched[branch] = is_touched[beside[first[branch[0]] : first[branch[0] + 1]]] = True
            is_touched[beside[first[branch[-1]] : first[branch[-1] + 1]]] = True
            kept = branch[0] if known[branch[0]] >= known[branch[-1]] else branch[-1]
            target[branch] = kept
        if not is_touched.any():
            return skeleton
        skeleton = contract_nodes(skeleton, target)


def _thinnest_branches(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k,) radius of the thinnest branch that ends at each node, infinite where none ends.

    The radius of a branch is the median of its nodes outside of the ball at that end; of all, where none is outside.
    Nodes whose radius is not known do not count.
    """
    nodes, begins = skeleton.flat_branches
    number = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    is_known = ~np.isnan(skeleton.radii[nodes])
    radii = np.where(is_known, skeleton.radii[nodes], np.inf)
    thinnest = np.full(len(skeleton.nodes), np.inf)
    for end in skeleton.branch_ends.T:
        center = end[number]
        is_within = vector_lengths(skeleton.nodes[nodes] - skeleton.nodes[center]) <= skeleton.radii[center]
        is_used = is_known & ~is_within
        for others in (is_known, ~is_known):  # where a branch has none of those before
            is_used |= others & (np.bincount(number[is_used], minlength=len(end))[number] == 0)
        counts = np.bincount(number[is_used], minlength=len(end))
        medians = group_medians(radii[is_used], np.append(0, np.cumsum(counts)))
        np.minimum.at(thinnest, end, medians)
    return thinnest


def inner_branch_lengths(skeleton: Skeleton) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(b,) length of each branch between two different junctions, infinite for others, and (b, 2) its end nodes.

    Parameters
    ----------
    skeleton : Skeleton
    """
    (nodes, begins), ends = skeleton.flat_branches, skeleton.branch_ends
    steps = vector_lengths(np.diff(skeleton.nodes[nodes], axis=0, append=skeleton.nodes[nodes[-1:]]))
    steps[begins[1:] - 1] = 0.0
    is_inner = (ends[:, 0] != ends[:, 1]) & (skeleton.degrees[ends] >= 3).all(axis=1)
    lengths = np.add.reduceat(steps, begins[:-1]) if len(ends) else np.empty(0)
    return np.where(is_inner, lengths, np.inf), ends


def closes_a_cycle(skeleton: Skeleton, branch: NDArray[np.int64]) -> bool:
    """Whether another path of at most two edges joins the ends of a branch: merging these would remove a cycle.

    Parameters
    ----------
    skeleton : Skeleton
    branch : (k,) array of int
        Its nodes.
    """
    first, adjacent = skeleton.adjacency
    one, other = (set(adjacent[first[end] : first[end + 1]].tolist()) for end in branch[[0, -1]])
    within = set(branch.tolist())
    return bool((one & other) - within) or (len(branch) > 2 and int(branch[-1]) in one)


def adjacent_junctions(skeleton: Skeleton) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Adjacency of nodes that are the two ends of a branch, in the form of ``Skeleton.adjacency``.

    Parameters
    ----------
    skeleton : Skeleton
    """
    both = np.concatenate([skeleton.branch_ends, skeleton.branch_ends[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    return np.searchsorted(both[order, 0], np.arange(len(skeleton.nodes) + 1)), both[order, 1]
