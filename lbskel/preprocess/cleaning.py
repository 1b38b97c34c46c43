"""Vertices in one place become one, and what says nothing is left out: no geometry changes, the way is exact."""

from __future__ import annotations

__all__ = ["keep_components", "merge_close", "remove_duplicates", "tidy", "without_unused"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lbskel.errors import UnknownChoice, first_few
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, measured

MOST_PAIRS = 50  # near pairs for each place: beyond, the tolerance would swallow the mesh


@measured
def merge_close(mesh: Mesh, *, tolerance: float = 1e-6) -> PreprocessResult:
    """Make one vertex of those that lie within a tolerance of each other, as in a soup or along a seam.

    A closed manifold is given back: it has no seams, and where two of its sheets touch they must stay two.

    Parameters
    ----------
    mesh : Mesh
    tolerance : float
        As a fraction of the diagonal; 0 merges what lies at exactly the same place.

    Raises
    ------
    UnknownChoice
        If the tolerance is negative, or so large that it would merge most of the mesh.
    """
    if not tolerance >= 0:
        raise UnknownChoice(f"tolerance must not be negative, as {tolerance} is")
    if mesh.is_closed_manifold:
        return identity_result(mesh)
    _, first, place = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    place, group = place.reshape(-1), np.arange(len(first))
    if tolerance > 0 and mesh.diagonal > 0:
        group = _near(mesh.vertices[first], tolerance * mesh.diagonal)[1]
    return _merged(mesh, group[place])


def _near(points: NDArray[np.float64], reach: float) -> tuple[int, NDArray[np.int64]]:
    """Number and labels of the groups of points that are joined by steps within reach."""
    tree = cKDTree(points)
    if tree.count_neighbors(tree, reach) > (1 + 2 * MOST_PAIRS) * len(points):
        raise UnknownChoice("the tolerance would merge most of the mesh; make it smaller")
    pairs = tree.query_pairs(reach, output_type="ndarray")
    return connected_components(weighted_graph(pairs, np.ones(len(pairs), dtype=np.int8), len(points)))


def _merged(mesh: Mesh, group: NDArray[np.int64]) -> PreprocessResult:
    """The first vertex of each group, which all of its group become."""
    _, first, label = np.unique(group, return_index=True, return_inverse=True)
    to = first[label]
    used = mesh.used_vertices
    if not (n_merged := len(used) - len(np.unique(to[used]))):
        return identity_result(mesh)
    rank = np.cumsum(np.bincount(first, minlength=len(group)) > 0) - 1
    note = f"{n_merged} vertices at the place of another were merged with it"
    return PreprocessResult(
        Mesh(mesh.vertices[np.sort(first)], rank[to[mesh.faces]], mesh.notes), VertexMap(rank[to]), (note,)
    )


@measured
def remove_duplicates(mesh: Mesh) -> PreprocessResult:
    """Leave out faces that copy another, either way round, or name a vertex twice, and vertices that no face uses."""
    F, notes = mesh.faces, []
    has_corners = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    if not has_corners.all():
        bad = np.flatnonzero(~has_corners)
        notes.append(f"{len(bad)} faces with a corner twice were left out: {first_few(bad)}")
    F, face = F[has_corners], np.flatnonzero(has_corners)
    _, first = np.unique(np.sort(F, axis=1), axis=0, return_index=True)
    if len(first) < len(F):
        bad = np.setdiff1d(face, face[first])
        notes.append(f"{len(bad)} faces that copy another were left out: {first_few(bad)}")
    if len(mesh.used_vertices) < len(mesh.vertices):
        n_unused = len(mesh.vertices) - len(mesh.used_vertices)
        notes.append(f"{n_unused} vertices belong to no face and are mapped to the nearest node")
    if not notes or len(first) == 0:
        return identity_result(mesh)
    return without_unused(mesh, F[np.sort(first)], *notes)


def without_unused(mesh: Mesh, faces: NDArray[np.int64], *notes: str) -> PreprocessResult:
    """The mesh of some faces on the vertices of another, of which it keeps those that are used."""
    used = np.unique(faces)
    new_of = np.full(len(mesh.vertices), -1)
    new_of[used] = np.arange(len(used))
    return PreprocessResult(Mesh(mesh.vertices[used], new_of[faces], mesh.notes), VertexMap(new_of), notes)


@measured
def keep_components(mesh: Mesh, *, smallest: float = 0.01) -> PreprocessResult:
    """Leave out small components: crumbs of a scan, screws.

    Parameters
    ----------
    mesh : Mesh
    smallest : float
        Area below which a component is left out, as a fraction of the largest component's.

    Raises
    ------
    UnknownChoice
        If it is not within 0 and 1.
    """
    if not 0 <= smallest <= 1:
        raise UnknownChoice(f"smallest must lie within 0 and 1, not {smallest}")
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas = np.bincount(label, weights=mesh.face_areas)
    is_kept = areas >= smallest * areas.max()
    if is_kept.all():
        return identity_result(mesh)
    note = f"{np.sum(~is_kept)} components of less than {smallest:g} of the largest one's area were left out"
    return without_unused(mesh, mesh.faces[is_kept[label]], note)


def tidy(mesh: Mesh) -> PreprocessResult:
    """Merge vertices at the same place, leave out faces that are a copy or have no three corners, and unused vertices.

    Vertices are merged only where the mesh is not a closed manifold as it stands: what is one surface stays so.
    """
    if mesh.is_closed_manifold and len(mesh.used_vertices) == len(mesh.vertices) and len(mesh.faces) > 2:
        return identity_result(mesh)
    tidied = merge_close(mesh, tolerance=0.0).compose(remove_duplicates)
    return tidied if tidied.notes else identity_result(mesh)
