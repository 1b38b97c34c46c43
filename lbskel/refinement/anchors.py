"""Nodes that the caller asks for: anchors, which the skeleton must have, and the root, which comes first."""

from __future__ import annotations

__all__ = ["attach_anchors", "nearest_node", "reroot", "resolve_anchor"]

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import interior_paths
from lbskel.skeleton.editing import append_paths, reroot, split_edge
from lbskel.skeleton.skeleton import Skeleton

PASSES = 0.5  # local radii within which the skeleton passes an anchor: it is led through it and gets no new branch
OUTSIDE = 1e-6  # of the extent, by which an anchor may lie outside of a closed surface


def resolve_anchor(anchor: Any, mesh: Mesh) -> tuple[int, NDArray[np.float64]]:
    """The vertex of a mesh that is meant, or that is nearest, and the place itself.

    Parameters
    ----------
    anchor : int or (3,) array_like
        A vertex, or a point in the coordinates of the mesh.
    mesh : Mesh

    Raises
    ------
    MeshError
        If there is no such vertex, or it is neither a vertex nor a point.
    """
    V, given = mesh.vertices, np.asarray(anchor)
    if given.ndim == 0 and np.issubdtype(given.dtype, np.integer):
        if not 0 <= given < len(V):
            raise MeshError(f"there is no vertex {given} to anchor: the mesh has vertices 0..{len(V) - 1}")
        return int(given), V[int(given)]
    if given.shape != (3,) or not np.issubdtype(given.dtype, np.number) or not np.isfinite(given).all():
        raise MeshError(f"an anchor or root must be the index of a vertex or a point of three numbers, not {anchor!r}")
    point = given.astype(np.float64)
    used = mesh.used_vertices
    return int(used[np.argmin(np.linalg.norm(V[used] - point, axis=1))]), point


def attach_anchors(
    skeleton: Skeleton, surface: Surface, vertices: NDArray[np.int64], points: NDArray[np.float64]
) -> Skeleton:
    """The skeleton with a node at every point.

    Where the skeleton passes near, it is led through the point; elsewhere a branch is added to it from the node that
    stands for the vertex, inside the surface.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii.
    surface : Surface
    vertices : (a,) array of int
        The vertex at or nearest to each point.
    points : (a, 3) array of float

    Raises
    ------
    MeshError
        If a point lies outside of a closed surface.
    """
    if surface.mesh.is_closed and len(points):
        is_outer = ~surface.contains(points) & (surface.distance(points) > OUTSIDE * surface.mesh.diameter_bound)
        for number in np.flatnonzero(is_outer)[:1]:
            raise MeshError(f"anchor {number} lies outside of the surface; give a vertex or a point inside")
    for vertex, point in zip(vertices.tolist(), points, strict=True):
        skeleton = _attached(skeleton, surface, int(skeleton.node_of_vertex[vertex]), point)
    return skeleton


def _attached(skeleton: Skeleton, surface: Surface, stands_for: int, point: NDArray[np.float64]) -> Skeleton:
    """The skeleton with one more anchor."""
    edge, share, far = _nearest(skeleton, point)
    ends = skeleton.edges[edge] if len(skeleton.edges) else np.array([stands_for, stands_for])
    radius = (1 - share) * skeleton.radii[ends[0]] + share * skeleton.radii[ends[1]]
    if far <= PASSES * radius and share in (0.0, 1.0) and ends[int(share)] not in skeleton.anchors:
        node = int(ends[int(share)])
        nodes = np.array(skeleton.nodes)
        nodes[node] = point
        radii = np.array(skeleton.radii)
        radii[node] = surface.distance(point[None])[0]
        return replace(skeleton, nodes=nodes, radii=radii, anchors=np.append(skeleton.anchors, node))
    if far <= PASSES * radius and 0 < share < 1:
        extended = split_edge(skeleton, edge, point, float(surface.distance(point[None])[0]))
    else:
        pair = np.stack([skeleton.nodes[stands_for], point])
        path = np.concatenate([*interior_paths(pair, np.array([[0, 1]]), surface), point[None]])
        extended = append_paths(skeleton, [stands_for], [path], surface.distance(path))
    return replace(extended, anchors=np.append(extended.anchors, len(extended.nodes) - 1))


def _nearest(skeleton: Skeleton, point: NDArray[np.float64]) -> tuple[int, float, float]:
    """The edge nearest to a point, how far along it, from 0 to 1, and the distance."""
    if len(skeleton.edges) == 0:
        return 0, 0.0, float(np.linalg.norm(skeleton.nodes - point, axis=1).min())
    start, end = skeleton.nodes[skeleton.edges].transpose(1, 0, 2)
    along = end - start
    squared = np.einsum("ei,ei->e", along, along)
    share = np.clip(np.einsum("ei,ei->e", point - start, along) / np.where(squared > 0, squared, 1), 0, 1)
    far = np.linalg.norm(start + share[:, None] * along - point, axis=1)
    edge = int(np.argmin(far))
    return edge, float(share[edge]), float(far[edge])


def nearest_node(skeleton: Skeleton, place: Any, mesh: Mesh) -> int:
    """The node that stands for a vertex of the skeleton's mesh, or the one nearest to a point."""
    vertex, point = resolve_anchor(place, mesh)
    if np.ndim(place) == 0:
        return int(skeleton.node_of_vertex[vertex])
    return int(np.argmin(np.linalg.norm(skeleton.nodes - point, axis=1)))
