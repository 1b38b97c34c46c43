"""A numbering of vertices and faces that follows from the surface, not from the order in which a file lists them.

Simplification, seeds and ties between equal lengths depend on the numbering. The canonical one is that of a
breadth-first traversal of the faces across their edges: it begins at the corner farthest from the centroid, and enters
each face's other neighbors in the sense of its orientation. So it does not change with the order of vertices and faces,
nor with rotation, except for shapes with several such corners. Of a mesh and its mirror image, which have opposite
senses, one is numbered for both. Where edges at that corner are equally long, as on a mesh of voxels, their coordinates
decide, so that a rotated mesh may be numbered otherwise.
"""

from __future__ import annotations

__all__ = ["in_canonical_order"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import component_roots
from lbskel._kernels.traversal import breadth_first_faces, pair_half_edges
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

# What does not change with the numbering
_KEPT_PROPERTIES = ("n_components", "is_edge_manifold", "is_closed", "is_closed_manifold", "euler_characteristic")

MIRROR = read_only(np.array([-1.0, 1.0, 1.0]))  # factors on coordinates
DIGITS = 9  # decimals of lengths, in diameter bounds, that are compared: rounding of sums must not decide


def in_canonical_order(mesh: Mesh) -> tuple[Mesh, VertexMap, NDArray[np.float64]]:
    """Renumber a mesh, or its mirror image, in its canonical order; the result is cached in the mesh.

    Components stay in their order. The traversal crosses only edges of exactly two faces, and each part of the surface
    between the other edges has a first corner of its own. Vertices without a face come last, in their given order.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    mesh : Mesh
        The same surface, or its mirror image, whichever is the canonical one of the two.
    vertex_map : VertexMap
        From the vertices of the given mesh to those of the returned one.
    mirror : (3,) array of float
        Factors on the coordinates of the given mesh, 1 or -1.
    """
    ordered: tuple[Mesh, VertexMap, NDArray[np.float64]] = Surface(mesh).memoize(
        "canonical order", lambda: _in_canonical_order(mesh)
    )
    return ordered


def _in_canonical_order(mesh: Mesh) -> tuple[Mesh, VertexMap, NDArray[np.float64]]:
    n, m = len(mesh.vertices), len(mesh.faces)
    if m == 0:
        return mesh, VertexMap.identity(n), np.ones(3)
    mirror = MIRROR if _comes_after_its_mirror_image(mesh) else np.ones(3)
    mesh = _mirrored(mesh) if mirror is MIRROR else mesh
    corners = _traversal(mesh)
    component = mesh.component_of_vertex
    corners = corners[stable_order(component[mesh.faces[corners % m, 0]])]
    faces, entry = corners % m, corners // m
    turned = np.stack([mesh.faces[faces, (entry + k) % 3] for k in range(3)], axis=1)
    corners = turned.ravel()
    first = np.full(n, len(corners))
    first[corners[::-1]] = np.arange(len(corners))[::-1]  # of several positions the last counts, which is the first
    order = stable_order(first)
    new_index = np.empty(n, dtype=np.int64)
    new_index[order] = np.arange(n)
    ordered = replace(mesh, vertices=mesh.vertices[order], faces=new_index[turned])
    _keep_properties(mesh, ordered)
    ordered.__dict__["component_of_vertex"] = read_only(component[order])
    ordered.__dict__["_edge_table"] = _edge_table(
        mesh, new_index, ((entry + np.arange(3)[:, None]) % 3 * m + faces).ravel()
    )
    return ordered, VertexMap(new_index), mirror


def _keep_properties(mesh: Mesh, other: Mesh) -> None:
    """Copy what is known of a mesh and does not change with the numbering, nor in its mirror image."""
    other.__dict__.update({name: mesh.__dict__[name] for name in _KEPT_PROPERTIES if name in mesh.__dict__})


def _comes_after_its_mirror_image(mesh: Mesh) -> bool:
    """Compare a mesh with its mirror image by their first half-edges and the corners opposite these.

    A half-edge has its face on its left, and in the mirror image on its right. So the image has another first one.
    """
    unit, distance = _from_centroid(mesh)
    start, end = mesh.half_edges.T
    opposite = mesh.faces.T.ravel()

    def first(corner: NDArray[np.int64], other: NDArray[np.int64]) -> tuple[float, float]:
        rows = np.flatnonzero(distance[corner] == distance[corner].max())
        length = np.round(vector_lengths(unit[other[rows]] - unit[corner[rows]]), DIGITS)
        return float(length.max()), float(distance[opposite[rows[length == length.max()]]].max())

    return first(end, start) < first(start, end)


def _mirrored(mesh: Mesh) -> Mesh:
    """Mirror a mesh; its faces stay oriented outwards."""
    image = replace(mesh, vertices=mesh.vertices * MIRROR, faces=mesh.faces[:, [0, 2, 1]])
    _keep_properties(mesh, image)
    image.__dict__["component_of_vertex"] = mesh.component_of_vertex
    half_edges = mesh.edge_of_half_edge.reshape(3, -1)[[0, 2, 1]].ravel()
    image.__dict__["_edge_table"] = mesh.edges, read_only(half_edges)
    return image


def _edge_table(
    mesh: Mesh, new_index: NDArray[np.int64], half_edges: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges of the renumbered mesh and the row of each of its half-edges, from those of the mesh.

    ``half_edges`` has the half-edge of the mesh for each of the renumbered one.
    """
    start, end = new_index[mesh.edges].T
    first, second = np.minimum(start, end), np.maximum(start, end)
    order = stable_order(first * len(new_index) + second)
    row = np.empty(len(order), dtype=np.int64)
    row[order] = np.arange(len(order))
    edges = np.stack([first[order], second[order]], axis=1)
    return read_only(edges), read_only(row[mesh.edge_of_half_edge[half_edges]])


def _traversal(mesh: Mesh) -> NDArray[np.int64]:
    """(m,) the half-edge by which each face is entered, in order; half-edge ``k * m + f`` is opposite corner k."""
    m = len(mesh.faces)
    twins = pair_half_edges(mesh.edge_of_half_edge, mesh.faces_per_edge)
    crossed = np.flatnonzero(twins >= 0)
    part = component_roots(np.stack([crossed, twins[crossed]], axis=1) % m, np.zeros(m, dtype=np.int64))
    starts = _by_position(mesh, part)
    return np.asarray(breadth_first_faces(twins, starts[np.sort(np.unique(part[starts % m], return_index=True)[1])]))


def _by_position(mesh: Mesh, part: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k,) candidates for the first half-edge of each part, by distance from the centroid, length and coordinates.

    Of the half-edges of a part, those that start farthest from the centroid, and of these the longest. ``part`` has the
    number of the part of each face.
    """
    unit, distance = _from_centroid(mesh)
    start, end = mesh.half_edges.T
    candidates, owner, distance = np.arange(len(start)), np.tile(part, 3), distance[start]
    candidates = candidates[_is_largest(distance, owner)]
    length = np.round(vector_lengths(unit[end[candidates]] - unit[start[candidates]]), DIGITS)
    is_longest = _is_largest(length, owner[candidates])
    candidates = candidates[is_longest]
    places = np.round(np.hstack([unit[end[candidates]], unit[start[candidates]]]), DIGITS)
    order = np.lexsort((*places.T, -length[is_longest], -distance[candidates]))
    return np.asarray(candidates[order])


def _from_centroid(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 3) vertices about the centroid, in diameter bounds, and (n,) their rounded distances from it."""
    unit = (mesh.vertices - mesh.centroid) / max(mesh.diameter_bound, np.finfo(np.float64).tiny)
    return unit, np.round(vector_lengths(unit), DIGITS)


def _is_largest(values: NDArray[np.float64], owner: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each value is the largest of its owner."""
    largest = np.full(int(owner.max()) + 1, -np.inf)
    np.maximum.at(largest, owner, values)
    return np.asarray(values == largest[owner])
