"""Vertex map from a mesh to a remeshed version of it: the nearest point with a similar normal, in connected patches.

The nearest point alone may lie on the other side of a thin shape, so its normal must agree. The vertices mapped to one
target are then made a connected patch: those outside the largest part take the targets of their neighbors.
"""

from __future__ import annotations

__all__ = ["transfer_map"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.vertex_map import VertexMap, is_in_largest_piece
from lbskel.preprocess.result import PreprocessResult

N_CANDIDATES = 32  # nearest vertices searched for one with a similar normal; a guess
MAX_ROUNDS = 50  # rounds in which targets spread from neighbor to neighbor; a guess


def transfer_map(mesh: Mesh, surface: Mesh, *notes: str) -> PreprocessResult:
    """Map the vertices of a mesh to those of another mesh of the same surface.

    Parameters
    ----------
    mesh, surface : Mesh
        Source and target.
    notes : str
        What was done, a sentence each.
    """
    exponent = unit_scale(mesh.vertices)[1]
    source, target = (each.with_vertices(np.ldexp(each.vertices, -exponent)) for each in (mesh, surface))
    V, F = target.vertices, target.faces
    tree = igl.AABB()
    tree.init(V, F)
    _, face, point = tree.squared_distance(V, F, source.vertices)
    A, B, C = (np.ascontiguousarray(corner) for corner in V[F[face]].transpose(1, 0, 2))
    weight = igl.barycentric_coordinates(point, A, B, C)
    weight = np.clip(np.nan_to_num(weight), 0.0, 1.0)
    weight[weight.sum(axis=1) == 0] = [1.0, 0.0, 0.0]
    weight /= weight.sum(axis=1, keepdims=True)
    corners = F[face]

    normals = np.nan_to_num(igl.per_vertex_normals(source.vertices, source.faces))
    target_normals = np.nan_to_num(igl.per_vertex_normals(V, F))
    is_opposite = np.flatnonzero(np.einsum("nx,nx->n", triangle_normals(A, B, C), normals) < 0)
    if len(is_opposite):
        nearest = _nearest_with_similar_normal(
            source.vertices[is_opposite], normals[is_opposite], target, target_normals
        )
        corners[is_opposite] = nearest[:, None]
        weight[is_opposite] = [1.0, 0.0, 0.0]
    heaviest = corners[np.arange(len(corners)), weight.argmax(axis=1)]
    vertex_map = _make_patches_connected(source, heaviest)
    changed = np.flatnonzero(vertex_map != heaviest)
    corners[changed], weight[changed] = vertex_map[changed, None], [1.0, 0.0, 0.0]
    vertex_map[np.setdiff1d(np.arange(len(vertex_map)), source.used_vertices)] = -1
    rows = np.repeat(np.arange(len(corners)), 3)
    weights = csr_array((weight.ravel(), (rows, corners.ravel())), shape=(len(corners), len(V)))
    return PreprocessResult(surface, VertexMap(vertex_map), notes, weights)


def _nearest_with_similar_normal(
    points: NDArray[np.float64], normals: NDArray[np.float64], target: Mesh, target_normals: NDArray[np.float64]
) -> NDArray[np.int64]:
    """(k,) nearest vertex whose normal agrees with that of each point; the nearest of all if no candidate's agrees."""
    used = target.used_vertices
    _, candidates = cKDTree(target.vertices[used]).query(points, k=min(N_CANDIDATES, len(used)))
    candidates = used[candidates.reshape(len(points), -1)]
    agrees = np.einsum("nkx,nx->nk", target_normals[candidates], normals) > 0
    nearest: NDArray[np.int64] = candidates[np.arange(len(points)), agrees.argmax(axis=1)]
    return nearest


def _make_patches_connected(mesh: Mesh, target: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) targets of vertices, changed so that the vertices of each target are connected by edges of the mesh.

    A vertex outside the largest piece of its target takes the target of a neighbor inside one.
    """
    target = np.array(target)
    vertex, neighbor = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    for _ in range(MAX_ROUNDS):
        is_inside = is_in_largest_piece(target, mesh)
        is_changed = ~is_inside[vertex] & is_inside[neighbor]
        if not is_changed.any():
            break
        target[vertex[is_changed][::-1]] = target[neighbor[is_changed][::-1]]
    return target
