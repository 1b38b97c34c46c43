"""Holes filled with the triangulation of minimum area of their boundary loop.

Liepa 2003, "Filling holes in meshes", https://doi.org/10.2312/SGP/SGP03/200-206. A loop with too many edges for that
(:mod:`lbskel.geometry.polygon_triangulation`), or without an admissible triangulation, is filled with a fan around the
mean of its vertices. So is a planar loop: its triangulations have the same area, and rounding would choose one.
"""

from __future__ import annotations

__all__ = ["boundary_loops", "close_holes", "find_open_ends"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice, counted, were
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, triangle_normals, vector_lengths
from lbskel.geometry.polygon_triangulation import MAX_POLYGON_EDGES, min_area_triangulation
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step
from lbskel.preprocess.vertex_umbrellas import find_umbrellas

# Upper bound on the excess of the area of a fan over the least that any triangulation has, as a share of that, up to
# which the fan is as small as any. It follows from coordinates in single precision, which are rounded to 6e-8 of their
# size; by hand, with 0.02 one tip of 25 meshes is lost
MAX_EXCESS = 1e-6


@preprocess_step
def close_holes(mesh: Mesh, *, max_perimeter: float = 0.33) -> PreprocessResult:
    """Fill holes with triangles; no vertex moves.

    A boundary loop counts as the boundary of a sheet, not of a hole, and stays open if filling it would take at least
    as many faces as its component has, or more than half the component's area.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
        Consistently oriented, as :func:`fix_orientation` leaves it; loops at seams of the orientation stay open.
    max_perimeter : float
        Length of the longest boundary loop to close, as a fraction of the diameter bound. One of three edges, where a
        face is missing, may be longer.

    Raises
    ------
    UnknownChoice
        If the perimeter is not positive.
    """
    if not max_perimeter > 0:
        raise UnknownChoice(f"max_perimeter must be positive, not {max_perimeter}")
    loops = boundary_loops(mesh)
    V, faces = mesh.vertices, [mesh.faces]
    centers: list[list[float]] = []
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    area_of, n_faces_of = np.bincount(label, mesh.face_areas), np.bincount(label)
    n_open = 0
    edge_keys = set((mesh.edges[:, 0] * len(V) + mesh.edges[:, 1]).tolist())
    for loop in loops:
        boundary, component = V[loop], mesh.component_of_vertex[loop[0]]
        if len(loop) - 2 >= n_faces_of[component]:
            n_open += 1
            continue
        perimeter = vector_lengths(np.roll(boundary, -1, axis=0) - boundary).sum()
        if len(loop) > 3 and perimeter > max_perimeter * mesh.diameter_bound:
            n_open += 1
            continue
        vector_area = triangle_normals(boundary[0], boundary, np.roll(boundary, -1, axis=0)).sum(axis=0)
        if np.linalg.norm(vector_area) > area_of[component]:  # any triangulation has at least as much
            n_open += 1
            continue
        points, triangles = _fan(boundary)
        smallest = np.linalg.norm(vector_area)  # of any triangulation
        is_planar = len(loop) > 3 and _double_area(points, triangles) <= (1 + MAX_EXCESS) * smallest
        if not is_planar and len(loop) <= MAX_POLYGON_EDGES:
            forbidden = _existing_chords(loop, edge_keys, len(V))
            (found,), (double_area,) = min_area_triangulation(boundary[None], forbidden[None])
            if np.isfinite(double_area):
                points, triangles = boundary, found
        if _double_area(points, triangles) > area_of[component]:
            n_open += 1
            continue
        numbers = np.append(loop, len(V) + len(centers))
        centers += points[len(loop) :].tolist()
        patch = numbers[triangles][:, ::-1]  # opposite to the half-edges of the loop
        faces.append(patch)
        i, j = np.sort(patch[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).T
        edge_keys.update((i * len(V) + j).tolist())
    if len(faces) == 1:
        return identity_result(mesh)
    kept = f"; {counted(n_open, 'larger boundary loop')} left open" if n_open else ""
    note = f"{were(len(faces) - 1, 'hole')} closed with {counted(sum(map(len, faces[1:])), 'face')}{kept}"
    closed = Mesh(np.concatenate([V, *([centers] if centers else [])]), np.concatenate(faces), mesh.notes)
    return PreprocessResult(closed, VertexMap.identity(len(V)), (note,))


def _fan(boundary: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(k + 1, 3) corners and (k, 3) triangles of the fan of a polygon around the mean of its corners, which is last."""
    first = np.arange(len(boundary))
    triangles = np.stack([first, np.roll(first, -1), np.full(len(first), len(first))], axis=1)
    return np.concatenate([boundary, [boundary.mean(axis=0)]]), triangles


def _double_area(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> float:
    """Twice the area of triangles."""
    return float(vector_lengths(triangle_normals(*points[triangles].transpose(1, 0, 2))).sum())


def find_open_ends(mesh: Mesh) -> NDArray[np.float64]:
    """(k, 10) center of each boundary loop (3), its mean distance from that, its vector area (3), a vertex of it (3).

    The center is the centroid of its edges. The vector area is that of any surface that fills the loop.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented.
    """
    ends = []
    for loop in boundary_loops(mesh):
        P = mesh.vertices[loop]
        lengths = vector_lengths(np.roll(P, -1, axis=0) - P)
        if lengths.sum() > 0:
            center = np.average((np.roll(P, -1, axis=0) + P) / 2, axis=0, weights=lengths)
            vector_area = triangle_normals(center, P, np.roll(P, -1, axis=0)).sum(axis=0) / 2
            ends.append([*center, vector_lengths(P - center).mean(), *vector_area, *P[0]])
    return np.array(ends).reshape(-1, 10)


def boundary_loops(mesh: Mesh) -> list[NDArray[np.int64]]:
    """Find the boundary loops of all holes, each as its vertices in the direction of the faces' half-edges.

    At a vertex where holes meet, a loop goes on across the hole, not along the faces. A loop that passes a vertex twice
    is split there. Edges whose faces have opposite orientation, and edges of more than two faces, bound no hole. The
    loops are cached in the mesh.

    Parameters
    ----------
    mesh : Mesh
    """
    loops: list[NDArray[np.int64]] = Surface(mesh).memoize("boundary loops", lambda: _trace_boundary_loops(mesh))
    return loops


def _trace_boundary_loops(mesh: Mesh) -> list[NDArray[np.int64]]:
    """Trace the boundary loops of a mesh."""
    if not (mesh.faces_per_edge == 1).any():
        return []
    umbrellas = find_umbrellas(mesh)
    m, vertices = len(mesh.faces), mesh.half_edges[:, 0]
    half_edge = np.flatnonzero((umbrellas.twin < 0) & (vertices != mesh.half_edges[:, 1]))
    corner, face = half_edge // m, half_edge % m
    start = umbrellas.of_corner[face, (corner + 1) % 3]
    end = umbrellas.of_corner[face, (corner + 2) % 3]
    is_hole = mesh.faces_per_edge[mesh.edge_of_half_edge] == 1
    bounds_hole = is_hole[half_edge] & np.isin(start, end[is_hole[half_edge]])
    following = _across_holes(mesh, start[bounds_hole], half_edge[bounds_hole], int(umbrellas.of_corner.max()) + 1)
    next_of = dict(zip(start.tolist(), zip(following[end].tolist(), half_edge.tolist(), strict=True), strict=True))
    loops = []
    while next_of:
        first, (umbrella, along) = next_of.popitem()
        chain = [along]
        while umbrella != first and umbrella in next_of:
            umbrella, along = next_of.pop(umbrella)
            chain.append(along)
        if umbrella == first:
            loops += [vertices[part] for part in _split_at_repeated_vertices(chain, vertices) if is_hole[part].all()]
    return loops


def _across_holes(
    mesh: Mesh, umbrellas: NDArray[np.int64], half_edges: NDArray[np.int64], n_umbrellas: int
) -> NDArray[np.int64]:
    """(n_umbrellas,) the umbrella that each is followed by around its vertex, itself where it is the only one.

    Parameters
    ----------
    mesh : Mesh
    umbrellas : (k,) array of int
        Those between two holes, or with a hole all around.
    half_edges : (k,) array of int
        The first of each umbrella, which leaves its vertex; around a normal that points to the reader, the faces are to
        the left of it.
    n_umbrellas : int
    """
    following, vertex = np.arange(n_umbrellas), mesh.half_edges[half_edges, 0]
    is_shared = np.bincount(vertex, minlength=len(mesh.vertices)) > 1
    chosen = is_shared[vertex]
    if not chosen.any():
        return following
    umbrellas, half_edges, vertex = umbrellas[chosen], half_edges[chosen], vertex[chosen]
    faces = mesh.faces[is_shared[mesh.faces].any(axis=1)]
    normals = np.zeros((len(mesh.vertices), 3))
    for corner in faces.T:
        np.add.at(normals, corner, triangle_normals(*mesh.vertices[faces.T]))
    normal = normalized(normals[vertex])
    direction = mesh.vertices[mesh.half_edges[half_edges, 1]] - mesh.vertices[vertex]
    first, group = np.unique(vertex, return_index=True, return_inverse=True)[1:]
    reference = direction[first][group]
    sine = np.einsum("ki,ki->k", normal, np.cross(reference, direction))
    direction -= np.einsum("ki,ki->k", normal, direction)[:, None] * normal
    cosine = np.einsum("ki,ki->k", reference, direction)
    order = np.lexsort((np.arctan2(sine, cosine), group))
    begins = np.searchsorted(group[order], np.arange(len(first) + 1))
    successor = np.arange(1, len(order) + 1)
    successor[begins[1:] - 1] = begins[:-1]
    following[umbrellas[order]] = umbrellas[order[successor]]
    return following


def _split_at_repeated_vertices(chain: list[int], vertices: NDArray[np.int64]) -> list[list[int]]:
    """Split a closed chain of half-edges where it returns to a vertex, so that each part passes each vertex once."""
    parts: list[list[int]] = []
    path: list[int] = []
    position: dict[int, int] = {}
    for along, vertex in zip([*chain, chain[0]], vertices[[*chain, chain[0]]].tolist(), strict=True):
        if vertex in position:
            part, path = path[position[vertex] :], path[: position[vertex]]
            for removed in vertices[part].tolist():
                del position[removed]
            parts.append(part)
        position[vertex] = len(path)
        path.append(along)
    return [part for part in parts if len(part) > 2]


def _existing_chords(loop: NDArray[np.int64], edge_keys: set[int], n: int) -> NDArray[np.bool_]:
    """(k, k) whether the mesh already has an edge between two vertices of a loop that are not adjacent in it."""
    i, j = np.triu_indices(len(loop), 2)
    low, high = np.minimum(loop[i], loop[j]), np.maximum(loop[i], loop[j])
    exists = np.zeros((len(loop),) * 2, dtype=bool)
    exists[i, j] = [key in edge_keys for key in (low * n + high).tolist()]
    exists[0, -1] = False
    return exists
