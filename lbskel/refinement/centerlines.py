"""The centerline of each branch where it is visible: the centroids of the branch's own cross-sections.

Near a junction, or where another part of the shape lies close, a plane across a branch cuts more than the branch. A
section is the branch's own if the faces that it crosses are mapped to the branch, and if its size changes gradually
along the branch.

Cornea, Silver, Min 2007, "Curve-skeleton properties, applications, and algorithms",
https://doi.org/10.1109/TVCG.2007.1002, discuss centeredness, the reason to put nodes at the centroids of sections.
"""

from __future__ import annotations

__all__ = ["SectionCenters", "find_section_centers"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.traversal import sums_along_paths
from lbskel.geometry.cross_sections import Sections, cross_sections
from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton

MIN_OWN_SHARE = 0.95  # of a section's length on faces of its own branch or of a junction; a guess,
# benchmarks/results/constants.md
# Upper bound on the radius of a section in the half of a branch next to a junction, relative to the largest before it:
# successive sections of rough branches differ by more. Rows "growth of" in benchmarks/results/refinement.md
MAX_GROWTH = 1.2
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


def find_section_centers(skeleton: Skeleton, surface: Surface) -> SectionCenters:
    """Cut the surface across the branches and keep the sections that belong to one branch only.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches. A section whose centroid is farther from its node than its radius is rejected.
    surface : Surface
    """
    branch_of = skeleton.branch_of_node
    tangents = _tangents(skeleton)
    at = np.flatnonzero((vector_lengths(tangents) > 0) & (skeleton.degrees == 2))
    face_labels = branch_of[skeleton.node_of_vertex][surface.mesh.faces[:, 0]]
    sections = cross_sections(
        surface.mesh,
        skeleton.nodes[at],
        tangents[at],
        face_labels=face_labels,
        labels=branch_of[at],
        max_reaches=_reaches(skeleton, at, surface),  # farther away, nothing is their own
        deadline=surface.deadline,
    )
    is_own, radii = np.zeros(len(skeleton.nodes), dtype=bool), np.zeros(len(skeleton.nodes))
    is_own[at], radii[at] = _is_own(sections, skeleton.nodes[at], surface), sections.radii
    is_known = _is_continuous(skeleton, is_own, radii)
    positions = np.array(skeleton.nodes)
    positions[at] = np.where(is_known[at, None], sections.centroids, skeleton.nodes[at])
    return SectionCenters(is_known, positions)


def _reaches(skeleton: Skeleton, nodes: NDArray[np.int64], surface: Surface) -> NDArray[np.float64]:
    """(k,) upper bound on the distance from each node to the faces of its branch and its ends.

    These are in a ball around the mean of the branch's nodes, so that the bound does not depend on the pose.
    """
    V, F = surface.mesh.vertices, surface.mesh.faces
    extents = np.zeros(len(skeleton.nodes))
    number = skeleton.node_of_vertex[F[:, 0]]
    for corner in F.T:
        np.maximum.at(extents, number, vector_lengths(V[corner] - skeleton.nodes[number]))
    along, begins = skeleton.flat_branches
    sizes = np.diff(begins)
    centers = np.add.reduceat(skeleton.nodes[along], begins[:-1]) / sizes[:, None]
    to_center = vector_lengths(skeleton.nodes[along] - np.repeat(centers, sizes, axis=0))
    balls = np.maximum.reduceat(to_center + extents[along], begins[:-1])
    branch = skeleton.branch_of_node[nodes]
    distances: NDArray[np.float64] = vector_lengths(skeleton.nodes[nodes] - centers[branch]) + balls[branch]
    return distances


def _tangents(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k, 3) unit tangents of the branches, over TANGENT_REACH radii to both sides; of any branch at junctions."""
    nodes, begins = skeleton.flat_branches
    if len(nodes) == 0:
        return np.zeros_like(skeleton.nodes)
    tangents: NDArray[np.float64] = np.zeros_like(skeleton.nodes)
    tangents[nodes] = _chords(skeleton.nodes[nodes], TANGENT_REACH * skeleton.radii[nodes], begins)
    for loop in np.flatnonzero(nodes[begins[:-1]] == nodes[begins[1:] - 1]):
        around = np.tile(skeleton.branches[loop][:-1], 3)  # three times round
        reach = TANGENT_REACH * skeleton.radii[around]
        chords = _chords(skeleton.nodes[around], reach, np.array([0, len(around)]))
        tangents[skeleton.branches[loop][:-1]] = np.split(chords, 3)[1]
    return normalized(tangents)


def _chords(P: NDArray[np.float64], reach: NDArray[np.float64], begins: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, 3) vectors from the point one reach before to the point one reach after each point of some polylines.

    The polylines are concatenated. A reach is at least the distance to the farther of the two neighbors, and ends at
    the end of the polyline.
    """
    steps = vector_lengths(np.diff(P, axis=0, prepend=P[:1]))
    steps[begins[:-1]] = 0.0
    arc, number = sums_along_paths(steps, begins), np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    before, after = steps, np.append(steps[1:], 0.0)
    after[begins[1:] - 1] = 0.0
    reach = np.maximum(np.maximum(before, after), reach)
    first, last = begins[:-1][number], begins[1:][number] - 1
    shift = 2 * arc.max() * number  # so that all polylines ascend
    ends = []
    for side in (-reach, reach):
        at = np.clip(arc + side, 0.0, arc[last])
        left = np.clip(np.searchsorted(arc + shift, at + shift, "right") - 1, first, np.maximum(last - 1, first))
        right = np.minimum(left + 1, last)
        width = arc[right] - arc[left]
        slope = np.divide(P[right] - P[left], width[:, None], out=np.zeros_like(P), where=width[:, None] > 0)
        ends.append(slope * (at - arc[left])[:, None] + P[left])
    return np.asarray(ends[1] - ends[0])


def _is_own(sections: Sections, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """Which sections cut one branch only, lie around their node, and have their centroid inside the surface."""
    offset = vector_lengths(sections.centroids - nodes)
    is_own: NDArray[np.bool_] = (
        sections.is_cut & (sections.label_fractions >= MIN_OWN_SHARE) & (offset <= sections.radii)
    )
    is_own[is_own] = surface.contains(sections.centroids[is_own])
    return is_own


def _is_continuous(skeleton: Skeleton, is_own: NDArray[np.bool_], radii: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which sections are connected to the middle of their branch without a jump in size.

    Where a branch enters another one at a junction, its section becomes that of the other, or of both, within one step.
    So in the half of a branch next to a junction, no section may be much larger than the largest before it, counted
    from the middle third of the branch: the single section in its middle may be the smallest, as in a crotch.
    """
    is_continuous, (along, begins) = np.array(is_own), skeleton.flat_branches
    number, r = np.repeat(np.arange(len(begins) - 1), np.diff(begins))[is_own[along]], radii[along[is_own[along]]]
    is_step = np.maximum(r[1:], r[:-1]) > MAX_GROWTH * np.minimum(r[1:], r[:-1])  # no jump is smaller
    for stepped in np.unique(number[1:][is_step & (number[1:] == number[:-1])]).tolist():
        branch = skeleton.branches[stepped]
        own = branch[is_own[branch]]
        for path, end in ((own, branch[-1]), (own[::-1], branch[0])):
            third, half = len(path) // 3, path[len(path) // 2 :]
            if skeleton.degrees[end] >= 3 and len(half):
                largest = np.maximum.accumulate(radii[path[third:]])[-len(half) : -1]
                is_jump = radii[half[1:]] > MAX_GROWTH * largest
                is_continuous[half[1:][np.logical_or.accumulate(is_jump)]] = False
    return is_continuous
