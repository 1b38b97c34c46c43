"""All faces the same way round, outwards; and surfaces that meet in an edge or a vertex taken apart there."""

from __future__ import annotations

__all__ = ["fix_orientation", "relative_vector_area", "split_nonmanifold"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, measured
from lbskel.preprocess.vertex_umbrellas import fans_of

SHEET = 0.5  # openness of a half sphere: beyond, a patch has no inside to speak of


@measured
def fix_orientation(mesh: Mesh) -> PreprocessResult:
    """Turn faces so that neighbors agree and closed surfaces face outwards; inner walls of a hollow body face inwards.

    A surface with one side, as a Moebius strip, keeps a seam at which neighbors disagree.
    """
    if mesh.is_closed_manifold and mesh.n_components == 1 and mesh.volume >= 0:
        return identity_result(mesh)
    F, patch = igl.bfs_orient(mesh.faces)
    # the patch starts at a face that stays as it is; where all agreed, none has been turned
    turned = (mesh.faces != F).any(axis=1)
    A, B, C = mesh.vertices[F].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A) / 2
    areas = np.linalg.norm(normals, axis=1)
    centers = (A + B + C) / 3
    total = np.bincount(patch, areas)
    weighted = np.stack([np.bincount(patch, areas * x) for x in centers.T], axis=1)
    middle = weighted / np.where(total > 0, total, 1.0)[:, None]
    volume = np.bincount(patch, np.einsum("mx,mx->m", centers - middle[patch], normals))
    vector = np.stack([np.bincount(patch, x) for x in normals.T], axis=1)
    is_sheet = np.linalg.norm(vector, axis=1) > SHEET * total
    was_mixed = np.bincount(patch, turned) > 0
    is_wrong = np.where(is_sheet, np.bincount(patch, areas * turned) > total / 2, volume < 0)
    for number in np.flatnonzero(is_wrong & ~is_sheet & ~was_mixed):
        is_wrong[number] = not _is_inside(mesh, F, patch == number)
    F[is_wrong[patch]] = F[is_wrong[patch]][:, [0, 2, 1]]
    n_turned = int((turned != is_wrong[patch]).sum())
    if not n_turned:
        return identity_result(mesh)
    turned_mesh = Mesh(mesh.vertices, F, mesh.notes)
    return PreprocessResult(
        turned_mesh, VertexMap.identity(len(mesh.vertices)), (f"{n_turned} faces were turned round",)
    )


def _is_inside(mesh: Mesh, F: NDArray[np.int64], patch: NDArray[np.bool_]) -> bool:
    """Whether the faces of a patch lie inside of the rest, as the wall of a hollow does."""
    others = np.ascontiguousarray(F[~patch])
    if len(others) == 0:
        return False
    point = mesh.vertices[F[patch][:1, 0]]
    return bool(np.abs(igl.winding_number(mesh.vertices, others, point))[0] > 0.5)


def relative_vector_area(mesh: Mesh) -> float:
    """How far a surface is from enclosing something: 0 if it is closed or a tube, 1/2 for half a sphere, 1 for a sheet.

    The length of the sum of all normals, weighted by area, over the area.
    """
    A, B, C = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(B - A, C - A).sum(axis=0)) / 2 / mesh.area) if mesh.area > 0 else 1.0


@measured
def split_nonmanifold(mesh: Mesh) -> PreprocessResult:
    """Give each fan of faces a vertex of its own, so that surfaces which meet in an edge or a vertex come apart there.

    Nothing moves, and each vertex is mapped to the one of its first fan.
    """
    fans = fans_of(mesh)
    n, n_fans = len(mesh.vertices), max(len(mesh.vertices), int(fans.of_corner.max()) + 1)
    if n_fans == n:
        return identity_result(mesh)
    origin = np.arange(n_fans)
    origin[fans.of_corner] = mesh.faces
    note = f"{n_fans - n} vertices were added where surfaces that meet in an edge or a vertex were taken apart"
    return PreprocessResult(Mesh(mesh.vertices[origin], fans.of_corner, mesh.notes), VertexMap.identity(n), (note,))
