"""Tunnel loops of a closed surface: an integer cochain that tells them from loops that bound in the solid.

A loop on a closed surface of genus g bounds inside the solid if and only if it is linked with no loop just outside the
surface. ``tunnel_cochain`` gives every edge a vector of g integers. Their sum around every face is zero, and their sum
along any loop is its linking numbers with g outer loops: zero for a loop around a limb, not zero for one around a
tunnel.

A basis of loops comes from a spanning tree of the vertices and a spanning tree of the faces that crosses none of its
edges (Erickson, Whittlesey 2005, "Greedy optimal homotopy and homology generators", SODA). Linking numbers are Gauss
integrals in closed form over pairs of segments, each as two solid angles (van Oosterom, Strackee 1983,
https://doi.org/10.1109/TBME.1983.325207).
"""

from __future__ import annotations

__all__ = ["transfer_cochain", "tunnel_cochain"]

from collections.abc import Iterator

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.vertex_map import VertexMap

# outward shifts of a loop, relative to the shortest edge at a vertex, tried in turn until the linking numbers are
# consistent; a guess
LOOP_OFFSETS = (1e-2, 1e-3, 1e-1)
SMOOTHING_ROUNDS = (0, 3, 10, 30)  # smoothed copies to try; measured on tori with noise up to two edge lengths
MAX_FOLD_COSINE = -0.2  # an edge is folded if the normals of its faces have a smaller cosine; a guess
# fraction of folded edges above which a surface may intersect itself; measured below 0.002 on clean surfaces, above
# 0.04 on surfaces that intersect themselves
MAX_FOLDED_FRACTION = 0.02
MAX_LINKING_ERROR = 1e-3  # distance of a linking number from an integer, above which the loops touch; a guess


def tunnel_cochain(mesh: Mesh) -> NDArray[np.int64] | None:
    """Compute an integer vector for each edge that sums to the linking numbers of loops and to zero around faces.

    A surface with many folded edges, as noise leaves it, may intersect itself. Then smoothed copies are evaluated too,
    and the answer is taken that two of them agree on.

    Parameters
    ----------
    mesh : Mesh
        One closed manifold component.

    Returns
    -------
    (k, g) array of int or None
        For each of ``mesh.edges``, from the smaller to the larger vertex. None if the linking numbers of neither the
        surface nor its smoothed copies are those of an embedded surface.
    """
    if mesh.genus == 0:
        return np.zeros((len(mesh.edges), 0), dtype=np.int64)
    generators, tree, cotree_levels = _tree_and_cotree(mesh)
    loops = [_loop_through(mesh.edges[edge], tree) for edge in generators]
    found: list[NDArray[np.int64]] = []
    for smoothed in _smoothed_copies(mesh):
        values = _values_on_loops(loops, smoothed)
        if values is None:
            continue
        is_confirmed = any(np.linalg.matrix_rank(np.hstack([values, other])) == values.shape[1] for other in found)
        found.append(values)
        if is_confirmed or not _has_folds(mesh):
            break
    return _extend(mesh, generators, found[-1], cotree_levels) if found else None


def _smoothed_copies(mesh: Mesh) -> Iterator[Mesh]:
    """Yield the mesh, then copies with each vertex moved half way to the mean of its neighbors, ever more times."""
    n = len(mesh.vertices)
    i, j = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
    degrees = np.maximum(graph.sum(axis=1), 1)[:, None]
    vertices, done = mesh.vertices, 0
    for rounds in SMOOTHING_ROUNDS:
        for _ in range(rounds - done):
            vertices = (vertices + graph @ vertices / degrees) / 2
        done = rounds
        yield mesh.with_vertices(vertices)


def _has_folds(mesh: Mesh) -> bool:
    """Whether the surface is folded back on itself at more than a few edges."""
    normals = mesh.face_normals
    first, second = stable_order(mesh.edge_of_half_edge).reshape(-1, 2).T % len(mesh.faces)
    cosines = np.einsum("ij,ij->i", normals[first], normals[second])
    return float((cosines < MAX_FOLD_COSINE).mean()) > MAX_FOLDED_FRACTION


