"""Refinement: from the graph that surgery leaves to nodes on the axis of their sections.

A node inside a branch belongs at the centroid of the surface's section across the branch, which depends neither on how
the surface is sampled nor on how far it was contracted (:mod:`lbskel.refinement.centerlines`). Near a junction the section is not the
branch's own, so the branch is carried on smoothly to the junction (:mod:`lbskel.refinement.junctions`).
"""

from __future__ import annotations

__all__ = ["fit_to_centerlines", "inscribed_radii", "mean_radii", "own_radii", "reassign_to_nearest_node", "recenter"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array

from lbskel._kernels.connectivity import nearer_nodes
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import SectionCenters, branch_of_node, find_section_centers
from lbskel.refinement.junctions import place_junctions
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import factorize

STIFFNESS = 1.0  # of a branch against bending, beside a weight of 1 on each section's centroid
ANCHOR = 1e-3  # weight on a node's contracted place, which counts where it has no section of its own


def inscribed_radii(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """The skeleton with the distance to the surface as the radius of each node."""
    return replace(skeleton, radii=surface.distance(skeleton.nodes), radius_kind="inscribed")


def own_radii(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with, for each node, the distance to the component of the mesh that most of its graph stands for.

    The walls of other bodies, which may cut through that one or lie inside of it, do not count. A graph that stands for
    no vertex keeps its radii.
    """
    graph, body, used = skeleton.component_of_node, mesh.component_of_vertex, mesh.used_vertices
    votes = graph[skeleton.node_of_vertex[used]], body[used]
    count = coo_array((np.ones(len(used), dtype=np.int64), votes), shape=(skeleton.n_components, mesh.n_components))
    body_of_node = np.where(count.sum(axis=1) > 0, count.tocsr().argmax(axis=1), -1)[graph]
    radii, body_of_face = np.array(skeleton.radii), body[mesh.faces[:, 0]]
    for number in np.unique(body_of_node[body_of_node >= 0]):
        mine = body_of_node == number
        own, faces = np.unique(mesh.faces[body_of_face == number], return_inverse=True)
        radii[mine] = Surface(Mesh(mesh.vertices[own], faces.reshape(-1, 3))).distance(skeleton.nodes[mine])
    return replace(skeleton, radii=radii)


def mean_radii(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with, for each node, the mean distance of the vertices that it stands for.

    A node that stands for none takes the mean of its neighbors along the skeleton.
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


def reassign_to_nearest_node(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """The skeleton with each vertex handed on along the edges to a nearer node, as long as there is one next to it."""
    settled = nearer_nodes(mesh.vertices, skeleton.node_of_vertex, skeleton.nodes, *skeleton.adjacency)
    return replace(skeleton, node_of_vertex=settled)


def recenter(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move every node to the axis of the shape there, and junctions to where the axes of their branches meet.

    Parameters
    ----------
    skeleton : Skeleton
        With branches evenly sampled, and near their axes: sections are cut across them as they run.
    surface : Surface
        In the same coordinates.
    """
    return fit_to_centerlines(
        skeleton, place_junctions(skeleton, find_section_centers(skeleton, surface), surface), surface
    )


def fit_to_centerlines(skeleton: Skeleton, axes: SectionCenters, surface: Surface) -> Skeleton:
    """Move the nodes of every branch to its axis, and its junctions to their places there; tips move with the branch.

    Where a branch has no sections of its own, it is carried on from those that it has to its junction. Where that would
    leave the shape, it keeps beside the way that it was contracted to.

    Parameters
    ----------
    skeleton : Skeleton
    axes : SectionCenters
        Of the same nodes.
    surface : Surface
    """
    is_junction = skeleton.degrees >= 3
    weight = np.where(axes.is_known, 1.0, ANCHOR)
    weight[is_junction] = 1 / ANCHOR
    nodes = _fair(skeleton, axes.places, weight)
    gap = ~(axes.is_known | is_junction)
    outer = gap & ~surface.contains(nodes)
    if outer.any():
        branch_of = branch_of_node(skeleton)
        beside = gap & np.isin(branch_of, branch_of[outer])
        nodes[beside] = (skeleton.nodes + _fair(skeleton, axes.places - skeleton.nodes, weight))[beside]
    return replace(skeleton, nodes=nodes)


def _fair(skeleton: Skeleton, target: NDArray[np.float64], weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nodes near their targets, by weight, on branches that bend little: a smoothing spline."""
    before, middle, after = (np.concatenate(part) for part in _triples(skeleton))
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
