"""Radii of skeleton nodes: the distance to the surface, and mean distances of the vertices mapped to a node."""

from __future__ import annotations

__all__ = ["axis_directions", "inscribed_radii", "mean_axis_distances", "mean_radii", "own_radii"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from lbskel.geometry.components import components
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton


def inscribed_radii(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Set inscribed radii: the distance of each node to the surface.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
        In the same coordinates.
    """
    return replace(skeleton, radii=surface.distance(skeleton.nodes), radius_kind="inscribed")


def own_radii(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """Set radii to the distance of each node from the mesh component that the node's graph component represents.

    That is the mesh component to which most vertices of the graph component belong. So the surfaces of other
    components, which may intersect it or lie inside it, do not count. For a graph component without vertices, all
    surfaces do.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    mesh : Mesh
        The mesh that ``node_of_vertex`` belongs to.
    """
    graph_of_node, body_of_vertex, used = skeleton.component_of_node, mesh.component_of_vertex, mesh.used_vertices
    votes = graph_of_node[skeleton.node_of_vertex[used]], body_of_vertex[used]
    count = coo_array((np.ones(len(used), dtype=np.int64), votes), shape=(skeleton.n_components, mesh.n_components))
    most_votes = np.asarray(count.tocsr().argmax(axis=1)).ravel()  # a column in older versions of scipy
    body_of_graph = np.where(count.sum(axis=1) > 0, most_votes, -1)
    body_of_node, radii = body_of_graph[graph_of_node], np.empty(len(skeleton.nodes))
    for body, part in [(-1, mesh), *enumerate(part.mesh for part in components(mesh))]:
        is_own = body_of_node == body
        if is_own.any():
            radii[is_own] = Surface(part).distance(skeleton.nodes[is_own])
    return replace(skeleton, radii=radii, radius_kind="inscribed")


def mean_radii(skeleton: Skeleton, mesh: Mesh) -> Skeleton:
    """Set mean radii: the mean distance of each node to the vertices mapped to it.

    A node without vertices takes the mean radius of its neighbors along the skeleton. Refinement spaces nodes by these;
    the ``mean_radii`` of a finished skeleton are :func:`mean_axis_distances`.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    mesh : Mesh
        The mesh that ``node_of_vertex`` belongs to.
    """
    distances = vector_lengths(mesh.vertices - skeleton.nodes.take(skeleton.node_of_vertex, axis=0))
    return replace(skeleton, radii=_means(skeleton, distances), radius_kind="mean")


def mean_axis_distances(
    skeleton: Skeleton, points: NDArray[np.float64], is_counted: NDArray[np.bool_] | None = None
) -> NDArray[np.float64]:
    """Compute the mean distance of the points mapped to each node from the axis of its branch there.

    On a round tube that is its radius, whatever the spacing of the nodes, and noise hardly changes it: noise makes
    inscribed balls smaller, and cross-sections neither smaller nor larger. The axis is the line along the chord between
    the neighbors of the node; it ends at a tip, and is the node alone at a junction. A node without points takes the
    mean of its neighbors along the skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``.
    points : (n, 3) array of float
        The vertices of the mesh, or the points of the cloud, that ``node_of_vertex`` belongs to.
    is_counted : (n,) array of bool, optional
        Whether each counts, as one that is no outlier; by default all do.
    """
    if is_counted is not None:
        points = points[is_counted]
        skeleton = replace(skeleton, node_of_vertex=skeleton.node_of_vertex[is_counted])
    nodes, node = skeleton.nodes, skeleton.node_of_vertex
    directions = axis_directions(skeleton)
    offsets = points - nodes.take(node, axis=0)
    along = np.einsum("ni,ni->n", offsets, directions.take(node, axis=0))
    along = np.where(skeleton.degrees[node] == 1, np.minimum(along, 0.0), along)
    squared = np.einsum("ni,ni->n", offsets, offsets) - along**2
    return _means(skeleton, np.sqrt(np.maximum(squared, 0.0)))


def axis_directions(skeleton: Skeleton) -> NDArray[np.float64]:
    """(k, 3) unit vectors along the chord between the neighbors of each node, at a tip outwards; zero at junctions.

    Parameters
    ----------
    skeleton : Skeleton
    """
    nodes = skeleton.nodes
    directions = np.zeros_like(nodes)
    previous, middle, following = skeleton.triples
    directions[middle] = nodes[following] - nodes[previous]
    ends = np.concatenate([skeleton.edges, skeleton.edges[:, ::-1]])
    tips, inner = ends[skeleton.degrees[ends[:, 0]] == 1].T
    directions[tips] = nodes[tips] - nodes[inner]
    return normalized(directions)


def _means(skeleton: Skeleton, distances: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) mean distance over the vertices of each node, or over its neighbors if it has none; 0 without any."""
    count = np.bincount(skeleton.node_of_vertex, minlength=len(skeleton.nodes))
    total = np.bincount(skeleton.node_of_vertex, weights=distances, minlength=len(skeleton.nodes))
    is_known = count > 0
    radii = np.where(is_known, total / np.maximum(count, 1), 0.0)
    i, j = np.concatenate([skeleton.edges, skeleton.edges[:, ::-1]]).T
    while len(i := i[is_open := ~is_known[i]]):
        j = j[is_open]
        is_next = is_known[j]
        if not is_next.any():
            break
        count, total = (np.bincount(i[is_next], each, len(radii)) for each in (None, radii[j[is_next]]))
        nodes = np.flatnonzero(count)
        radii[nodes] = total[nodes] / count[nodes]
        is_known[nodes] = True
    return radii