def _values_on_loops(loops: list[NDArray[np.int64]], mesh: Mesh) -> NDArray[np.int64] | None:
    """(2g, g) linking numbers of a basis of loops with g independent outer loops; None if they are inconsistent."""
    genus = len(loops) // 2
    normals = igl.per_vertex_normals(mesh.vertices, mesh.faces, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE)
    if mesh.volume < 0:
        normals = -normals
    shortest = _shortest_edge(mesh)[:, None]
    for offset in LOOP_OFFSETS:
        linking = _linking_numbers(loops, mesh.vertices, mesh.vertices + offset * shortest * normals)
        if linking is None or np.linalg.matrix_rank(linking) != genus:
            continue
        if round(abs(np.linalg.det(linking - linking.T))) != 1:  # the intersection form of the surface
            continue
        columns = qr(linking.astype(float), mode="r", pivoting=True)[1][:genus]
        return linking[:, np.sort(columns)]
    return None


def _shortest_edge(mesh: Mesh) -> NDArray[np.float64]:
    """(n,) length of the shortest edge at each vertex."""
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1)
    shortest = np.full(len(mesh.vertices), np.inf)
    np.minimum.at(shortest, mesh.edges.ravel(), np.repeat(length, 2))
    return np.where(np.isfinite(shortest), shortest, 0.0)


def _tree_and_cotree(
    mesh: Mesh,
) -> tuple[NDArray[np.int64], NDArray[np.int64], list[tuple[NDArray[np.int64], NDArray[np.int64]]]]:
    """Build the tree of vertices and the tree of faces that crosses none of its edges.

    Returns the edges in neither tree, the parent of each vertex, and for each depth of the face tree, deepest first,
    the faces and the edges to their parents.
    """
    n, k, m = len(mesh.vertices), len(mesh.edges), len(mesh.faces)
    i, j = mesh.edges.T
    graph = weighted_graph(mesh.edges, np.arange(1, k + 1), n)
    parent = breadth_first_order(graph, int(mesh.faces[0, 0]), directed=False)[1].astype(np.int64)
    children = np.flatnonzero(parent >= 0)
    low, high = np.minimum(children, parent[children]), np.maximum(children, parent[children])
    in_tree = np.zeros(k, dtype=bool)
    in_tree[np.searchsorted(i * n + j, low * n + high)] = True

    by_edge = stable_order(mesh.edge_of_half_edge).reshape(k, 2) % m
    crossing = np.flatnonzero(~in_tree)
    low, high = np.sort(by_edge[crossing], axis=1).T
    _, first = np.unique(low * m + high, return_index=True)  # two faces may share two edges
    crossing, low, high = crossing[first], low[first], high[first]
    dual = weighted_graph(np.stack([low, high], axis=1), crossing + 1, m)
    order, face_parent = (indices.astype(np.int64) for indices in breadth_first_order(dual, 0, directed=False))
    depth = np.zeros(m, dtype=np.int64)
    for face in order[1:]:
        depth[face] = depth[face_parent[face]] + 1
    rows = order[1:]
    pair = np.minimum(rows, face_parent[rows]) * m + np.maximum(rows, face_parent[rows])
    to_parent = crossing[np.searchsorted(low * m + high, pair)]
    generators = np.setdiff1d(np.flatnonzero(~in_tree), to_parent)
    cuts = np.flatnonzero(np.diff(depth[rows])) + 1
    levels = list(zip(np.split(rows, cuts), np.split(to_parent, cuts), strict=True))[::-1]
    return generators, parent, levels


def _loop_through(edge: NDArray[np.int64], parent: NDArray[np.int64]) -> NDArray[np.int64]:
    """(l,) vertices of the loop that an edge closes with the tree, without the path that both ends share."""
    to_root = []
    for vertex in edge:
        walk = [int(vertex)]
        while parent[walk[-1]] >= 0:
            walk.append(int(parent[walk[-1]]))
        to_root.append(walk)
    first, second = to_root
    while len(first) > 1 and len(second) > 1 and first[-2] == second[-2]:
        first.pop()
        second.pop()
    return np.array(first[::-1] + second[:-1], dtype=np.int64)


def _linking_numbers(
    loops: list[NDArray[np.int64]], inner: NDArray[np.float64], outer: NDArray[np.float64]
) -> NDArray[np.int64] | None:
    """Linking number of each loop on the surface with each loop shifted outwards; None if one is not an integer."""
    numbers = np.array([[_gauss_integral(inner[a], outer[b]) for b in loops] for a in loops])
    rounded = np.rint(numbers)
    return rounded.astype(np.int64) if np.abs(numbers - rounded).max() < MAX_LINKING_ERROR else None


