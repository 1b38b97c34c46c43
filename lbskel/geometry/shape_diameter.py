"""Local thickness of a shape at its faces: the shape diameter, the length of rays from a face through the inside.

Shapira, Shamir, Cohen-Or 2008, "Consistent mesh partitioning and skeletonization using the shape diameter function",
https://doi.org/10.1007/s00371-007-0197-5. Here it is the smaller of the length of one ray along the normal and the
median depth, measured along the normal, of a cone of rays (:func:`local_thickness`), or the first of these alone.
"""

from __future__ import annotations

__all__ = [
    "has_local_radii",
    "local_radii",
    "local_thickness",
    "set_local_radii",
    "thickness_along_normal",
]

import math

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from lbskel.geometry.arrays import read_only
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.graphs import shortest_paths, weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, row_dots, triangle_normals
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface

N_CONE_RAYS = 4  # rays on the cone around the normal; a guess
CONE_ANGLE = np.radians(30.0)  # between the rays of the cone and the normal; a guess
# Distance inside their face at which rays start, in diameter bounds, so that rounding lets none hit it; a share of the
# bounding box would change when the mesh is turned. Rows in benchmarks/results/constants.md change the error by less
# than a hundredth
RAY_OFFSET = 1e-5

# Lower bound on a local radius, in radii of the disk with the area of the triangles at the vertex: a thinner limb is
# not resolved by its triangles. By hand, with 0, 0.1, 0.25 and 0.5 the F-score of five neurons is 0.860, 0.881, 0.888
# and 0.888, and 5, 1, none and 3 of them fail; tubes and creatures are alike
MIN_RADIUS = 0.25


# Upper bound on the leaves of the search tree that a line through the mesh meets; where it meets more, rays are cast
# from a proportionally smaller number of faces. 2 to 5 for ordinary meshes, up to 50 for shapes of many parts, a
# thirtieth of the faces for a fan of needles, whose boxes nearly all overlap.
MAX_OVERLAP = 100.0
# Faces up to which a ray is cast from each: those that are contracted without a proxy.
# benchmarks/results/resolution.md
ALL_RAYS = 16_000
# Upper bound on the distance of the faces of larger meshes from which rays are cast: two of the six faces at a vertex,
# and eight of those around it.
# benchmarks/results/resolution.md, "Local radii by rays from every n-th face"
MAX_STRIDE = 3
# Lower bound on the cosine of the angle between a face and the mean normal of its vertices, by area, where its ray
# counts: noise turns the slivers of marching cubes until their rays run along the surface.
# benchmarks/results/resolution.md, "A noisy tube". By hand, 0.3 changes nothing on 137 shapes and 25 real meshes; with
# 0.5 tubes around tracings have 452 sections in place of 456 of 510, with 0.7 real meshes lose 4 of 220 tips
MIN_ALIGNMENT = 0.3
# Upper bound on the neighbors of a vertex whose faces count for those beside it, which bounds the memory.
# benchmarks/results/bounds.md: 8 to 64 are alike; with 4 slivers decide, without a bound the faces of a fan do
MAX_AROUND = 32
# Share of the area around a vertex by which its half may be missed: the areas of all vertices are summed, and 1e7 of
# them leave a rounding error of 1e-9 of one
TIE = 1e-6
NAME = "local radii"  # in the cache of a mesh


