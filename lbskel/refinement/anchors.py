"""Nodes that the caller asks for: anchors, which the skeleton must have, and the root, which comes first."""

from __future__ import annotations

__all__ = ["as_place", "as_point", "attach_anchors", "nearest_node", "resolve_anchor", "resolve_root"]

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import interior_paths
from lbskel.skeleton.editing import append_paths, split_edge
from lbskel.skeleton.skeleton import Skeleton

SNAP_DISTANCE = 0.5  # local radii from the skeleton within which an anchor gets no branch of its own; a guess
OUTSIDE_TOLERANCE = 1e-6  # by which a point may lie outside a closed surface or a bounding sphere, relative to the
# diameter bound; a guess that allows for rounding


def as_place(place: Any) -> NDArray[Any]:
    """Convert what should be an index or a point to an array, which is one of objects where rows differ in length."""
    try:
        return np.asarray(place)
    except ValueError:
        return np.array(None)


def as_point(place: Any) -> NDArray[np.float64] | None:
    """Convert a place to a point; None if it is not three finite real numbers."""
    given = as_place(place)
    if given.shape != (3,) or given.dtype.kind not in "iuf" or not np.isfinite(given).all():
        return None
    return given.astype(np.float64)


def resolve_anchor(anchor: Any, mesh: Mesh, what: str = "anchor") -> tuple[int, NDArray[np.float64]]:
    """Find the vertex that an anchor names, or the used vertex nearest to its point, and the anchor's position.

    Parameters
    ----------
    anchor : int or (3,) array_like
        A vertex, or a point in the coordinates of the mesh.
    mesh : Mesh
    what : str
        What the place is given for, for the message.

    Returns
    -------
    vertex : int
    position : (3,) array of float

    Raises
    ------
    MeshError
        If there is no such vertex, it belongs to no face, or the anchor is neither a vertex nor a point.
    """
    V, given = mesh.vertices, as_place(anchor)
    if given.ndim == 0 and np.issubdtype(given.dtype, np.integer):
        if not 0 <= given < len(V):
            raise MeshError(f"there is no vertex {given}, given as {what}: the mesh has vertices 0..{len(V) - 1}")
        if int(given) not in mesh.used_vertices:
            raise MeshError(f"vertex {given}, given as {what}, belongs to no face; give a vertex of a face, or a point")
        return int(given), V[int(given)]
    if (point := as_point(anchor)) is None:
        raise MeshError(f"the {what} must be the index of a vertex or a point of three numbers, not {anchor!r}")
    used = mesh.used_vertices
    with np.errstate(over="ignore"):  # a point so far away is refused where it is attached
        distances = vector_lengths(V[used] - point)
    return int(used[np.argmin(distances)]), point


def attach_anchors(
    skeleton: Skeleton,
    surface: Surface,
    vertices: NDArray[np.int64],
    points: NDArray[np.float64],
    numbers: NDArray[np.int64],
) -> Skeleton:
    """Add a node at every anchor.

    Where the skeleton passes within ``SNAP_DISTANCE`` local radii of an anchor, the nearest node is moved to it, or the
    nearest edge is split there. Elsewhere a branch is added below the surface, from the node to which the anchor's
    vertex is mapped.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii and ``node_of_vertex``.
    surface : Surface
    vertices : (a,) array of int
        The vertex at or nearest to each anchor.
    points : (a, 3) array of float
    numbers : (a,) array of int
        By which errors name the anchors.

    Raises
    ------
    MeshError
        If a point lies outside a closed surface, or outside the bounding sphere of an open one.
    """
    if len(points) == 0:
        return skeleton
    if surface.mesh.is_closed:
        tolerance = OUTSIDE_TOLERANCE * surface.mesh.diameter_bound
        is_outside, where = ~surface.contains(points) & (surface.distance(points) > tolerance), "the surface"
    else:
        is_outside, where = _is_outside_bounding_sphere(points, surface.mesh), "the bounding sphere of the mesh"
    for number in numbers[is_outside][:1]:
        raise MeshError(f"anchor {number} lies outside of {where}; give a vertex or a point inside")
    for vertex, point in zip(vertices.tolist(), points, strict=True):
        skeleton = _with_anchor(skeleton, surface, int(skeleton.node_of_vertex[vertex]), point)
    return skeleton


