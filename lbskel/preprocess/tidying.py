"""Tidying that loses nothing: vertices in one place become one, faces that say nothing new are left out.

Every step keeps the way from the vertices of its input to those of its result.
"""

from __future__ import annotations

__all__ = ["Preprocessed", "components", "tidy"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.mesh import Mesh, first_few


@dataclass(frozen=True, eq=False)
class Preprocessed:
    """A mesh and where the vertices of the one before it went.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : (n,) array of int
        For each vertex of the input, its vertex in ``mesh``; -1 where it has none.
    notes : tuple of str
        What was done, a sentence each.
    """

    mesh: Mesh
    vertex_map: NDArray[np.int64]
    notes: tuple[str, ...] = ()


def tidy(mesh: Mesh) -> Preprocessed:
    """Merge vertices at the same place, leave out faces that are a copy or have no three corners, and unused vertices.

    Vertices are merged only where the mesh is not a closed manifold as it stands: what is one surface stays so.
    """
    n = len(mesh.vertices)
    notes = []
    to_place = np.arange(n)
    if not mesh.is_closed_manifold:
        _, first, group = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
        to_place = first[group.reshape(-1)]
        used = mesh.used_vertices
        if n_merged := len(used) - len(np.unique(to_place[used])):
            notes.append(f"{n_merged} vertices at the place of another were merged with it")
    F = to_place[mesh.faces]
    has_corners = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    if not has_corners.all():
        bad = np.flatnonzero(~has_corners)
        notes.append(f"{len(bad)} faces with a corner twice were left out: {first_few(bad)}")
    F, face = F[has_corners], np.flatnonzero(has_corners)
    _, first = np.unique(np.sort(F, axis=1), axis=0, return_index=True)
    if len(first) < len(F):
        bad = np.setdiff1d(face, face[first])
        notes.append(f"{len(bad)} faces that copy another were left out: {first_few(bad)}")
    F = F[np.sort(first)]
    used = np.unique(F)
    if n_unused := n - len(mesh.used_vertices):
        notes.append(f"{n_unused} vertices belong to no face and are mapped to the nearest node")
    if not notes or len(F) == 0:
        return Preprocessed(mesh, np.arange(n))
    new_of = np.full(n, -1)
    new_of[used] = np.arange(len(used))
    return Preprocessed(Mesh(mesh.vertices[used], new_of[F], mesh.notes), new_of[to_place], tuple(notes))


def components(mesh: Mesh) -> list[Preprocessed]:
    """Each connected component as a mesh of its own, in the order of ``mesh.component_of_vertex``."""
    if mesh.n_components == 1 and len(mesh.used_vertices) == len(mesh.vertices):
        return [Preprocessed(mesh, np.arange(len(mesh.vertices)))]
    label = mesh.component_of_vertex
    label_of_face = label[mesh.faces[:, 0]]
    parts = []
    for number in range(mesh.n_components):
        mine = np.flatnonzero(label == number)
        new_of = np.full(len(label), -1)
        new_of[mine] = np.arange(len(mine))
        parts.append(Preprocessed(Mesh(mesh.vertices[mine], new_of[mesh.faces[label_of_face == number]]), new_of))
    return parts
