"""The connected components of a mesh, each as a mesh of its own."""

from __future__ import annotations

__all__ = ["MIN_FACES", "Component", "components", "find_crumbs"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order

MIN_FACES = 4  # faces of the smallest surface that encloses a volume, a tetrahedron
MIN_SHARE = 0.002  # of the faces and of the area of the largest component: with less of both, one is a crumb. The
# neurons of benchmarks/neurons.py have 30 to 90 components of 4 to 20 faces beside the cell of 13,000; a guess


@dataclass(frozen=True, eq=False)
class Component:
    """A connected component of a mesh.

    Parameters
    ----------
    mesh : Mesh
        The component as a mesh of its own.
    vertices : (k,) array of int
        For each vertex of ``mesh``, the vertex of the whole mesh, in ascending order.
    """

    mesh: Mesh
    vertices: NDArray[np.int64]


def find_crumbs(mesh: Mesh) -> NDArray[np.bool_]:
    """(c,) whether each component is too small for a skeleton of its own.

    It is if it has too few faces to enclose a volume, or no area, or a negligible number of faces and area beside the
    largest of any component.

    Parameters
    ----------
    mesh : Mesh
    """
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    n_faces, areas = np.bincount(label), np.bincount(label, mesh.face_areas)
    is_negligible = (n_faces < MIN_SHARE * n_faces.max()) & (areas < MIN_SHARE * areas.max())
    is_crumb: NDArray[np.bool_] = (n_faces < MIN_FACES) | ~(areas > 0) | is_negligible
    return is_crumb


def components(mesh: Mesh) -> list[Component]:
    """Split a mesh into its connected components, in the order of ``mesh.component_of_vertex``.

    Parameters
    ----------
    mesh : Mesh
    """
    if mesh.n_components == 1 and len(mesh.used_vertices) == len(mesh.vertices):
        return [Component(mesh, mesh.used_vertices)]
    n = mesh.n_components
    label = np.minimum(mesh.component_of_vertex, n)  # vertices that no face uses have label n
    vertices, faces = stable_order(label), stable_order(label[mesh.faces[:, 0]])
    ends = np.cumsum(np.bincount(label, minlength=n + 1))[:n]
    face_ends = np.cumsum(np.bincount(label[mesh.faces[:, 0]]))
    number = np.empty(len(label), dtype=np.int64)
    number[vertices] = np.arange(len(label)) - np.append(0, ends)[label[vertices]]
    return [
        Component(Mesh(mesh.vertices[part], number[mesh.faces[part_faces]]), part)
        for part, part_faces in zip(np.split(vertices, ends)[:n], np.split(faces, face_ends)[:n], strict=True)
    ]
