"""Splitting of edges that are long relative to the local thickness; neither vertices nor surface move."""

from __future__ import annotations

__all__ = ["coarse_faces", "refine"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice, were
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step

# Number of faces that refinement aims at where the limit on edges would take more; it bounds the time. "Faces that the
# refinement of coarse meshes aims at" in benchmarks/results/neurons.md: with 22,000 0.478 of the tips of neurons are
# found in place of 0.465, in a sixth more time (by hand; the times of the table vary by more); with 18,000 0.457 are
MAX_FACES = 18_500

# The same for a mesh of more faces, as a multiple of these. Rows in benchmarks/results/coarse.md: with 1, which refines
# none of them, four of 13 parts are wrong, with 1.15 and 1.3 one is, and 1.5 to 3 are alike
MAX_GROWTH = 2.0

MAX_ROUNDS = 8  # each round halves the longest edges; a guess

TIE = 1e-9  # relative difference of two diagonals up to which they count as equal, so that rounding decides no ties

FACTOR_STEP = 1.1  # by which the limit is raised until there are few enough faces


@preprocess_step
def refine(mesh: Mesh, *, max_edge_length: float = 0.5) -> PreprocessResult:
    """Split edges that are long relative to the local thickness, until none is or there are many faces.

    These are about 18,500, or twice as many as before for a mesh of more. Where the limit would take more faces, it
    is raised by one factor everywhere, so that thick and thin parts stay equally fine, and faces are divided by their
    shorter diagonals, which need fewer faces for the same edges.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
        Oriented outwards, as :func:`fix_orientation` leaves it.
    max_edge_length : float
        Largest length of an edge, as a fraction of the local thickness, which is twice the local radius.

    Raises
    ------
    UnknownChoice
        If the length is not positive.
    """
    if not max_edge_length > 0:
        raise UnknownChoice(f"max_edge_length must be positive, not {max_edge_length}")
    n = len(mesh.faces)
    most_faces = MAX_FACES if n <= MAX_FACES else MAX_GROWTH * n
    ratios = _length_ratios(mesh, max_edge_length)
    factor = 1.0
    while _predicted_faces(ratios / factor) > most_faces:
        factor *= FACTOR_STEP
    limits = factor * _edge_length_limits(mesh, max_edge_length)
    V, F = mesh.vertices, mesh.faces
    for _ in range(MAX_ROUNDS):
        fine = Mesh(V, F)
        is_long = _is_too_long(fine, limits)
        if not is_long.any() or len(F) >= most_faces:
            break
        V, F, parent = _split_edges(fine, is_long, shorter=factor > 1)
        limits = limits[parent]
    if len(F) == len(mesh.faces):
        return identity_result(mesh)
    note = (
        f"{were(len(mesh.faces), 'face')} split into {len(F):,}, since edges were long relative to the local thickness"
    )
    return PreprocessResult(Mesh(V, F, mesh.notes), VertexMap.identity(len(mesh.vertices)), (note,))


def coarse_faces(mesh: Mesh, max_edge_length: float) -> NDArray[np.bool_]:
    """(m,) whether each face has an edge that is long relative to the local thickness.

    Parameters
    ----------
    mesh : Mesh
    max_edge_length : float
        Length from which on an edge is long, as a fraction of the local thickness.
    """
    is_coarse: NDArray[np.bool_] = _length_ratios(mesh, max_edge_length).max(axis=1) > 1
    return is_coarse


def _edge_length_limits(mesh: Mesh, max_edge_length: float) -> NDArray[np.float64]:
    """(m,) longest admissible edge of each face, a fraction of the local thickness."""
    a, b, c = local_radii(mesh)[mesh.faces.T]
    limits: NDArray[np.float64] = 2 * max_edge_length * ((a + b + c) / 3)
    return limits


def _length_ratios(mesh: Mesh, max_edge_length: float) -> NDArray[np.float64]:
    """(m, 3) length of each edge of each face over its limit, in ascending order; 0 for faces without a limit."""
    key = f"length ratios {max_edge_length!r}"
    ratios: NDArray[np.float64] = Surface(mesh).memoize(key, lambda: _measure_ratios(mesh, max_edge_length))
    return ratios


def _measure_ratios(mesh: Mesh, max_edge_length: float) -> NDArray[np.float64]:
    """Measure the ratios of lengths and limits."""
    limits, (a, b, c) = (
        _edge_length_limits(mesh, max_edge_length),
        mesh.edge_lengths[mesh.edge_of_half_edge].reshape(3, -1),
    )
    low, high = np.minimum(a, b), np.maximum(a, b)
    ascending = np.stack([np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)], axis=1)
    none = np.zeros_like(ascending)
    return np.asarray(np.divide(ascending, limits[:, None], out=none, where=limits[:, None] > 0))


