"""The centerline of each branch where it is visible: the centroids of the branch's own cross-sections.

Near a junction, or where another part of the shape lies close, a plane across a branch cuts more than the branch. A
section is the branch's own if the faces that it crosses are mapped to the branch, and if its size and position change
gradually along the branch.

The centroid of the cross-section as the position of a skeleton node: Cornea, Silver, Min 2007, "Curve-skeleton
properties, applications, and algorithms", https://doi.org/10.1109/TVCG.2007.1002, on centeredness.
"""

from __future__ import annotations

__all__ = ["SectionCenters", "find_section_centers"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton

MIN_OWN_SHARE = 0.95  # of a section's length on faces of its own branch or of a junction; a guess,
# benchmarks/results/constants.md
MAX_GROWTH = 1.2  # upper bound on the ratio of the radii of sections at successive nodes of one branch; a guess,
# benchmarks/results/constants.md
MAX_STRIDE_RATIO = 1.5  # upper bound on the distance between successive centroids, relative to that of their nodes; a
# guess, benchmarks/results/constants.md
TANGENT_REACH = 0.5  # in radii, to both sides, as far as the nodes of a round branch are apart: over less, the
# centroid of a wide section and the tangent across which it is cut would turn each other


@dataclass(frozen=True, eq=False)
class SectionCenters:
    """The visible part of the centerlines, at each of k nodes.

    Parameters
    ----------
    is_known : (k,) array of bool
        Whether the node has a section of its own.
    positions : (k, 3) array of float
        The centroid of that section, or the position of a node that has none.
    """

    is_known: NDArray[np.bool_]
    positions: NDArray[np.float64]


def find_section_centers(
    skeleton: Skeleton, surface: Surface, nodes: NDArray[np.int64] | None = None
) -> SectionCenters:
    """Cut the surface across the branches and keep the sections that belong to one branch only.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches. A section whose centroid is farther from its node than its radius is rejected.
    surface : Surface
    nodes : array of int, optional
        The nodes at which to cut; all by default.
    """
    branch_of = skeleton.branch_of_node
    tangents = _tangents(skeleton)
    at = np.flatnonzero((branch_of >= 0) & (np.linalg.norm(tangents, axis=1) > 0) & (skeleton.degrees == 2))
    if nodes is not None:
        at = np.intersect1d(at, nodes)
    face_labels = branch_of[skeleton.node_of_vertex][surface.mesh.faces[:, 0]]
    sections = cross_sections(
        surface.mesh,
        skeleton.nodes[at],
        tangents[at],
        face_labels=face_labels,
        labels=branch_of[at],
        deadline=surface.deadline,
    )
    is_known = np.zeros(len(skeleton.nodes), dtype=bool)
    is_known[at] = _is_own(sections, skeleton.nodes[at], surface)
    radii = np.zeros(len(skeleton.nodes))
    radii[at] = sections.radii
    centroids = np.array(skeleton.nodes)
    centroids[at] = sections.centroids
    is_known &= _is_continuous(skeleton, is_known, radii, centroids)
    return SectionCenters(is_known, np.where(is_known[:, None], centroids, skeleton.nodes))


def _tangents(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k, 3) unit tangents of the branches, over TANGENT_REACH radii to both sides; zero at junctions."""
    tangents: NDArray[np.float64] = np.zeros_like(skeleton.nodes)
    for branch in skeleton.branches:
        P, inner = skeleton.nodes[branch], slice(None)
        if branch[0] == branch[-1]:
            P, inner = np.concatenate([P[:-1], P, P[1:]]), slice(len(P) - 1, 2 * len(P) - 1)
        steps = np.linalg.norm(np.diff(P, axis=0), axis=1)
        arc = np.append(0.0, np.cumsum(steps))
        nearest = np.maximum(np.append(steps, 0.0), np.append(0.0, steps))[inner]
        reach = np.maximum(nearest, TANGENT_REACH * skeleton.radii[branch])
        before, after = (
            np.stack([np.interp(arc[inner] + side, arc, x) for x in P.T], axis=1) for side in (-reach, reach)
        )
        tangents[branch] = after - before
    tangents[skeleton.degrees >= 3] = 0
    length = np.linalg.norm(tangents, axis=1, keepdims=True)
    unit: NDArray[np.float64] = np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0)
    return unit


def _is_own(sections: Sections, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """Which sections cut one branch only, lie around their node, and have their centroid inside the surface."""
    offset = np.linalg.norm(sections.centroids - nodes, axis=1)
    is_own: NDArray[np.bool_] = (
        sections.is_cut & (sections.label_fractions >= MIN_OWN_SHARE) & (offset <= sections.radii)
    )
    is_own[is_own] = surface.contains(sections.centroids[is_own])
    return is_own


def _is_continuous(
    skeleton: Skeleton, is_own: NDArray[np.bool_], radii: NDArray[np.float64], centroids: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which sections are connected to the middle of their branch without a jump in size or position.

    Where a branch enters another one at a junction, its section becomes that of the other, or of both, within one step.
    So jumps count in the half of a branch next to the junction. In the other half they count only if it ends in a tip,
    and only those in position, since sections grow from a tip in any case.
    """
    is_continuous = np.array(is_own)
    for branch in skeleton.branches:
        for path in (branch, branch[::-1]):
            own = path[is_own[path]]
            if skeleton.degrees[path[-1]] < 3 or len(own) < 2:
                continue
            steps, strides = (np.linalg.norm(np.diff(P[own], axis=0), axis=1) for P in (skeleton.nodes, centroids))
            jumps, grows = strides > MAX_STRIDE_RATIO * steps, radii[own[1:]] > MAX_GROWTH * radii[own[:-1]]
            is_second_half = np.arange(len(steps)) >= (len(own) - 1) / 2
            is_jump = (jumps & (is_second_half | (skeleton.degrees[path[0]] == 1))) | (grows & is_second_half)
            if is_jump.any():
                is_continuous[own[np.argmax(is_jump) + 1 :]] = False
    return is_continuous