def local_radii(mesh: Mesh, *, deadline: Deadline = NEVER) -> NDArray[np.float64]:
    """(n,) radius of the shape at each vertex: half the thickness, made 1-Lipschitz along the edges.

    At a vertex it is the median over its faces, so that single rays that miss do not count; with rays from some of the
    faces only, over those of the adjacent vertices too, by area. A ray along an axis, from the end of a limb, is much
    longer than the limb is thick; so the radius at a vertex is at most that at any other plus their distance along the
    edges, as it is for the local feature size (Amenta, Bern 1999, https://doi.org/10.1007/PL00009475). In units of the
    mesh.

    Parameters
    ----------
    mesh : Mesh
        Oriented outwards, if it is open. Vertices without a face have radius 0.
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    radii: NDArray[np.float64] = Surface(mesh).memoize(NAME, lambda: read_only(_local_radii(mesh, deadline)))
    return radii


def set_local_radii(mesh: Mesh, radii: NDArray[np.float64]) -> None:
    """Let :func:`local_radii` return radii that are known, unless it has measured some.

    Parameters
    ----------
    mesh : Mesh
    radii : (n,) array of float
        Such as those of the same mesh with other numbers, in its order, or of a scaled copy, scaled.
    """
    Surface(mesh).memoize(NAME, lambda: read_only(radii))


def has_local_radii(mesh: Mesh) -> bool:
    """Whether :func:`local_radii` has measured those of a mesh, or knows them.

    Parameters
    ----------
    mesh : Mesh
    """
    return Surface(mesh).has(NAME)


def _faces_with_rays(mesh: Mesh) -> NDArray[np.int64]:
    """(k,) numbers of the faces from which rays are cast: every n-th, and one at each vertex that has none of these.

    The faces of a regular grid, such as a tube's, are numbered so that every third may leave out whole rows of
    vertices. Where a line meets too many boxes of the search tree, there are fewer, and vertices may have none. Rays of
    faces without area do not count.
    """
    m = len(mesh.faces)
    stride = int(np.clip(m // ALL_RAYS, 1, MAX_STRIDE))
    overlap = mesh.aabb_tree.overlap / MAX_OVERLAP
    if overlap > stride:
        return np.arange(0, m, math.ceil(overlap))
    has_ray, has_area = np.zeros(m, dtype=bool), mesh.face_areas > 0
    has_ray[::stride] = True
    face_at = np.full(len(mesh.vertices), -1)
    face_at[mesh.faces[has_area]] = np.flatnonzero(has_area)[:, None]
    face_at[mesh.faces[has_ray & has_area]] = -1
    has_ray[face_at[face_at >= 0]] = True
    return np.flatnonzero(has_ray)


def _local_radii(mesh: Mesh, deadline: Deadline) -> NDArray[np.float64]:
    n = len(mesh.vertices)
    measured = _faces_with_rays(mesh)
    has_all = len(measured) == len(mesh.faces)
    measured = measured[_are_aligned(mesh, measured) if has_all else mesh.face_areas[measured] > 0]
    thickness = thickness_along_normal(mesh, measured, deadline=deadline)
    radii = (_medians_at_vertices if has_all else _medians_around_vertices)(mesh, measured, thickness) / 2
    rings = np.bincount(mesh.faces.ravel(), weights=np.repeat(mesh.face_areas, 3), minlength=n)
    radii = np.clip(radii, MIN_RADIUS * np.sqrt(rings / np.pi), mesh.diameter_bound)
    graph = weighted_graph(np.concatenate([mesh.edges, mesh.edges[:, ::-1]]), np.tile(mesh.edge_lengths, 2), n)
    deadline.check()
    graded = shortest_paths(graph).least_sums(radii)
    return np.where(np.bincount(mesh.faces.ravel(), minlength=n) > 0, graded, 0.0)


def _are_aligned(mesh: Mesh, faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(k,) whether each face has an area and lies along the surface around it, where it has one."""
    if not mesh.is_edge_manifold:
        has_area: NDArray[np.bool_] = mesh.face_areas[faces] > 0
        return has_area
    at_vertices = np.nan_to_num(igl.per_vertex_normals(mesh.vertices, mesh.faces))
    around = normalized(at_vertices[mesh.faces[faces]].sum(axis=1))
    normals = normalized(triangle_normals(*mesh.vertices.take(mesh.faces[faces].T, axis=0)))
    return row_dots(normals, around) >= MIN_ALIGNMENT