def _is_outside_bounding_sphere(points: NDArray[np.float64], mesh: Mesh) -> NDArray[np.bool_]:
    """(k,) whether points lie outside the smallest sphere around the mesh's centroid that contains its vertices."""
    distances = vector_lengths(points - mesh.centroid)
    is_outside: NDArray[np.bool_] = distances > (0.5 + OUTSIDE_TOLERANCE) * mesh.diameter_bound
    return is_outside


def _with_anchor(skeleton: Skeleton, surface: Surface, node_of_anchor: int, point: NDArray[np.float64]) -> Skeleton:
    """Add one anchor; a branch to it, where one is needed, begins at ``node_of_anchor``."""
    edge, share, distance = _nearest_edge(skeleton, point)
    ends = skeleton.edges[edge] if len(skeleton.edges) else np.array([node_of_anchor, node_of_anchor])
    radius = (1 - share) * skeleton.radii[ends[0]] + share * skeleton.radii[ends[1]]
    is_near = distance <= SNAP_DISTANCE * radius
    if is_near and share in (0.0, 1.0) and ends[int(share)] not in skeleton.anchors:
        node = int(ends[int(share)])
        nodes = np.array(skeleton.nodes)
        nodes[node] = point
        radii = np.array(skeleton.radii)
        radii[node] = surface.distance(point[None])[0]
        return replace(skeleton, nodes=nodes, radii=radii, anchors=np.append(skeleton.anchors, node))
    if is_near and 0 < share < 1:
        extended = split_edge(skeleton, edge, point, float(surface.distance(point[None])[0]))
    else:
        pair = np.stack([skeleton.nodes[node_of_anchor], point])
        path = np.concatenate([*interior_paths(pair, np.array([[0, 1]]), surface), point[None]])
        extended = append_paths(skeleton, [node_of_anchor], [path], surface.distance(path))
    return replace(extended, anchors=np.append(extended.anchors, len(extended.nodes) - 1))


def _nearest_edge(skeleton: Skeleton, point: NDArray[np.float64]) -> tuple[int, float, float]:
    """Find the edge nearest to a point, the position along it from 0 to 1, and the distance."""
    if len(skeleton.edges) == 0:
        return 0, 0.0, float(vector_lengths(skeleton.nodes - point).min())
    start, end = skeleton.nodes[skeleton.edges].transpose(1, 0, 2)
    along = end - start
    squared = np.einsum("ei,ei->e", along, along)
    share = np.clip(np.einsum("ei,ei->e", point - start, along) / np.where(squared > 0, squared, 1), 0, 1)
    distances = vector_lengths(start + share[:, None] * along - point)
    edge = int(np.argmin(distances))
    return edge, float(share[edge]), float(distances[edge])


def resolve_root(root: Any, mesh: Mesh) -> tuple[int, NDArray[np.float64]]:
    """Find the vertex and the position of a root as :func:`resolve_anchor` does of an anchor.

    Parameters
    ----------
    root : int or (3,) array_like
        A vertex, or a point in the coordinates of the mesh.
    mesh : Mesh

    Raises
    ------
    MeshError
        If there is no such vertex, it belongs to no face, the root is neither a vertex nor a point, or its point lies
        outside the sphere around the mesh's centroid that contains all vertices.
    """
    vertex, point = resolve_anchor(root, mesh, "root")
    if np.ndim(root) and _is_outside_bounding_sphere(point, mesh):
        raise MeshError(
            f"the root {root!r} lies outside of the bounding sphere of the mesh; give a vertex, or a point inside in "
            "the units of the mesh, which are not those of a scale"
        )
    return vertex, point


def nearest_node(skeleton: Skeleton, root: Any, mesh: Mesh) -> int:
    """Find the node to which a vertex of the skeleton's mesh is mapped, or the node nearest to a point.

    Parameters
    ----------
    skeleton : Skeleton
    root : int or (3,) array_like
        As for :func:`resolve_root`, with the same errors.
    mesh : Mesh
        The mesh that ``node_of_vertex`` belongs to.
    """
    vertex, point = resolve_root(root, mesh)
    if np.ndim(root) == 0:
        return int(skeleton.node_of_vertex[vertex])
    return int(np.argmin(vector_lengths(skeleton.nodes - point)))
