"""The connected components of a mesh, each as a mesh of its own."""

from __future__ import annotations

__all__ = [
    "MIN_FACES",
    "Component",
    "components",
    "find_crumbs",
    "find_inner",
    "find_twigs",
    "set_local_radii_of_components",
]

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, triangle_normals, vector_lengths
from lbskel.geometry.shape_diameter import RAY_OFFSET, local_radii, set_local_radii
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface

MIN_FACES = 4  # faces of the smallest surface that encloses a volume, a tetrahedron
MIN_SHARE = 0.002  # of the faces and of the area of the largest component: with less of both, one is a crumb. The
# neurons of benchmarks/neurons.py have 30 to 90 components of 4 to 20 faces beside the cell of 13,000; a guess

# Lower bounds on a twig that was cut off: its length over its width, which is 1 for a ball, and its radius over that of
# the shape where it is nearest. By hand, 14 ends cut off a vessel tree have at least 2.3 and 0.66, and of 333 crumbs of
# the neurons all but two are below 0.3 in the second
MIN_ELONGATION, MIN_THICKNESS = 2.0, 0.5
MIN_TWIG_FACES = 24  # of a tube of three sides and four rings, the coarsest that is told from a chip; a guess
# Share of the faces of a surface inside another from which it is its inner wall, whose caps may lie in those of the
# other, and number of faces that are tested, which bounds the time; guesses
MIN_INNER, N_TESTED = 0.9, 500
N_RAYS = 32  # vertices, the nearest to a twig, from which rays are cast: at an end, many go along the limb. A guess


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
    largest of any component and is no twig.

    Parameters
    ----------
    mesh : Mesh
    """
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    n_faces, areas = np.bincount(label), np.bincount(label, mesh.face_areas)
    is_negligible = (n_faces < MIN_SHARE * n_faces.max()) & (areas < MIN_SHARE * areas.max())
    is_nothing = (n_faces < MIN_FACES) | ~(areas > 0)
    is_crumb: NDArray[np.bool_] = is_nothing | (is_negligible & ~find_twigs(mesh, is_negligible & ~is_nothing))
    return is_crumb


def find_twigs(mesh: Mesh, is_small: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(c,) which of the small components are longer than twice their width, and half as thick as what is near or more.

    A tube of length l has the radius r = area / (2 pi l). What is near are the components that are not small; their
    radius is half of the shortest of some rays, to both sides, since they may not be oriented.

    Parameters
    ----------
    mesh : Mesh
    is_small : (c,) array of bool
    """
    is_twig = np.zeros(len(is_small), dtype=bool)
    if not is_small.any() or is_small.all():
        return is_twig
    used = mesh.used_vertices
    V, label = mesh.vertices[used], mesh.component_of_vertex[used]
    count = np.bincount(label)
    middles = np.stack([np.bincount(label, column) / count for column in V.T], axis=1)
    lengths = np.zeros(len(count))
    np.maximum.at(lengths, label, 2 * vector_lengths(V - middles[label]))
    of_face = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas, n_faces = np.bincount(of_face, mesh.face_areas), np.bincount(of_face)
    is_long = is_small & (n_faces >= MIN_TWIG_FACES) & (areas > 0) & (np.pi * lengths**2 > MIN_ELONGATION * areas)
    own, others = np.flatnonzero(is_long[label]), used[~is_small[label]]
    if not len(own):
        return is_twig
    tree = cKDTree(mesh.vertices[others])
    nearest_first = own[np.argsort(tree.query(V[own])[0], kind="stable")]
    touching = nearest_first[np.unique(label[nearest_first], return_index=True)[1]]  # one vertex of each
    near = others[tree.query(V[touching], k=[*range(1, min(N_RAYS, len(others)) + 1)])[1]]
    face_at = np.zeros(len(mesh.vertices), dtype=np.int64)
    face_at[mesh.faces] = np.arange(len(mesh.faces))[:, None]
    A, B, C = mesh.vertices[mesh.faces[face_at[near.ravel()]]].transpose(1, 0, 2)
    normals, offset = normalized(triangle_normals(A, B, C)), RAY_OFFSET * mesh.diameter_bound
    centers = (A + B + C) / 3
    depths = [Surface(mesh).ray_distance(centers + offset * way, way) for way in (normals, -normals)]
    radii = np.min(depths, axis=0).reshape(near.shape).min(axis=1) / 2
    number = label[touching]
    is_twig[number] = areas[number] / (2 * np.pi * lengths[number]) >= MIN_THICKNESS * radii
    return is_twig


