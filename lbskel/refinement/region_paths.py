"""Cycles kept around their tunnels: an edge that passes a tunnel on another side than its regions is led through these.

The regions of adjacent nodes are adjacent, and a path on the surface through the two goes around the tunnels that the
regions go around. The straight edge may not: contraction can leave the solid where it is not convex, as in a shoulder
or a hip, and in a thick part an edge inside can pass on the other side of a tunnel. The path, moved inwards, replaces
such an edge, and a node outside the solid is moved below its own region.
"""

from __future__ import annotations

__all__ = ["reroute_through_regions"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.cycle_classes import are_around_tunnels
from lbskel.geometry.graphs import edge_length_graph, shortest_paths
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.offset_paths import moved_inwards
from lbskel.refinement.relaxation import relax_inside
from lbskel.refinement.tunnel_sides import on_their_side
from lbskel.skeleton.editing import replace_paths
from lbskel.skeleton.skeleton import Skeleton


def reroute_through_regions(skeleton: Skeleton, surface: Surface, regions: NDArray[np.int64]) -> Skeleton:
    """Lead edges that leave the solid, or pass a tunnel on another side than their regions, through these regions.

    A skeleton without cycles, or in an open surface, is returned unchanged.

    Parameters
    ----------
    skeleton : Skeleton
        With mean radii, and with regions that are connected and adjacent along its edges.
    surface : Surface
        Its mesh is the one that ``node_of_vertex`` belongs to.
    regions : (n,) array of int
        The node whose region each vertex is in; -1 for vertices in no region.
    """
    if skeleton.cycle_rank == 0 or not surface.mesh.is_closed:
        return skeleton
    nearest = _nearest_of_region(skeleton, regions, surface)
    entries = moved_inwards(nearest, skeleton.radii, surface)
    nodes = np.array(skeleton.nodes)
    n_nodes = len(nodes)
    to_entry = np.stack([np.arange(n_nodes), n_nodes + np.arange(n_nodes)], axis=1)
    is_astray = (nearest >= 0) & segments_outside(np.concatenate([nodes, entries]), to_entry, surface)
    nodes[is_astray] = entries[is_astray]
    skeleton = replace(skeleton, nodes=nodes)
    has_path = (nearest[skeleton.edges] >= 0).all(axis=1)
    if not has_path.any():
        return skeleton
    edges = skeleton.edges[has_path]
    is_led = segments_outside(nodes, edges, surface)
    paths = _region_paths(skeleton, edges, regions, nearest, surface)
    is_led |= are_around_tunnels(paths, surface)
    if not is_led.any():
        return skeleton
    led = [paths[row] for row in np.flatnonzero(is_led)]
    # a path that touched the surface may pass another side of a tunnel when it is relaxed
    inner = [path[1:-1] for path in on_their_side(led, relax_inside(led, surface), surface)]
    positions = np.concatenate(inner)
    begins, new_begins = 2 * np.arange(len(inner) + 1), np.cumsum([0, *map(len, inner)])
    return replace_paths(skeleton, edges[is_led].ravel(), begins, positions, new_begins, surface.distance(positions))


def _nearest_of_region(skeleton: Skeleton, node_of_vertex: NDArray[np.int64], surface: Surface) -> NDArray[np.int64]:
    """(k,) the vertex of each node's region that is nearest to the node; -1 for a node without vertices."""
    mapped = np.flatnonzero(node_of_vertex >= 0)
    distances = vector_lengths(surface.mesh.vertices[mapped] - skeleton.nodes[node_of_vertex[mapped]])
    order = mapped[np.lexsort((distances, node_of_vertex[mapped]))]
    nearest = np.full(len(skeleton.nodes), -1)
    nearest[node_of_vertex[order[::-1]]] = order[::-1]
    return nearest


def _region_paths(
    skeleton: Skeleton,
    edges: NDArray[np.int64],
    regions: NDArray[np.int64],
    nearest: NDArray[np.int64],
    surface: Surface,
) -> list[NDArray[np.float64]]:
    """For each edge, the points of the shortest path through the regions of its nodes, moved inwards.

    Where the edges of the mesh are short relative to the depth, or the path turns, the moved path can pass a tunnel on
    another side than the path on the surface; the path then stays at the surface.
    """
    mesh = surface.mesh
    search = shortest_paths(edge_length_graph(mesh))
    order = stable_order(regions + 1)  # -1 is for vertices in no region
    begins = np.searchsorted(regions[order], np.arange(len(skeleton.nodes) + 1))
    kinds = np.zeros(len(regions), dtype=np.int8)
    found = []
    for u, v in edges.tolist():
        region = np.concatenate([order[begins[node] : begins[node + 1]] for node in (u, v)])
        kinds[region] = 1
        kinds[nearest[v]] = 2
        _, path = search.nearest_goal(nearest[[u]], kinds)
        kinds[region] = 0
        found.append(path[::-1] if len(path) else nearest[[u, v]])
    sizes = [len(path) for path in found]
    vertices, depths = np.concatenate(found), np.repeat(skeleton.radii[edges].max(axis=1), sizes)
    deep, shallow = (
        _between(skeleton.nodes[edges], np.split(moved_inwards(vertices, depth, surface), np.cumsum(sizes)[:-1]))
        for depth in (depths, 0 * depths)
    )
    return on_their_side(shallow, deep, surface)


def _between(ends: NDArray[np.float64], inner: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
    """Add the first and the second end to the inner points of each path."""
    return [np.concatenate([pair[:1], points, pair[1:]]) for pair, points in zip(ends, inner, strict=True)]