def _gauss_integral(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Linking number of two closed polylines: the solid angle swept by their differences, over 4 pi."""
    R = second[None, :, :] - first[:, None, :]
    R /= np.linalg.norm(R, axis=2, keepdims=True)
    a, b = R, np.roll(R, -1, axis=1)
    d, c = np.roll(R, -1, axis=0), np.roll(b, -1, axis=0)
    return float((_solid_angle(a, b, c) + _solid_angle(a, c, d)).sum() / (4 * np.pi))


def _solid_angle(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Signed solid angle of triangles whose corners are unit vectors."""
    triple = np.einsum("...k,...k->...", a, np.cross(b, c))
    dots = sum(np.einsum("...k,...k->...", p, q) for p, q in ((a, b), (b, c), (c, a)))
    angle: NDArray[np.float64] = 2 * np.arctan2(triple, 1 + dots)
    return angle


def _extend(
    mesh: Mesh,
    generators: NDArray[np.int64],
    values: NDArray[np.int64],
    cotree_levels: list[tuple[NDArray[np.int64], NDArray[np.int64]]],
) -> NDArray[np.int64] | None:
    """Extend values on the generators to the cochain that is zero on the tree and sums to zero around every face."""
    m = len(mesh.faces)
    edge_of = mesh.edge_of_half_edge.reshape(3, m)
    start, end = mesh.half_edges.T
    sign = np.where(start < end, 1, -1).reshape(3, m)
    cochain = np.zeros((len(mesh.edges), values.shape[1]), dtype=np.int64)
    cochain[generators] = values
    for faces, edges in cotree_levels:
        sums = (sign[:, faces, None] * cochain[edge_of[:, faces]]).sum(axis=0)
        own = sign[np.argmax(edge_of[:, faces] == edges, axis=0), faces]
        cochain[edges] = -own[:, None] * sums
    rest = (sign[:, :, None] * cochain[edge_of]).sum(axis=0)
    return cochain if not rest.any() else None


def transfer_cochain(cochain: NDArray[np.int64], mesh: Mesh, coarse: Mesh, vertex_map: VertexMap) -> NDArray[np.int64]:
    """Transfer a cochain to a mesh each of whose vertices stands for a disc-shaped patch of vertices.

    Parameters
    ----------
    cochain : (k, g) array of int
        On ``mesh.edges``.
    mesh, coarse : Mesh
        Every edge of ``coarse`` joins two patches that an edge of ``mesh`` joins.
    vertex_map : VertexMap
        From the vertices of ``mesh`` to those of ``coarse``.

    Returns
    -------
    (l, g) array of int
        On ``coarse.edges``: the sum along a path between the centers of two patches that stays in the patches.
    """
    patch = vertex_map.indices
    n = len(patch)
    i, j = mesh.edges.T
    within = np.flatnonzero(patch[i] == patch[j])
    center = np.unique(patch, return_index=True)[1]
    to_center = np.stack([np.full(len(center), n), center], axis=1)
    links = np.concatenate([np.stack([i[within], j[within]], axis=1), to_center])
    graph = weighted_graph(links, np.ones(len(links), dtype=np.int8), n + 1)
    parent = breadth_first_order(graph, n, directed=False)[1][:n].astype(np.int64)
    parent = np.where(parent == n, np.arange(n), parent)
    keys = i * n + j
    row = np.searchsorted(keys, np.minimum(parent, np.arange(n)) * n + np.maximum(parent, np.arange(n)))
    sign = np.sign(np.arange(n) - parent)  # zero at a center, which has no parent
    offset = sign[:, None] * cochain[np.minimum(row, len(keys) - 1)]  # from the parent
    while (parent != parent[parent]).any():  # by pointer jumping, from the center in the end
        offset, parent = offset + offset[parent], parent[parent]
    a, b = patch[i], patch[j]
    between = np.flatnonzero(a != b)
    value: NDArray[np.int64] = (offset[i] + cochain - offset[j])[between]
    a, b = a[between], b[between]
    value[a > b] *= -1
    size = len(coarse.vertices)
    _, first = np.unique(np.minimum(a, b) * size + np.maximum(a, b), return_index=True)
    return value[first]
