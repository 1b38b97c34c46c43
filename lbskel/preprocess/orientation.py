"""Consistent outward orientation of faces, and splitting of surfaces that meet in an edge or a vertex."""

from __future__ import annotations

__all__ = ["MIN_SHEET_VECTOR_AREA", "fix_orientation", "relative_vector_area", "split_nonmanifold"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step
from lbskel.preprocess.vertex_umbrellas import find_umbrellas

# Relative vector area above which a patch counts as a sheet, which encloses no volume: that of a hemisphere.
MIN_SHEET_VECTOR_AREA = 0.5


@preprocess_step
def fix_orientation(mesh: Mesh) -> PreprocessResult:
    """Orient adjacent faces consistently and closed surfaces outwards; cavity walls of a hollow body stay inwards.

    A non-orientable surface, as a Moebius strip, keeps a seam of edges whose faces have opposite orientation.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    """
    if mesh.is_closed_manifold and mesh.n_components == 1 and mesh.volume >= 0:
        return identity_result(mesh)
    F, patch = igl.bfs_orient(mesh.faces)
    # the first face of a patch keeps its orientation; a patch that was consistent has no reversed faces
    is_reversed = (mesh.faces != F).any(axis=1)
    A, B, C = mesh.vertices[F].transpose(1, 0, 2)
    normals = triangle_normals(A, B, C) / 2
    areas = np.linalg.norm(normals, axis=1)
    centers = (A + B + C) / 3
    patch_area = np.bincount(patch, areas)
    weighted = np.stack([np.bincount(patch, areas * x) for x in centers.T], axis=1)
    centroid = weighted / np.where(patch_area > 0, patch_area, 1.0)[:, None]
    volume = np.bincount(patch, np.einsum("mx,mx->m", centers - centroid[patch], normals))
    vector_area = np.stack([np.bincount(patch, x) for x in normals.T], axis=1)
    is_sheet = np.linalg.norm(vector_area, axis=1) > MIN_SHEET_VECTOR_AREA * patch_area
    was_mixed = np.bincount(patch, is_reversed) > 0
    is_wrong = np.where(is_sheet, np.bincount(patch, areas * is_reversed) > patch_area / 2, volume < 0)
    inward = np.flatnonzero(is_wrong & ~is_sheet & ~was_mixed)
    is_wrong[inward] = ~_are_inside(mesh, F, patch, inward)
    F[is_wrong[patch]] = F[is_wrong[patch]][:, [0, 2, 1]]
    n_reversed = int((is_reversed != is_wrong[patch]).sum())
    if not n_reversed:
        return identity_result(mesh)
    note = f"{n_reversed} faces were reversed"
    return PreprocessResult(Mesh(mesh.vertices, F, mesh.notes), VertexMap.identity(len(mesh.vertices)), (note,))


def _are_inside(
    mesh: Mesh, F: NDArray[np.int64], patch: NDArray[np.int64], numbers: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """(k,) whether patches lie inside the other faces, as the walls of cavities do."""
    if len(numbers) == 0:
        return np.empty(0, dtype=bool)
    first = np.array([np.flatnonzero(patch == number)[0] for number in numbers])
    points = mesh.vertices[F[first, 0]]
    own = [igl.winding_number(mesh.vertices, F[patch == k], p[None])[0] for k, p in zip(numbers, points, strict=True)]
    is_inside: NDArray[np.bool_] = np.abs(igl.winding_number(mesh.vertices, F, points) - own) > 0.5
    return is_inside


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
    note = f"{n_umbrellas - n} vertices were added where surfaces that meet in an edge or a vertex were split"
    return PreprocessResult(
        Mesh(mesh.vertices[origin], umbrellas.of_corner, mesh.notes), VertexMap.identity(n), (note,)
    )
