"""Cycles kept around their tunnels: edges that leave the solid follow the surface through the regions of their nodes.

Contraction can leave the solid where it is not convex, as in a shoulder or a hip, and a straight edge between two nodes
is then no longer known to go around the tunnel that its regions go around. The regions of adjacent nodes are adjacent,
and a path on the surface through the two goes the right way around. Moved inwards, it takes the place of the edge, as a
node outside moves below its own region.
"""

from __future__ import annotations

__all__ = ["reroute_through_regions"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.offset_paths import moved_inwards
from lbskel.refinement.relaxation import relax_inside
from lbskel.skeleton.editing import replace_paths
from lbskel.skeleton.skeleton import Skeleton


def reroute_through_regions(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Lead the edges that leave the solid below the regions of their nodes, if the skeleton has cycles.

    Parameters
    ----------
    skeleton : Skeleton
        With mean radii, and with regions that are connected and adjacent along its edges.
    surface : Surface
        Its mesh is the one that ``node_of_vertex`` belongs to.
    """
    if skeleton.cycle_rank == 0 or not surface.mesh.is_closed:
        return skeleton
    nearest = _nearest_of_region(skeleton, surface)
    entries = moved_inwards(nearest, skeleton.radii, surface)
    nodes = np.array(skeleton.nodes)
    n_nodes = len(nodes)
    to_entry = np.stack([np.arange(n_nodes), n_nodes + np.arange(n_nodes)], axis=1)
    is_astray = (nearest >= 0) & segments_outside(np.concatenate([nodes, entries]), to_entry, surface)
    nodes[is_astray] = entries[is_astray]
    skeleton = replace(skeleton, nodes=nodes)
    leaving = skeleton.edges[segments_outside(nodes, skeleton.edges, surface)]
    leaving = leaving[(nearest[leaving] >= 0).all(axis=1)]
    if len(leaving) == 0:
        return skeleton
    paths = [
        np.concatenate([nodes[[u]], moved_inwards(path, np.full(len(path), depth), surface), nodes[[v]]])
        for (u, v), path, depth in zip(
            leaving.tolist(),
            _region_paths(skeleton, leaving, nearest, surface),
            skeleton.radii[leaving].max(axis=1),
            strict=True,
        )
    ]
    inner = [path[1:-1] for path in relax_inside(paths, surface)]
    positions = np.concatenate(inner)
    begins, new_begins = 2 * np.arange(len(leaving) + 1), np.cumsum([0, *map(len, inner)])
    return replace_paths(skeleton, leaving.ravel(), begins, positions, new_begins, surface.distance(positions))


def _nearest_of_region(skeleton: Skeleton, surface: Surface) -> NDArray[np.int64]:
    """(k,) the vertex of each node's region that is nearest to the node; -1 for a node without vertices."""
    node_of_vertex = skeleton.node_of_vertex
    mapped = np.flatnonzero(node_of_vertex >= 0)
    distances = np.linalg.norm(surface.mesh.vertices[mapped] - skeleton.nodes[node_of_vertex[mapped]], axis=1)
    order = mapped[np.lexsort((distances, node_of_vertex[mapped]))]
    nearest = np.full(len(skeleton.nodes), -1)
    nearest[node_of_vertex[order[::-1]]] = order[::-1]
    return nearest


def _region_paths(
    skeleton: Skeleton, edges: NDArray[np.int64], nearest: NDArray[np.int64], surface: Surface
) -> list[NDArray[np.int64]]:
    """For each edge, the vertices of the shortest path through the regions of its nodes."""
    mesh, n_vertices = surface.mesh, len(surface.mesh.vertices)
    both = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
    graph = weighted_graph(both, np.tile(mesh.edge_lengths, 2), n_vertices)
    search = ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)
    paths = []
    for u, v in edges.tolist():
        kinds = np.isin(skeleton.node_of_vertex, [u, v]).astype(np.int8)
        kinds[nearest[v]] = 2
        _, path = search.nearest_goal(nearest[[u]], kinds)
        paths.append(path[::-1] if len(path) else nearest[[u, v]])
    return paths
