"""The surface that a skeleton is made from, with the vertices and faces of the caller's mesh: merged and oriented.

What is measured by normals, sections or volumes needs the surface of preprocessing, and is told by the caller's
vertices and faces. Here nothing is removed, closed or moved, so that their numbers stay.
"""

from __future__ import annotations

__all__ = ["oriented_surface"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.cleaning import first_of_each, merge_close
from lbskel.preprocess.orientation import fix_orientation

TOLERANCES = (0.0, 1e-6)  # of merging, in diameter bounds: those of lbskel.preprocess.automatic


def oriented_surface(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64]]:
    """Return the faces of a mesh, oriented outwards and connected where vertices merge, and which vertices do.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    surface : Mesh
        As many vertices and faces, in the order of the mesh; the mesh itself if nothing is to be done. Faces that
        duplicate another, or would name a vertex twice, keep their own vertices.
    representative : (n,) array of int
        The vertex of the surface in place of each vertex.
    """
    surface, representative = mesh, np.arange(len(mesh.vertices))
    for tolerance in TOLERANCES:
        if surface.is_closed_manifold:
            break
        place = merge_close(surface, tolerance=tolerance).vertex_map.indices
        merged = np.unique(place, return_index=True)[1][place][representative]
        if not np.array_equal(merged, representative):
            representative = merged
            surface = Mesh(mesh.vertices, _connected(mesh.faces, representative))
    return fix_orientation(surface).mesh, representative


def _connected(faces: NDArray[np.int64], representative: NDArray[np.int64]) -> NDArray[np.int64]:
    """(m, 3) faces between the representatives of their vertices, where that leaves a triangle of their own."""
    F = representative[faces]
    is_own = np.zeros(len(F), dtype=bool)
    is_own[first_of_each(np.sort(F, axis=1))] = True
    is_own &= (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    return np.where(is_own[:, None], F, faces)
