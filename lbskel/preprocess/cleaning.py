"""Removal of redundant vertices and faces: duplicates, unused vertices, small components.

The vertices that remain do not move, so the vertex map is exact.
"""

from __future__ import annotations

__all__ = ["clean", "extract_faces", "keep_components", "merge_close", "merge_seams", "remove_duplicates"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lbskel.errors import UnknownChoice, first_few, were
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import distinct, first_of_each
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step

# Upper bound on the pairs within the tolerance, per position: with more, merging would destroy the mesh. A guess.
MAX_PAIRS_PER_POSITION = 50

# Upper bounds on the distance of vertices that are merged by default: the tolerance of merge_close, and a fraction of
# the median edge length, which a stray face far away does not change. The second is a guess.
TOLERANCE = 1e-6
MAX_EDGE_FRACTION = 0.01


@preprocess_step
def merge_close(mesh: Mesh, *, tolerance: float = TOLERANCE) -> PreprocessResult:
    """Merge vertices that lie within a tolerance of each other, as in a triangle soup or along a seam.

    Of a closed manifold only components that are copies of another, at the same place, are merged with it, so that
    :func:`remove_duplicates` removes their faces: it has no seams, and sheets of it that touch must stay separate.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    tolerance : float
        Largest distance, as a fraction of the diameter bound; 0 merges identical positions only. A chain of vertices,
        each within this distance of the next, is merged into one.

    Raises
    ------
    UnknownChoice
        If the tolerance is negative, or so large that it would merge most of the mesh.
    """
    if not tolerance >= 0:
        raise UnknownChoice(f"tolerance must not be negative, as {tolerance} is")
    if mesh.is_closed_manifold:
        return _merge_groups(mesh, _originals(mesh))
    _, first, position = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    position, group = position.reshape(-1), np.arange(len(first))
    if tolerance > 0 and mesh.diameter_bound > 0:
        group = _group_within(mesh.vertices[first], tolerance * mesh.diameter_bound)
    return _merge_groups(mesh, group[position])


def merge_seams(mesh: Mesh) -> PreprocessResult:
    """Merge vertices as :func:`merge_close` does by default, but none farther apart than 0.01 of the median edge.

    A mesh is left unchanged, with a note, if most of it would be merged even so.

    Parameters
    ----------
    mesh : Mesh
    """
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    edge = float(np.median(vector_lengths(end - start)))
    try:
        return merge_close(mesh, tolerance=min(TOLERANCE, MAX_EDGE_FRACTION * edge / (mesh.diameter_bound or 1.0)))
    except UnknownChoice:
        return identity_result(mesh, "vertices that are close were not merged, since that would merge most of the mesh")


def _originals(mesh: Mesh) -> NDArray[np.int64]:
    """(n,) for each vertex of a component that is a copy of one before it, the vertex there; for others themselves."""
    original = np.arange(len(mesh.vertices))
    if mesh.n_components == 1:
        return original
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    n_faces = np.bincount(label)
    is_alike = (np.bincount(n_faces) > 1)[n_faces][label]  # where another component has as many faces
    F, label = mesh.faces[is_alike], label[is_alike]
    if not len(F):
        return original
    used = distinct(F.ravel())
    place = np.zeros(len(mesh.vertices), dtype=np.int64)
    place[used] = np.unique(mesh.vertices[used], axis=0, return_inverse=True)[1].reshape(-1)
    face = np.unique(np.sort(place[F], axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    lowest = np.full(int(face.max()) + 1, len(n_faces))
    np.minimum.at(lowest, face, label)
    first, last = np.full(len(n_faces), len(n_faces)), np.full(len(n_faces), -1)  # components that have its faces
    np.minimum.at(first, label, lowest[face])
    np.maximum.at(last, label, lowest[face])
    is_copy = (first == last) & (first < np.arange(len(n_faces)))
    component = mesh.component_of_vertex[used]
    is_original = np.bincount(first[is_copy], minlength=len(n_faces)) > 0
    own, copies = used[is_original[component]], used[is_copy[component]]
    # where a component touches itself, which vertex is meant is not known
    keys, at, counts = np.unique(
        mesh.component_of_vertex[own] * len(mesh.vertices) + place[own], return_index=True, return_counts=True
    )
    touches = np.bincount(mesh.component_of_vertex[own[at]], counts > 1, len(n_faces)) > 0
    of_copy = first[mesh.component_of_vertex[copies]]
    copies, of_copy = copies[~touches[of_copy]], of_copy[~touches[of_copy]]
    original[copies] = own[at[np.searchsorted(keys, of_copy * len(mesh.vertices) + place[copies])]]
    return original


def _group_within(points: NDArray[np.float64], distance: float) -> NDArray[np.int64]:
    """(k,) group of each point; points connected by a chain of steps within the distance share one."""
    tree = cKDTree(points)
    if tree.count_neighbors(tree, distance) > (1 + 2 * MAX_PAIRS_PER_POSITION) * len(points):
        raise UnknownChoice("the tolerance would merge most of the mesh; make it smaller")
    pairs = tree.query_pairs(distance, output_type="ndarray")
    graph = weighted_graph(pairs, np.ones(len(pairs), dtype=np.int8), len(points))
    groups: NDArray[np.int64] = connected_components(graph)[1]
    return groups


def _merge_groups(mesh: Mesh, group: NDArray[np.int64]) -> PreprocessResult:
    """Replace all vertices of a group by the first of them."""
    _, first, label = np.unique(group, return_index=True, return_inverse=True)
    representative = first[label]
    used = mesh.used_vertices
    if not (n_merged := len(used) - len(distinct(representative[used]))):
        return identity_result(mesh)
    rank = np.cumsum(np.bincount(first, minlength=len(group)) > 0) - 1
    note = f"{were(n_merged, 'vertex')} merged with another at the same position"
    return PreprocessResult(
        Mesh(mesh.vertices[np.sort(first)], rank[representative[mesh.faces]], mesh.notes),
        VertexMap(rank[representative]),
        (note,),
    )


@preprocess_step
def remove_duplicates(mesh: Mesh) -> PreprocessResult:
    """Remove duplicate faces of either orientation, faces that name a vertex twice, and vertices without a face.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    """
    F, notes = mesh.faces, []
    is_distinct = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    if not is_distinct.all():
        removed = np.flatnonzero(~is_distinct)
        notes.append(f"{were(len(removed), 'face')} removed for naming a vertex twice: {first_few(removed)}")
    F, face = F[is_distinct], np.flatnonzero(is_distinct)
    first = first_of_each(np.sort(F, axis=1))
    if len(first) < len(F):
        removed = np.setdiff1d(face, face[first])
        notes.append(f"{were(len(removed), 'duplicate face')} removed: {first_few(removed)}")
    if len(mesh.used_vertices) < len(mesh.vertices):
        n_unused = len(mesh.vertices) - len(mesh.used_vertices)
        notes.append(f"{were(n_unused, 'vertex')} removed for being in no face")
    if not notes or len(first) == 0:
        return identity_result(mesh)
    return extract_faces(mesh, F[first], *notes)


def extract_faces(mesh: Mesh, faces: NDArray[np.int64], *notes: str) -> PreprocessResult:
    """Make a mesh of some faces and of the vertices that they use.

    Parameters
    ----------
    mesh : Mesh
    faces : (k, 3) array of int
        Vertices of ``mesh``; the faces need not be faces of it.
    notes : str
        What was done, a sentence each.
    """
    used = distinct(faces.ravel())
    new_of = np.full(len(mesh.vertices), -1)
    new_of[used] = np.arange(len(used))
    return PreprocessResult(Mesh(mesh.vertices[used], new_of[faces], mesh.notes), VertexMap(new_of), notes)


@preprocess_step
def keep_components(mesh: Mesh, *, min_area: float = 0.01) -> PreprocessResult:
    """Remove small components, such as debris of a scan or screws of a machine.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    min_area : float
        Area below which a component is removed, as a fraction of the largest component's area.

    Raises
    ------
    UnknownChoice
        If the fraction is not between 0 and 1.
    """
    if not 0 <= min_area <= 1:
        raise UnknownChoice(f"min_area must lie between 0 and 1, not {min_area}")
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas = np.bincount(label, weights=mesh.face_areas)
    is_kept = areas >= min_area * areas.max()
    if is_kept.all():
        return identity_result(mesh)
    note = f"{were(np.sum(~is_kept), 'component')} removed as smaller than {min_area:g} of the largest one's area"
    return extract_faces(mesh, mesh.faces[is_kept[label]], note)


def clean(mesh: Any) -> PreprocessResult:
    """Merge vertices of identical position, and remove duplicate faces, collapsed faces and unused vertices.

    Vertices of a closed manifold are merged only where a whole component is a copy of another, so that one surface is
    not joined to itself where it touches itself.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    """
    mesh = as_mesh(mesh)
    is_whole = mesh.is_closed_manifold and len(mesh.used_vertices) == len(mesh.vertices) and len(mesh.faces) > 2
    if is_whole and mesh.n_components == 1:
        return identity_result(mesh)
    result = merge_close(mesh, tolerance=0.0).compose(remove_duplicates)
    return result if result.notes else identity_result(mesh)
