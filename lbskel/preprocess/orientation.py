"""Consistent outward orientation of faces, and splitting of surfaces that meet in an edge or a vertex."""

from __future__ import annotations

__all__ = ["MIN_SHEET_VECTOR_AREA", "fix_orientation", "relative_vector_area", "split_nonmanifold"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.errors import were
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals, vector_lengths
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step
from lbskel.preprocess.vertex_umbrellas import find_umbrellas

# Relative vector area above which a patch counts as a sheet, which encloses no volume: that of a hemisphere.
MIN_SHEET_VECTOR_AREA = 0.5

# Share of the area of a surface on faces of either orientation from which it counts as mixed: how it faced is not
# known. A guess.
MIXED_SHARE = 0.25

N_PROBES = 8  # vertices of a surface, at most, that must all be inside another; a guess


@preprocess_step
def fix_orientation(mesh: Mesh) -> PreprocessResult:
    """Orient adjacent faces consistently and closed surfaces outwards; cavity walls of a hollow body stay inwards.

    Of two closed surfaces, one inside the other, the inner one is turned with the outer one, so that a hollow body that
    is inside out stays hollow. An inner surface of mixed orientation is taken for the wall of a cavity of the outer
    one. A non-orientable surface, as a Moebius strip, keeps a seam of edges whose faces have opposite orientation; if
    reorienting makes the seam no shorter, it keeps its orientation.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    """
    if mesh.is_closed_manifold and mesh.n_components == 1 and mesh.volume >= 0:
        return identity_result(mesh)
    F, patch = igl.bfs_orient(mesh.faces)
    # the first face of a patch keeps its orientation; a patch that was consistent has no reversed faces
    is_reversed = (mesh.faces != F).any(axis=1)
    is_kept = _seam_edges(mesh, patch, np.zeros_like(is_reversed)) <= _seam_edges(mesh, patch, is_reversed)
    F, is_reversed = np.where(is_kept[patch, None], mesh.faces, F), is_reversed & ~is_kept[patch]
    A, B, C = mesh.vertices.take(F.T, axis=0)
    normals = triangle_normals(A, B, C) / 2
    areas = vector_lengths(normals)
    centers = (A + B + C) / 3
    patch_area = np.bincount(patch, areas)
    positive_area = np.where(patch_area > 0, patch_area, 1.0)
    weighted = np.stack([np.bincount(patch, areas * x) for x in centers.T], axis=1)
    centroid = weighted / positive_area[:, None]
    volume = np.bincount(patch, np.einsum("mx,mx->m", centers - centroid[patch], normals))
    vector_area = np.stack([np.bincount(patch, x) for x in normals.T], axis=1)
    is_sheet = np.linalg.norm(vector_area, axis=1) > MIN_SHEET_VECTOR_AREA * patch_area
    is_wrong = np.where(is_sheet, np.bincount(patch, areas * is_reversed) > patch_area / 2, volume < 0)
    solids = np.flatnonzero(~is_sheet & (volume != 0))
    inward = np.bincount(patch, areas * (is_reversed != is_wrong[patch])) / positive_area
    if len(solids) > 1 and inward[solids].any():
        was = np.where(inward < MIXED_SHARE, 1, np.where(inward > 1 - MIXED_SHARE, -1, 0))
        is_wrong ^= _sides(mesh, np.where(is_wrong[patch, None], F[:, ::-1], F), patch, solids, np.abs(volume), was) < 0
    F[is_wrong[patch]] = F[is_wrong[patch]][:, [0, 2, 1]]
    n_reversed = int((is_reversed != is_wrong[patch]).sum())
    if not n_reversed:
        return identity_result(mesh)
    note = f"{were(n_reversed, 'face')} reversed"
    return PreprocessResult(Mesh(mesh.vertices, F, mesh.notes), VertexMap.identity(len(mesh.vertices)), (note,))


def _seam_edges(mesh: Mesh, patch: NDArray[np.int64], is_reversed: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(p,) edges of each patch whose two faces have opposite orientation after some of the faces are reversed."""
    start, end = mesh.half_edges.T
    direction = np.where((start < end) ^ np.tile(is_reversed, 3), 1, -1)
    balance = np.bincount(mesh.edge_of_half_edge, direction)
    of_edge = np.zeros(len(balance), dtype=np.int64)
    of_edge[mesh.edge_of_half_edge] = np.tile(patch, 3)
    is_seam = (mesh.faces_per_edge == 2) & (balance != 0)
    return np.bincount(of_edge[is_seam], minlength=int(patch.max()) + 1)


def _sides(
    mesh: Mesh,
    F: NDArray[np.int64],
    patch: NDArray[np.int64],
    solids: NDArray[np.int64],
    volume: NDArray[np.float64],
    was: NDArray[np.int64],
) -> NDArray[np.int64]:
    """(p,) 1 for a patch that is to face outwards, -1 for the wall of a cavity.

    F are the faces with every patch outwards, ``solids`` the numbers of patches that enclose a volume, and ``was`` is 1
    for those that faced outwards, -1 for those that faced inwards and 0 for mixed ones.
    """
    sides = np.ones(len(volume), dtype=np.int64)
    container = _containers(mesh, F, patch, solids, volume)
    for number in solids[np.argsort(-volume[solids], kind="stable")].tolist():  # from the outside
        if (outer := int(container[number])) >= 0:
            if was[number] == 0:
                sides[number] = -sides[outer]
            else:
                sides[number] = was[number] * (sides[outer] * was[outer] if was[outer] else 1)
    return sides


def _containers(
    mesh: Mesh, F: NDArray[np.int64], patch: NDArray[np.int64], solids: NDArray[np.int64], volume: NDArray[np.float64]
) -> NDArray[np.int64]:
    """(p,) number of the smallest of the solid patches that each of them lies inside; -1 for none."""
    V = (mesh.vertices - mesh.vertices[F[0, 0]]) / mesh.diagonal
    faces = np.split(F[stable_order(patch)], np.cumsum(np.bincount(patch))[:-1])
    low, high = np.full((len(volume), 3), np.inf), np.full((len(volume), 3), -np.inf)
    for number in solids.tolist():
        corners = V[faces[number].ravel()]
        low[number], high[number] = corners.min(axis=0), corners.max(axis=0)
    along_x = solids[np.argsort(low[solids, 0], kind="stable")]  # so that few boxes are compared with each other
    container = np.full(len(volume), -1)
    for outer in solids[np.argsort(-volume[solids], kind="stable")].tolist():
        first, last = np.searchsorted(low[along_x, 0], [low[outer, 0], high[outer, 0]])
        near = along_x[first:last]
        near = near[(high[near, 0] < high[outer, 0]) & (low[near, 0] > low[outer, 0])]
        fits = (low[near, 1:] > low[outer, 1:]).all(axis=1) & (high[near, 1:] < high[outer, 1:]).all(axis=1)
        candidates = near[fits].tolist()
        if not candidates:
            continue
        corners = [faces[number].ravel() for number in candidates]
        probes = [each[:: 1 + (len(each) - 1) // N_PROBES] for each in corners]
        winding = igl.fast_winding_number(V, faces[outer], V[np.concatenate(probes)])
        starts = np.cumsum([0, *(len(each) for each in probes[:-1])])
        is_inside = np.logical_and.reduceat(winding > 0.5, starts)
        container[np.array(candidates)[is_inside]] = outer
    return container


def relative_vector_area(mesh: Mesh) -> float:
    """Length of the sum of the face area vectors over the area: 0 if closed, 1/2 for a hemisphere, 1 for a flat sheet.

    An open tube has 0 too. A mesh without area has 1.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented.
    """
    normals = triangle_normals(*mesh.vertices[mesh.faces].transpose(1, 0, 2))
    return float(np.linalg.norm(normals.sum(axis=0)) / 2 / mesh.area) if mesh.area > 0 else 1.0


@preprocess_step
def split_nonmanifold(mesh: Mesh) -> PreprocessResult:
    """Split surfaces that meet in an edge or a vertex, by giving each umbrella of faces a vertex of its own.

    No vertex moves; each is mapped to the vertex of its first umbrella.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    """
    umbrellas = find_umbrellas(mesh)
    n, n_umbrellas = len(mesh.vertices), max(len(mesh.vertices), int(umbrellas.of_corner.max()) + 1)
    if n_umbrellas == n:
        return identity_result(mesh)
    origin = np.arange(n_umbrellas)
    origin[umbrellas.of_corner] = mesh.faces
    note = f"{were(n_umbrellas - n, 'vertex')} added where surfaces that meet in an edge or a vertex were split"
    return PreprocessResult(
        Mesh(mesh.vertices[origin], umbrellas.of_corner, mesh.notes), VertexMap.identity(n), (note,)
    )