def _medians_at_vertices(
    mesh: Mesh, measured: NDArray[np.int64], thickness: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n,) median thickness of the faces at each vertex, the lower of two; infinite without any."""
    n, F = len(mesh.vertices), mesh.faces[measured]
    ascending = np.argsort(thickness)
    faces = np.repeat(ascending, 3)[stable_order(F[ascending].ravel())]  # of each vertex, the thinnest first
    count = np.bincount(F.ravel(), minlength=n)
    middle = np.cumsum(count) - count + (count - 1) // 2
    return np.where(count > 0, np.append(thickness[faces], np.inf)[np.minimum(middle, len(faces))], np.inf)


def _medians_around_vertices(
    mesh: Mesh, measured: NDArray[np.int64], thickness: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n,) median thickness, by area, of the faces at each vertex and those adjacent to it; infinite without any.

    Where few faces have rays, two at a vertex have no median, and the slivers of a noisy surface have normals along it.
    The faces of a fan around a vertex do not count for the vertices of its rim.
    """
    n, k = len(mesh.vertices), len(measured)
    order = np.argsort(thickness)
    rank = np.empty(k, dtype=np.int64)
    rank[order] = np.arange(k)
    corners = mesh.faces[measured].ravel(), np.repeat(rank, 3)
    at_vertex = csr_array((np.ones(3 * k, dtype=np.int8), corners), shape=(n, k))
    n_neighbors = np.bincount(mesh.edges.ravel(), minlength=n)
    edges = mesh.edges[(n_neighbors[mesh.edges] <= MAX_AROUND).all(axis=1)]
    graph = weighted_graph(edges, np.ones(len(edges), dtype=np.int8), n)
    around = csr_array((graph + graph.T + eye_array(n, dtype=np.int8)) @ at_vertex)
    around.sort_indices()  # of each vertex, the thinnest first
    faces, first, last = order[around.indices], around.indptr[:-1], around.indptr[1:]
    area = np.append(0.0, np.cumsum(mesh.face_areas[measured][faces]))
    total = area[last] - area[first]
    middle = np.searchsorted(area[1:], area[first] + (0.5 - TIE) * total)
    return np.where(total > 0, np.append(thickness[faces], np.inf)[np.minimum(middle, len(faces))], np.inf)


def thickness_along_normal(mesh: Mesh, faces: NDArray[np.int64], *, deadline: Deadline = NEVER) -> NDArray[np.float64]:
    """(k,) length of the ray inwards along the normal from the center of each face; infinite where it hits nothing.

    Parameters
    ----------
    mesh : Mesh
        Oriented outwards, if it is open.
    faces : (k,) array of int
        Numbers of faces.
    deadline : Deadline
    """
    origins, inward, _ = _inward_rays(mesh, faces)
    return Surface(mesh, deadline=deadline).ray_distance(origins, inward)


def local_thickness(mesh: Mesh, faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) distance of the opposite surface from the center of each face; infinite where there is none.

    Parameters
    ----------
    mesh : Mesh
        Oriented outwards, if it is open.
    faces : (k,) array of int
        Numbers of faces; five rays are cast from each.
    """
    if len(faces) == 0:
        return np.empty(0)
    origins, inward, tangent = _inward_rays(mesh, faces)
    bitangent = np.cross(inward, tangent)
    depths = []
    for ray in range(N_CONE_RAYS):
        angle = 2 * np.pi * ray / N_CONE_RAYS
        sideways = np.cos(angle) * tangent + np.sin(angle) * bitangent
        length = Surface(mesh).ray_distance(origins, np.cos(CONE_ANGLE) * inward + np.sin(CONE_ANGLE) * sideways)
        depths.append(np.cos(CONE_ANGLE) * length)
    thickness = np.minimum(Surface(mesh).ray_distance(origins, inward), np.median(depths, axis=0))
    return np.where(inward.any(axis=1), thickness, np.inf)


def _inward_rays(
    mesh: Mesh, faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) points just inside the centers of faces, unit directions inwards, and unit directions along the faces."""
    A, B, C = mesh.vertices.take(mesh.faces[faces].T, axis=0)
    orientation = -1 if mesh.is_closed and mesh.volume < 0 else 1
    inward, tangent = -orientation * normalized(triangle_normals(A, B, C)), normalized(B - A)
    return (A + B + C) / 3 + RAY_OFFSET * mesh.diameter_bound * inward, inward, tangent
