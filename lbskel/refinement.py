"""Refinement: from the graph that surgery leaves to nodes on the axis of their sections.

A node inside a branch belongs at the centroid of the surface's section across the branch, which depends neither on how
the surface is sampled nor on how far it was contracted. Near a junction the section is not the branch's own, so the
branch is carried on smoothly to the junction, and the junction goes where the axes of its branches meet.

The place of a skeleton node as the centroid of its cross-section: Cornea, Silver, Min 2007, "Curve-skeleton properties,
applications, and algorithms", https://doi.org/10.1109/TVCG.2007.1002, on centredness.
"""

from __future__ import annotations

__all__ = ["inscribed_radii", "mean_radii", "recenter", "settle"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array

from lbskel.mesh import Mesh
from lbskel.sections import Sections, cut
from lbskel.skeleton import Skeleton
from lbskel.solvers import factorize
from lbskel.surface import Surface

OWN = 0.85  # a section with less of its curve on its own branch is another branch's too
STIFFNESS = 1.0  # of a branch against bending, beside a weight of 1 on each section's centroid
ANCHOR = 1e-3  # weight on a node's contracted place, which counts where it has no section of its own
LEAP = 1.3  # a branch of its own does not grow by this factor from one node to the next
NEAR = 4  # sections that tell the axis of a branch at its junction
FARTHEST = 3.0  # radii of a junction from which the axis of a branch still points to it
FREE = 0.5  # radii by which a junction may leave its contracted place
ANCHORED = 0.05  # weight of a junction's contracted place, beside the axes of its branches


def inscribed_radii(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """The skeleton with the distance to the surface as the radius of each node."""
    return replace(skeleton, radii=surface.distance(skeleton.nodes), radius_kind="inscribed")


def mean_radii(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with, for each node, the mean distance of the vertices that it stands for.

    A node that stands for none takes the mean of its neighbours along the skeleton.
    """
    count = np.bincount(skeleton.node_of_vertex, minlength=len(skeleton.nodes))
    distance = np.linalg.norm(mesh.vertices - skeleton.nodes[skeleton.node_of_vertex], axis=1)
    total = np.bincount(skeleton.node_of_vertex, weights=distance, minlength=len(skeleton.nodes))
    known = count > 0
    radii = np.where(known, total / np.maximum(count, 1), 0.0)
    i, j = np.concatenate([skeleton.edges, skeleton.edges[:, ::-1]]).T
    while not known.all():
        near = np.bincount(i, weights=known[j], minlength=len(known))
        value = np.bincount(i, weights=radii[j] * known[j], minlength=len(known))
        fresh = ~known & (near > 0)
        if not fresh.any():
            break
        radii[fresh] = value[fresh] / near[fresh]
        known = known | fresh
    return replace(skeleton, radii=radii, radius_kind="mean")


def settle(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with each vertex handed on along the edges to a nearer node, as long as there is one next to it."""
    degrees = skeleton.degrees
    beside = np.tile(np.arange(len(degrees))[:, None], (1, int(degrees.max(initial=0)) + 1))
    for node, neighbours in enumerate(skeleton.neighbours):
        beside[node, 1 : 1 + len(neighbours)] = neighbours
    node_of_vertex = np.array(skeleton.node_of_vertex)
    moving = np.arange(len(node_of_vertex))
    while len(moving):
        choices = beside[node_of_vertex[moving]]
        apart = np.linalg.norm(skeleton.nodes[choices] - mesh.vertices[moving, None, :], axis=2)
        nearest = np.argmin(apart, axis=1)  # of equals the first, which is the node itself
        node_of_vertex[moving] = choices[np.arange(len(moving)), nearest]
        moving = moving[nearest > 0]
    return replace(skeleton, node_of_vertex=node_of_vertex)


def _branch_of_node(skeleton: Skeleton) -> NDArray[np.int64]:
    """The branch of each node; -1 at junctions, which belong to several."""
    branch_of = np.full(len(skeleton.nodes), -1)
    for index, branch in enumerate(skeleton.branches):
        branch_of[branch] = index
    branch_of[skeleton.degrees >= 3] = -1
    return branch_of


def _tangents(skeleton: Skeleton) -> NDArray[np.float64]:
    """Unit direction of each node's branch, from the nodes before and after it; zero at junctions."""
    tangents = np.zeros_like(skeleton.nodes)
    for branch in skeleton.branches:
        P = skeleton.nodes[branch]
        if branch[0] == branch[-1]:
            P = np.concatenate([P[-2:-1], P, P[1:2]])
            tangents[branch] = P[2:] - P[:-2]
        else:
            tangents[branch] = np.gradient(P, axis=0)
    tangents[skeleton.degrees >= 3] = 0
    length = np.linalg.norm(tangents, axis=1, keepdims=True)
    return np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0)


def recenter(skeleton: Skeleton, surface: Surface, *, iterations: int = 2) -> Skeleton:
    """Move every node to the axis of the shape there; tips move with the end of their branch.

    Parameters
    ----------
    skeleton : Skeleton
        With branches evenly sampled.
    surface : Surface
        In the same coordinates.
    iterations : int
    """
    mesh = surface.mesh
    branch_of = _branch_of_node(skeleton)
    face_labels = branch_of[skeleton.node_of_vertex][mesh.faces[:, 0]]
    within = np.flatnonzero(branch_of >= 0)
    start = skeleton
    for _ in range(iterations):
        tangents = _tangents(skeleton)
        at = within[np.linalg.norm(tangents[within], axis=1) > 0]
        sections = cut(mesh, skeleton.nodes[at], tangents[at], face_labels=face_labels, labels=branch_of[at])
        good = np.zeros(len(skeleton.nodes), dtype=bool)
        good[at] = _is_own(sections, start.nodes[at], surface) & (skeleton.degrees[at] == 2)
        radii = np.zeros(len(skeleton.nodes))
        radii[at] = sections.radii
        good &= _grows_slowly(skeleton, good, radii)
        target = np.array(start.nodes)
        target[at[good[at]]] = sections.centroids[good[at]]
        target[skeleton.degrees >= 3] = _place_junctions(start, target, good, surface)
        weight = np.where(good, 1.0, ANCHOR)
        weight[skeleton.degrees >= 3] = 1 / ANCHOR
        skeleton = replace(skeleton, nodes=_carried_on(start, target, weight, good, branch_of, surface))
    return skeleton


def _is_own(sections: Sections, contracted: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """Which sections are cut across one branch alone, about the place it was contracted to, and hold their centroid."""
    shift = np.linalg.norm(sections.centroids - contracted, axis=1)
    is_own = sections.is_cut & (sections.own >= OWN) & (shift <= sections.radii)
    is_own[is_own] = surface.contains(sections.centroids[is_own])
    return is_own


def _grows_slowly(skeleton: Skeleton, good: NDArray[np.bool_], radii: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which nodes are reached from the middle of their branch without a leap in the size of the section.

    Where a branch runs into another, its section becomes the other's within a step.
    """
    reached = np.zeros(len(good), dtype=bool)
    for branch in skeleton.branches:
        own = branch[good[branch]]
        middle = len(own) // 2
        for way in (own[middle:], own[: middle + 1][::-1]):
            leaps = np.flatnonzero(radii[way[1:]] > LEAP * radii[way[:-1]])
            reached[way[: leaps[0] + 1 if len(leaps) else len(way)]] = True
    return reached


def _place_junctions(
    start: Skeleton, target: NDArray[np.float64], good: NDArray[np.bool_], surface: Surface
) -> NDArray[np.float64]:
    """Where the axes of each junction's branches come nearest to one point.

    An axis counts from the first own sections of its branch, and only from near: it is not known to run straight for
    longer. A junction moves by no more than FREE of its radius and never out of the shape.
    """
    junctions = start.junctions
    placed = np.array(start.nodes[junctions])
    radii = surface.distance(placed)
    row_of = {int(junction): row for row, junction in enumerate(junctions)}
    A = np.zeros((len(junctions), 3, 3))
    b = np.zeros((len(junctions), 3))
    n_axes = np.zeros(len(junctions), dtype=np.int64)
    for branch in start.branches:
        for way in (branch, branch[::-1]):
            row = row_of.get(int(way[0]))
            own = way[1:-1][good[way[1:-1]]][:NEAR]
            if row is None or len(own) < 2:
                continue
            direction = target[own[0]] - target[own[-1]]
            direction /= np.linalg.norm(direction)
            to_axis = target[own].mean(axis=0) - start.nodes[way[0]]
            far = float(np.linalg.norm(target[own[0]] - start.nodes[way[0]]))
            if far > FARTHEST * radii[row]:
                continue
            across = (np.eye(3) - np.outer(direction, direction)) / max(far, radii[row]) ** 2
            A[row] += across
            b[row] += across @ to_axis
            n_axes[row] += 1
    for row in np.flatnonzero(n_axes >= 2).tolist():
        move = np.linalg.solve(A[row] + ANCHORED * np.trace(A[row]) * np.eye(3), b[row])
        length = float(np.linalg.norm(move))
        placed[row] += move * min(1.0, FREE * radii[row] / length) if length > 0 else 0.0
    outer = ~surface.contains(placed) if len(placed) else np.empty(0, dtype=bool)
    placed[outer] = start.nodes[junctions[outer]]
    return placed


def _carried_on(
    start: Skeleton,
    target: NDArray[np.float64],
    weight: NDArray[np.float64],
    good: NDArray[np.bool_],
    branch_of: NDArray[np.int64],
    surface: Surface,
) -> NDArray[np.float64]:
    """Nodes near their targets; where a branch has no sections of its own it is carried on to its junction.

    It goes straight or in a curve, whichever is nearer to the way it was contracted to; and where neither stays in the
    shape, beside that way.
    """
    straight, curved = (_fair(start, target, weight, good, bends) for bends in (False, True))
    gap = ~good & (branch_of >= 0)
    n_branches = len(start.branches)
    off = [
        np.bincount(branch_of[gap], weights=((way - start.nodes)[gap] ** 2).sum(axis=1), minlength=n_branches)
        for way in (straight, curved)
    ]
    curves = gap & (off[1] < off[0])[branch_of]
    nodes = np.where(curves[:, None], curved, straight)
    outer = gap & ~surface.contains(nodes)
    if outer.any():
        beside = gap & np.isin(branch_of, branch_of[outer])
        nodes[beside] = (start.nodes + _fair(start, target - start.nodes, weight, good, False))[beside]
    return nodes


def _fair(
    skeleton: Skeleton,
    target: NDArray[np.float64],
    weight: NDArray[np.float64],
    good: NDArray[np.bool_],
    bends: bool,
) -> NDArray[np.float64]:
    """Nodes near their targets, by weight, on branches that bend little: a smoothing spline.

    Unless the branch ``bends`` there too, it is free to turn where its own sections end, and runs on straight.
    """
    before, middle, after = (np.concatenate(part) for part in _triples(skeleton))
    if not bends:
        counts = (good[before] & good[after]) | ~good[middle]
        before, middle, after = before[counts], middle[counts], after[counts]
    rows = np.tile(np.arange(len(middle)), 3)
    values = np.repeat([1.0, -2.0, 1.0], len(middle))
    shape = (len(middle), len(skeleton.nodes))
    bend = coo_array((values, (rows, np.concatenate([before, middle, after]))), shape=shape).tocsc()
    A = STIFFNESS * (bend.T @ bend) + diags_array(weight)
    return factorize(A.tocsc()).solve(weight[:, None] * target)


def _triples(skeleton: Skeleton) -> tuple[list, list, list]:
    """Nodes with the one before and the one after, along every branch; round a bare loop too."""
    before, middle, after = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for branch in skeleton.branches:
        if branch[0] == branch[-1] and skeleton.degrees[branch[0]] == 2:
            branch = np.concatenate([branch[-2:-1], branch])
        before.append(branch[:-2])
        middle.append(branch[1:-1])
        after.append(branch[2:])
    return before, middle, after