def find_inner(meshes: Sequence[Mesh]) -> NDArray[np.bool_]:
    """(k,) whether each of some connected surfaces lies inside another that is closed.

    Parameters
    ----------
    meshes : sequence of Mesh
    """
    is_inner = np.zeros(len(meshes), dtype=bool)
    centers = [mesh.vertices[mesh.faces[:: 1 + len(mesh.faces) // N_TESTED]].mean(axis=1) for mesh in meshes]
    low, high = (np.array([extreme(mesh.vertices, axis=0) for mesh in meshes]) for extreme in (np.min, np.max))
    # a box that does not reach to these places on each side holds fewer than MIN_INNER of the centers
    inner_low, inner_high = np.transpose(
        [np.quantile(each, (1 - MIN_INNER, MIN_INNER), axis=0, method="nearest") for each in centers], (1, 0, 2)
    )
    for number, mesh in enumerate(meshes):
        is_within = ((inner_low >= low[number]) & (inner_high <= high[number])).all(axis=1)
        others = np.flatnonzero(is_within & (np.arange(len(meshes)) != number))
        if len(others) and mesh.is_closed:
            is_inside = Surface(mesh).contains(np.concatenate([centers[other] for other in others]))
            sizes = np.array([len(centers[other]) for other in others])
            n_inside = np.add.reduceat(is_inside.astype(np.int64), np.append(0, np.cumsum(sizes)[:-1]))
            is_inner[others] |= n_inside >= MIN_INNER * sizes
    return is_inner


def components(mesh: Mesh) -> Sequence[Component]:
    """Split a mesh into its connected components, in the order of ``mesh.component_of_vertex``; computed once per mesh.

    Parameters
    ----------
    mesh : Mesh
    """
    if mesh.n_components == 1 and len(mesh.used_vertices) == len(mesh.vertices):
        return (Component(mesh, mesh.used_vertices),)
    found: Sequence[Component] = Surface(mesh).memoize("components", lambda: _split(mesh))
    return found


def set_local_radii_of_components(mesh: Mesh, *, deadline: Deadline = NEVER) -> None:
    """Let :func:`local_radii` return those that each component has by itself; crumbs share theirs.

    Rays through one component may end at another, which its skeleton does not see.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    if mesh.n_components == 1:
        return
    is_crumb = find_crumbs(mesh)
    crumbs = mesh.faces[is_crumb[mesh.component_of_vertex[mesh.faces[:, 0]]]]
    radii = np.array(local_radii(Mesh(mesh.vertices, crumbs))) if len(crumbs) else np.zeros(len(mesh.vertices))
    for part in compress(components(mesh), ~is_crumb):
        radii[part.vertices] = local_radii(part.mesh, deadline=deadline)
    set_local_radii(mesh, radii)


def _split(mesh: Mesh) -> tuple[Component, ...]:
    n = mesh.n_components
    label = np.minimum(mesh.component_of_vertex, n)  # vertices that no face uses have label n
    vertices, faces = stable_order(label), stable_order(label[mesh.faces[:, 0]])
    ends = np.cumsum(np.bincount(label, minlength=n + 1))[:n]
    face_ends = np.cumsum(np.bincount(label[mesh.faces[:, 0]]))
    number = np.empty(len(label), dtype=np.int64)
    number[vertices] = np.arange(len(label)) - np.append(0, ends)[label[vertices]]
    return tuple(
        Component(Mesh(mesh.vertices[part], number[mesh.faces[part_faces]]), part)
        for part, part_faces in zip(np.split(vertices, ends)[:n], np.split(faces, face_ends)[:n], strict=True)
    )
