"""Tidying that loses nothing: vertices in one place become one, faces that say nothing new are left out."""

from __future__ import annotations

__all__ = ["components", "tidy"]

import numpy as np

from lbskel.mesh import Mesh
from lbskel.preprocess.merging import merge_close, remove_duplicates
from lbskel.preprocess.preprocessed import Preprocessed, unchanged


def tidy(mesh: Mesh) -> Preprocessed:
    """Merge vertices at the same place, leave out faces that are a copy or have no three corners, and unused vertices.

    Vertices are merged only where the mesh is not a closed manifold as it stands: what is one surface stays so.
    """
    if mesh.is_closed_manifold and len(mesh.used_vertices) == len(mesh.vertices) and len(mesh.faces) > 2:
        return unchanged(mesh)
    tidied = merge_close(mesh, tolerance=0.0).then(remove_duplicates)
    return tidied if tidied.notes else unchanged(mesh)


def components(mesh: Mesh) -> list[Preprocessed]:
    """Each connected component as a mesh of its own, in the order of ``mesh.component_of_vertex``."""
    if mesh.n_components == 1 and len(mesh.used_vertices) == len(mesh.vertices):
        return [unchanged(mesh)]
    label = mesh.component_of_vertex
    label_of_face = label[mesh.faces[:, 0]]
    parts = []
    for number in range(mesh.n_components):
        mine = np.flatnonzero(label == number)
        new_of = np.full(len(label), -1)
        new_of[mine] = np.arange(len(mine))
        parts.append(Preprocessed(Mesh(mesh.vertices[mine], new_of[mesh.faces[label_of_face == number]]), new_of))
    return parts
