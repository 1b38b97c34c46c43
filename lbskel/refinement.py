"""Refinement: from the graph that surgery leaves to nodes on the axis of their sections.

A node inside a branch belongs at the centroid of the surface's section across the branch, which depends neither on how
the surface is sampled nor on how far it was contracted. Near a junction the section is not the branch's own, so the
branch is carried on smoothly to the junction, and the junction goes where the axes of its branches meet.

The place of a skeleton node as the centroid of its cross-section: Cornea, Silver, Min 2007, "Curve-skeleton properties,
applications, and algorithms", https://doi.org/10.1109/TVCG.2007.1002, on centredness.
"""

from __future__ import annotations

__all__ = ["inscribed_radii", "mean_radii", "recenter"]

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
ANCHOR = 1e-3  # weight on where a node is already, which counts where it has no section of its own


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


def recenter(skeleton: Skeleton, surface: Surface, *, iterations: int = 4) -> Skeleton:
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
        good[at] = _is_own(sections) & (skeleton.degrees[at] == 2)
        target = np.array(skeleton.nodes)
        target[at] = sections.centroids
        target[~good] = skeleton.nodes[~good]
        junctions = _place_junctions(start, target, good, surface)
        skeleton = replace(skeleton, nodes=_fair(skeleton, target, good, junctions))
    return skeleton


def _is_own(sections: Sections) -> NDArray[np.bool_]:
    """Which sections are cut across one branch alone."""
    return sections.is_cut & (sections.own >= OWN)


def _place_junctions(
    skeleton: Skeleton, target: NDArray[np.float64], good: NDArray[np.bool_], surface: Surface
) -> dict[int, NDArray[np.float64]]:
    """Where the axes of each junction's branches come nearest to one point."""
    lines: dict[int, list[tuple[NDArray[np.float64], NDArray[np.float64]]]] = {}
    for branch in skeleton.branches:
        for way in (branch, branch[::-1]):
            if skeleton.degrees[way[0]] < 3:
                continue
            own = way[1:-1][good[way[1:-1]]]
            if len(own) < 2:
                continue
            near = own[: min(len(own), 4)]
            direction = target[near[0]] - target[near[-1]]
            lines.setdefault(int(way[0]), []).append((target[near].mean(axis=0), direction / np.linalg.norm(direction)))
    placed = {}
    for junction, meeting in lines.items():
        start = skeleton.nodes[junction]
        A, b = np.zeros((3, 3)), np.zeros(3)
        for point, direction in meeting:
            across = (np.eye(3) - np.outer(direction, direction)) / max(float(np.sum((point - start) ** 2)), 1e-300)
            A += across
            b += across @ (point - start)
        A += 0.02 * np.trace(A) * np.eye(3)
        if len(meeting) >= 2:
            placed[junction] = start + np.linalg.solve(A, b)
    if placed:
        order = list(placed)
        there = np.array([placed[junction] for junction in order])
        inside = surface.contains(there)
        return {j: p for j, p, keep in zip(order, there, inside, strict=True) if keep}
    return placed


def _fair(
    skeleton: Skeleton,
    target: NDArray[np.float64],
    good: NDArray[np.bool_],
    junctions: dict[int, NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Nodes near their targets on branches that bend little: a smoothing spline on each, ending at its junctions."""
    k = len(skeleton.nodes)
    weight = np.where(good, 1.0, ANCHOR)
    target = np.array(target)
    for junction, place in junctions.items():
        target[junction] = place
    weight[skeleton.degrees >= 3] = 1e3
    before, middle, after = (np.concatenate(part) for part in _triples(skeleton))
    rows = np.arange(len(middle))
    values = np.concatenate([np.ones(len(rows)), -2 * np.ones(len(rows)), np.ones(len(rows))])
    bend = coo_array((values, (np.tile(rows, 3), np.concatenate([before, middle, after]))), shape=(len(rows), k)).tocsc()
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
