"""Long edges split, where a mesh is too coarse for what it encloses; vertices and surface stay where they are."""

from __future__ import annotations

__all__ = ["coarse_share", "refine"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_thickness
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, measured

MOST_FACES = 200_000
ROUNDS = 8  # each halves the longest edges
SAMPLE = 300  # faces that tell how many are coarse
FLAT = 0.02  # of the diagonal: thinner parts are left as they are, being flat or too long to be worth their faces


@measured
def refine(mesh: Mesh, *, edge: float = 0.5) -> PreprocessResult:
    """Split edges that are long against the thickness of the shape, until none is or there are 200,000 faces.

    Parameters
    ----------
    mesh : Mesh
        Facing outwards, as :func:`fix_orientation` leaves it.
    edge : float
        Longest edge, as a fraction of the local thickness.

    Raises
    ------
    UnknownChoice
        If it is not positive.
    """
    if not edge > 0:
        raise UnknownChoice(f"edge must be positive, not {edge}")
    may_be = _may_be_coarse(mesh, edge)
    wanted = np.full(len(mesh.faces), np.inf)
    wanted[may_be] = _wanted(mesh, may_be, edge)
    V, F = mesh.vertices, mesh.faces
    for _ in range(ROUNDS):
        fine = Mesh(V, F)
        is_long = _is_long(fine, wanted)
        if not is_long.any() or len(F) + 2 * is_long.sum() > MOST_FACES:
            break
        V, F, parent = _split(fine, is_long)
        wanted = wanted[parent]
    if len(F) == len(mesh.faces):
        return identity_result(mesh)
    note = f"{len(mesh.faces):,} faces were split into {len(F):,}, since edges were long against the thickness"
    return PreprocessResult(Mesh(V, F, mesh.notes), VertexMap.identity(len(mesh.vertices)), (note,))


def coarse_share(mesh: Mesh, edge: float) -> float:
    """The share of the faces with an edge longer than a fraction of the thickness there, from a sample of them."""
    may_be = _may_be_coarse(mesh, edge)
    sample = may_be[:: 1 + len(may_be) // SAMPLE]
    if len(sample) == 0:
        return 0.0
    is_coarse = _longest_edges(mesh)[sample] > _wanted(mesh, sample, edge)
    return float(is_coarse.mean()) * len(may_be) / len(mesh.faces)


def _longest_edges(mesh: Mesh) -> NDArray[np.float64]:
    """(m,) length of the longest edge of each face."""
    P = mesh.vertices[mesh.faces]
    return np.linalg.norm(P - np.roll(P, 1, axis=1), axis=2).max(axis=1)


def _may_be_coarse(mesh: Mesh, edge: float) -> NDArray[np.int64]:
    """The faces that are large enough to be coarse where the shape is as thin as is looked at."""
    return np.flatnonzero(_longest_edges(mesh) > edge * FLAT * mesh.diagonal)


def _wanted(mesh: Mesh, faces: NDArray[np.int64], edge: float) -> NDArray[np.float64]:
    """(k,) the longest that an edge of each face should be: a fraction of the thickness; infinite in flat parts."""
    thickness = local_thickness(mesh, faces)
    return np.where(thickness > FLAT * mesh.diagonal, edge * thickness, np.inf)


def _is_long(mesh: Mesh, wanted: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether each edge is longer than what one of its faces wants."""
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    least = np.full(len(mesh.edges), np.inf)
    np.minimum.at(least, mesh.edge_of_half_edge, np.tile(wanted, 3))
    return np.linalg.norm(end - start, axis=1) > least


def _split(mesh: Mesh, is_long: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Vertices, faces and the face that each came from, with a vertex in the middle of the edges chosen."""
    m, n = len(mesh.faces), len(mesh.vertices)
    middle_of_edge = np.where(is_long, n - 1 + np.cumsum(is_long), -1)
    V = np.concatenate([mesh.vertices, mesh.vertices[mesh.edges[is_long]].mean(axis=1)])
    middle = middle_of_edge[mesh.edge_of_half_edge].reshape(3, m).T  # opposite each corner
    is_split = middle >= 0
    count = is_split.sum(axis=1)
    faces, parents = [mesh.faces[count == 0]], [np.flatnonzero(count == 0)]
    for number, patterns in _PATTERNS.items():
        rows = np.flatnonzero(count == number)
        # the first corner is the one opposite the only edge to be split, or to be kept
        first = is_split[rows].argmax(axis=1) if number == 1 else (~is_split[rows]).argmax(axis=1)
        turn = (first[:, None] + np.arange(3)) % 3
        points = np.concatenate(
            [np.take_along_axis(mesh.faces[rows], turn, 1), np.take_along_axis(middle[rows], turn, 1)], axis=1
        )
        for pattern in patterns:
            faces.append(points[:, pattern])
            parents.append(rows)
    return V, np.concatenate(faces), np.concatenate(parents)


# Corners are 0, 1, 2, the middles of the edges opposite them 3, 4, 5
_PATTERNS: dict[int, list[list[int]]] = {
    1: [[0, 1, 3], [0, 3, 2]],
    2: [[0, 5, 4], [5, 1, 4], [1, 2, 4]],
    3: [[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]],
}
