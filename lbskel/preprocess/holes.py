"""Holes closed by the triangles of least area on their rim.

As Liepa 2003, "Filling holes in meshes", https://doi.org/10.2312/SGP/SGP03/200-206, does it. A rim too long for that
(:mod:`lbskel.geometry.polygon_triangulation`) gets a vertex in its middle.
"""

from __future__ import annotations

__all__ = ["boundary_loops", "close_holes"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.polygon_triangulation import MOST_EDGES, least_area
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, measured
from lbskel.preprocess.vertex_umbrellas import fans_of


@measured
def close_holes(mesh: Mesh, *, largest: float = 0.3) -> PreprocessResult:
    """Fill holes with triangles; all vertices stay where they are.

    A rim that would take as many faces as its component has, or half its area, is that of a sheet and no hole.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented, as :func:`fix_orientation` leaves it; rims at seams of the orientation stay open.
    largest : float
        Length of the rim of the largest hole to close, as a fraction of the diagonal.

    Raises
    ------
    UnknownChoice
        If it is not positive.
    """
    if not largest > 0:
        raise UnknownChoice(f"largest must be positive, not {largest}")
    loops = boundary_loops(mesh)
    V, faces = mesh.vertices, [mesh.faces]
    middles: list[list[float]] = []
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    area_of, n_faces_of = np.bincount(label, mesh.face_areas), np.bincount(label)
    n_open = 0
    pairs = set((mesh.edges[:, 0] * len(V) + mesh.edges[:, 1]).tolist())
    for loop in loops:
        rim, component = V[loop], mesh.component_of_vertex[loop[0]]
        if len(loop) - 2 >= n_faces_of[component]:
            n_open += 1
            continue
        if np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1).sum() > largest * mesh.diagonal:
            n_open += 1
            continue
        places, double_area = rim, np.inf
        if len(loop) <= MOST_EDGES:
            (triangles,), (double_area,) = least_area(rim[None], _chords_taken(loop, pairs, len(V))[None])
        if not np.isfinite(double_area):  # a vertex in the middle, numbered after those of the rim
            places, first = np.concatenate([rim, [rim.mean(axis=0)]]), np.arange(len(loop))
            triangles = np.stack([first, np.roll(first, -1), np.full(len(loop), len(loop))], axis=1)
        A, B, C = places[triangles].transpose(1, 0, 2)
        if np.linalg.norm(np.cross(B - A, C - A), axis=1).sum() > area_of[component]:
            n_open += 1
            continue
        numbers = np.append(loop, len(V) + len(middles))
        middles += places[len(loop) :].tolist()
        patch = numbers[triangles][:, ::-1]  # against the half-edges of the rim
        faces.append(patch)
        i, j = np.sort(patch[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).T
        pairs.update((i * len(V) + j).tolist())
    if len(faces) == 1:
        return identity_result(mesh)
    left = f"; {n_open} larger rims stay open" if n_open else ""
    note = f"{len(faces) - 1} holes were closed with {sum(map(len, faces[1:]))} faces{left}"
    closed = Mesh(np.concatenate([V, *([middles] if middles else [])]), np.concatenate(faces), mesh.notes)
    return PreprocessResult(closed, VertexMap.identity(len(V)), (note,))


def boundary_loops(mesh: Mesh) -> list[NDArray[np.int64]]:
    """The rims of all holes, each as its vertices in the direction of the faces' half-edges.

    A rim that passes a vertex twice is cut there into two. What is open only because neighbors disagree in
    orientation, or because an edge has more than two faces, is no hole.
    """
    fans = fans_of(mesh)
    m = len(mesh.faces)
    is_rim = (fans.partner < 0) & (mesh.half_edges[:, 0] != mesh.half_edges[:, 1])
    half_edge = np.flatnonzero(is_rim)
    corner, face = half_edge // m, half_edge % m
    start = fans.of_corner[face, (corner + 1) % 3]
    end = fans.of_corner[face, (corner + 2) % 3]
    next_of = dict(zip(start.tolist(), zip(end.tolist(), half_edge.tolist(), strict=True), strict=True))
    is_hole = mesh.faces_per_edge[mesh.edge_of_half_edge] == 1
    loops = []
    while next_of:
        here, (there, by) = next_of.popitem()
        first, way = here, [by]
        while there != first and there in next_of:
            there, by = next_of.pop(there)
            way.append(by)
        if there == first and is_hole[way].all():
            loops += _simple(mesh.half_edges[way, 0].tolist())
    return loops


def _simple(loop: list[int]) -> list[NDArray[np.int64]]:
    """A loop cut where it passes a vertex again, so that each vertex is in each part once."""
    parts: list[NDArray[np.int64]] = []
    way: list[int] = []
    place: dict[int, int] = {}
    for vertex in [*loop, loop[0]]:
        if vertex in place:
            part, way = way[place[vertex] :], way[: place[vertex]]
            for left in part:
                del place[left]
            parts.append(np.array(part))
        place[vertex] = len(way)
        way.append(vertex)
    return [part for part in parts if len(part) > 2]


def _chords_taken(loop: NDArray[np.int64], pairs: set[int], n: int) -> NDArray[np.bool_]:
    """(k, k) whether two vertices of a loop that are not neighbors in it have an edge of the mesh already."""
    i, j = np.triu_indices(len(loop), 2)
    low, high = np.minimum(loop[i], loop[j]), np.maximum(loop[i], loop[j])
    taken = np.zeros((len(loop),) * 2, dtype=bool)
    taken[i, j] = [key in pairs for key in (low * n + high).tolist()]
    taken[0, -1] = False
    return taken