def _predicted_faces(ratios: NDArray[np.float64]) -> float:
    """Predict the number of faces when every edge that is too long is halved until it is not.

    A round divides a face into four where its three edges are too long, into three where two are, as in needles, whose
    parts keep the length of the longer ones, and into two where one is.
    """
    low, middle, high = np.ceil(np.log2(np.maximum(ratios, 1.0))).T
    return float((4.0**low * 3.0 ** (middle - low) * 2.0 ** (high - middle)).sum())


def _is_too_long(mesh: Mesh, limits: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(k,) whether each edge is longer than the limit of one of its faces."""
    edge, is_long = mesh.edge_of_half_edge, np.zeros(len(mesh.edges), dtype=bool)
    is_long[edge[mesh.edge_lengths[edge] > np.tile(limits, 3)]] = True
    return is_long


def _split_edges(
    mesh: Mesh, is_split_edge: NDArray[np.bool_], *, shorter: bool
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Split some edges at their midpoints; return vertices, faces, and the face that each came from.

    Parameters
    ----------
    mesh : Mesh
    is_split_edge : (k,) array of bool
    shorter : bool
        Whether the shorter diagonal is taken where two edges of a face are split, or one that does not depend on
        lengths. Without a bound on the faces, the latter makes some more; with the shorter ones, the skeletons of ten
        noisy copies of a coarse dinosaur had more false tips, which is not in a committed table.
    """
    m, n = len(mesh.faces), len(mesh.vertices)
    midpoint_of_edge = np.where(is_split_edge, n - 1 + np.cumsum(is_split_edge), -1)
    V = np.concatenate([mesh.vertices, mesh.vertices[mesh.edges[is_split_edge]].mean(axis=1)])
    midpoint = midpoint_of_edge[mesh.edge_of_half_edge].reshape(3, m).T  # opposite each corner
    is_split = midpoint >= 0
    count = is_split.sum(axis=1)
    faces, parents = [mesh.faces[count == 0]], [np.flatnonzero(count == 0)]
    for n_split in (1, 2, 3):
        rows = np.flatnonzero(count == n_split)
        # the first corner is opposite the only edge that is split, or that is not split
        first = is_split[rows].argmax(axis=1) if n_split == 1 else (~is_split[rows]).argmax(axis=1)
        rotation = (first[:, None] + np.arange(3)) % 3
        points = np.concatenate(
            [np.take_along_axis(mesh.faces[rows], rotation, 1), np.take_along_axis(midpoint[rows], rotation, 1)], axis=1
        )
        for is_used, patterns in _patterns(V, points, n_split, shorter):
            for pattern in patterns:
                faces.append(points[is_used][:, pattern])
                parents.append(rows[is_used])
    return V, np.concatenate(faces), np.concatenate(parents)


def _patterns(
    V: NDArray[np.float64], points: NDArray[np.int64], n_split: int, shorter: bool
) -> list[tuple[NDArray[np.bool_], list[list[int]]]]:
    """Choose the triangles of each face.

    Parameters
    ----------
    V : (n, 3) array of float
    points : (k, 6) array of int
        Corners of each face and midpoints of the edges opposite them.
    n_split : int
        Number of split edges.
    shorter : bool
        Whether to take the shorter diagonal where two edges are split.

    Returns
    -------
    list of tuple
        For each pattern whether each face has it, and its triangles.
    """
    if n_split != 2 or not shorter:
        return [(np.ones(len(points), dtype=bool), _PATTERNS[n_split])]
    one, other = (vector_lengths(V[points[:, i]] - V[points[:, j]]) for i, j in ((1, 4), (2, 5)))
    is_shorter = other < (1 - TIE) * one
    return [(~is_shorter, _PATTERNS[2]), (is_shorter, _OTHER_DIAGONAL)]


# Triangles for each number of split edges: corners are 0, 1, 2; midpoints of the edges opposite them are 3, 4, 5
_PATTERNS: dict[int, list[list[int]]] = {
    1: [[0, 1, 3], [0, 3, 2]],
    2: [[0, 5, 4], [5, 1, 4], [1, 2, 4]],
    3: [[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]],
}
_OTHER_DIAGONAL = [[0, 5, 4], [5, 1, 2], [5, 2, 4]]  # where two edges are split
