"""The way of vertices to a surface that was meshed anew: the nearest point that faces the same way, and whole patches.

The nearest point alone jumps to the other side where a shape is thin. Of the vertices that then go to one vertex, those
that do not hang together with most of them go where their neighbors go, so that every patch is in one piece.
"""

from __future__ import annotations

__all__ = ["transfer_map"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult

CANDIDATES = 32  # vertices searched for one that faces the same way
ROUNDS = 50


def transfer_map(mesh: Mesh, surface: Mesh, *notes: str) -> PreprocessResult:
    """The way of each vertex of a mesh to another mesh of the same surface.

    Parameters
    ----------
    mesh, surface : Mesh
        Before and after.
    notes : str
        What was done, a sentence each.
    """
    given = surface
    mesh, surface = (
        each.with_vertices(np.ldexp(each.vertices, -unit_scale(mesh.vertices)[1])) for each in (mesh, surface)
    )
    V, F = surface.vertices, surface.faces
    tree = igl.AABB()
    tree.init(V, F)
    _, face, point = tree.squared_distance(V, F, mesh.vertices)
    A, B, C = (np.ascontiguousarray(corner) for corner in V[F[face]].transpose(1, 0, 2))
    share = igl.barycentric_coordinates(point, A, B, C)
    share = np.clip(np.nan_to_num(share), 0.0, 1.0)
    share[share.sum(axis=1) == 0] = [1.0, 0.0, 0.0]
    share /= share.sum(axis=1, keepdims=True)
    corners = F[face]

    normals = np.nan_to_num(igl.per_vertex_normals(mesh.vertices, mesh.faces))
    there = np.nan_to_num(igl.per_vertex_normals(V, F))
    faces_away = np.flatnonzero(np.einsum("nx,nx->n", np.cross(B - A, C - A), normals) < 0)
    if len(faces_away):
        corners[faces_away] = _facing_alike(mesh.vertices[faces_away], normals[faces_away], surface, there)[:, None]
        share[faces_away] = [1.0, 0.0, 0.0]
    vertex_map = corners[np.arange(len(corners)), share.argmax(axis=1)]
    joined = _in_one_piece(mesh, vertex_map)
    moved = np.flatnonzero(joined != vertex_map)
    corners[moved], share[moved] = joined[moved, None], [1.0, 0.0, 0.0]
    joined[np.setdiff1d(np.arange(len(joined)), mesh.used_vertices)] = -1
    rows = np.repeat(np.arange(len(corners)), 3)
    weights = csr_array((share.ravel(), (rows, corners.ravel())), shape=(len(corners), len(V)))
    return PreprocessResult(given, VertexMap(joined), notes, weights)


def _facing_alike(
    points: NDArray[np.float64], normals: NDArray[np.float64], surface: Mesh, there: NDArray[np.float64]
) -> NDArray[np.int64]:
    """(k,) the nearest vertex that faces as each point does; the nearest of all where none of the near ones does."""
    used = surface.used_vertices
    _, near = cKDTree(surface.vertices[used]).query(points, k=min(CANDIDATES, len(used)))
    near = used[near.reshape(len(points), -1)]
    alike = np.einsum("nkx,nx->nk", there[near], normals) > 0
    return near[np.arange(len(points)), alike.argmax(axis=1)]


def _in_one_piece(mesh: Mesh, target: NDArray[np.int64]) -> NDArray[np.int64]:
    """Targets of vertices, changed so that the vertices of each target hang together through edges of the mesh."""
    target = np.array(target)
    i, j = mesh.edges.T
    n = len(target)
    for _ in range(ROUNDS):
        same = target[i] == target[j]
        graph = weighted_graph(mesh.edges[same], np.ones(same.sum(), dtype=np.int8), n)
        n_pieces, piece = connected_components(graph, directed=False)
        size = np.bincount(piece)
        target_of_piece = np.zeros(n_pieces, dtype=np.int64)
        target_of_piece[piece] = target
        order = np.lexsort((np.arange(n_pieces), -size, target_of_piece))
        is_main = np.zeros(n_pieces, dtype=bool)
        is_main[order[np.unique(target_of_piece[order], return_index=True)[1]]] = True
        # a vertex of a stray piece takes the target of a neighbor in a main one
        stray = ~is_main[piece]
        here, beside = np.concatenate([i, j]), np.concatenate([j, i])
        hands_on = stray[here] & ~stray[beside]
        if not hands_on.any():
            break
        target[here[hands_on][::-1]] = target[beside[hands_on][::-1]]
    return target
