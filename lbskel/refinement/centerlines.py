"""The axis of each branch where it can be seen: the centroids of the sections that are the branch's own.

Near a junction, or where another part of the shape lies close, a plane across a branch cuts more than the branch.
Which sections are its own is told by what the faces they cross stand for and by how their size changes on the way.

The place of a skeleton node as the centroid of its cross-section: Cornea, Silver, Min 2007, "Curve-skeleton properties,
applications, and algorithms", https://doi.org/10.1109/TVCG.2007.1002, on centeredness.
"""

from __future__ import annotations

__all__ = ["SectionCenters", "branch_of_node", "find_section_centers"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton

OWN = 0.95  # a section with less of its curve on its own branch, or on a junction, is another branch's too
LEAP = 1.2  # a branch of its own does not grow by this factor from one node to the next
STRIDE = 1.5  # nor does its axis go further, beside its nodes, from one to the next


@dataclass(frozen=True, eq=False)
class SectionCenters:
    """What is known of the axis at each of k nodes.

    Parameters
    ----------
    is_known : (k,) array of bool
        Whether the node has a section of its own.
    places : (k, 3) array of float
        The centroid of that section; where there is none, the node's own place.
    """

    is_known: NDArray[np.bool_]
    places: NDArray[np.float64]


def branch_of_node(skeleton: Skeleton) -> NDArray[np.int64]:
    """(k,) the branch of each node; -1 at junctions, which belong to several."""
    branch_of = np.full(len(skeleton.nodes), -1)
    for index, branch in enumerate(skeleton.branches):
        branch_of[branch] = index
    branch_of[skeleton.degrees >= 3] = -1
    return branch_of


def find_section_centers(
    skeleton: Skeleton, surface: Surface, nodes: NDArray[np.int64] | None = None
) -> SectionCenters:
    """Cut the surface across the branches and keep the sections that are their own.

    Parameters
    ----------
    skeleton : Skeleton
        With branches evenly sampled. A section's centroid further from its node than its radius is not the node's.
    surface : Surface
    nodes : array of int, optional
        The nodes to look at; all by default.
    """
    branch_of = branch_of_node(skeleton)
    tangents = _tangents(skeleton)
    at = np.flatnonzero((branch_of >= 0) & (np.linalg.norm(tangents, axis=1) > 0) & (skeleton.degrees == 2))
    if nodes is not None:
        at = np.intersect1d(at, nodes)
    face_labels = branch_of[skeleton.node_of_vertex][surface.mesh.faces[:, 0]]
    sections = cross_sections(
        surface.mesh, skeleton.nodes[at], tangents[at], face_labels=face_labels, labels=branch_of[at]
    )
    is_known = np.zeros(len(skeleton.nodes), dtype=bool)
    is_known[at] = _is_own(sections, skeleton.nodes[at], surface)
    radii = np.zeros(len(skeleton.nodes))
    radii[at] = sections.radii
    centroids = np.array(skeleton.nodes)
    centroids[at] = sections.centroids
    is_known &= _runs_on(skeleton, is_known, radii, centroids)
    return SectionCenters(is_known, np.where(is_known[:, None], centroids, skeleton.nodes))


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


def _is_own(sections: Sections, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """Which sections are cut across one branch alone, about its node, and hold their centroid."""
    shift = np.linalg.norm(sections.centroids - nodes, axis=1)
    is_own = sections.is_cut & (sections.own >= OWN) & (shift <= sections.radii)
    is_own[is_own] = surface.contains(sections.centroids[is_own])
    return is_own


def _runs_on(
    skeleton: Skeleton, good: NDArray[np.bool_], radii: NDArray[np.float64], centroids: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which nodes are reached from the middle of their branch without a leap of the section, in size or from its place.

    Where a branch runs into another at a junction, its section becomes the other's, or that of both, within a step.
    From a tip, whose sections grow anyway, only leaps from place to place count.
    """
    reached = np.array(good)
    for branch in skeleton.branches:
        for way in (branch, branch[::-1]):
            own = way[good[way]]
            if skeleton.degrees[way[-1]] < 3 or len(own) < 2:
                continue
            apart, strides = (np.linalg.norm(np.diff(P[own], axis=0), axis=1) for P in (skeleton.nodes, centroids))
            leaps, grows = strides > STRIDE * apart, radii[own[1:]] > LEAP * radii[own[:-1]]
            middle = np.arange(len(apart)) >= (len(own) - 1) / 2
            leaps = (leaps & (middle | (skeleton.degrees[way[0]] == 1))) | (grows & middle)
            if leaps.any():
                reached[own[np.argmax(leaps) + 1 :]] = False
    return reached
