"""Limbs that a skeleton leaves uncovered: parts of the surface that bulge out of its balls.

Let d be the distance of a vertex from the nearest point of the skeleton, and R the radius there: the inscribed one, or
the mean local radius of the vertices nearest to that node, where noise or a hole makes the inscribed one small. At each
of a sequence of levels, the vertices where d / R is above the level make connected patches. A patch that is a
topological disk, with area A and a rim of length P whose points are at most w from their mean, is a limb if its bulge

    A / (P w) > MIN_BULGE

and if d / R is at least MIN_BRANCH_RATIO at its end, the vertex farthest from the skeleton, as else the branch would be
pruned. A flat disk has a bulge of 1/2, a hemisphere 1, a cone with an angle a between its axis and its side
1 / (2 sin a), a round limb with length l and radius r, which ends in a hemisphere, 1 + l / r, and the corner of a plate
1/2.

Patches grow as the level descends. Of the patches around one end, the limb is the last, and the first is the limb's
cap, whose rim tells the limb's radius; a patch around two limbs is their body. Across a gap, a thin branch may be
nearer than the thick branch that the vertex belongs to: d / R is the smaller one of that at the nearest point and that
at the vertex's own node.

Limbs whose end has no tip near it (:mod:`lbskel.refinement.extrema`) come first, and are not found twice.
"""

from __future__ import annotations

__all__ = ["Limbs", "find_limbs"]

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.level_segments import level_segments
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.sorting import split_at, stable_float_order, stable_order
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

# Lower bound on the bulge of a limb, that of a cone with an angle of 54 degrees between axis and side. "Bulge of limbs"
# in benchmarks/results/neurons.md and "Noise on real meshes" in refinement.md: with more, short limbs are missed; with
# 0.55, by hand, heels and hooves of real meshes have stubs ("limbs grown from a bulge of 0.55 on", tried by hand there)
MIN_BULGE = 0.62
# Levels of d / R at which patches are measured, each a tenth below the one before; they bound the time. Rows "levels of
# limbs" in benchmarks/results/refinement.md: alike from 10 on; by hand, 12 find 0.940 of the tips of tracings, 18 find
# 0.944
LEVELS = np.geomspace(6.0, 1.05, 18)
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class Limbs:
    """Limbs of a surface along which its skeleton has no branch.

    Parameters
    ----------
    ends : (u,) array of int
        The vertex at the end of each limb.
    radii : (u,) array of float
        Radius of a round limb of the same length and area, or whose cap has the same rim.
    limb_of_vertex : (n,) array of int
        The limb of each vertex of the mesh, -1 for none.
    """

    ends: NDArray[np.int64]
    radii: NDArray[np.float64]
    limb_of_vertex: NDArray[np.int64]

    def take(self, chosen: NDArray[np.bool_]) -> Limbs:
        """Select some of the limbs; the others have no vertices."""
        number = np.append(np.where(chosen, np.cumsum(chosen) - 1, -1), -1)  # the last is for vertices of no limb
        return Limbs(self.ends[chosen], self.radii[chosen], number[self.limb_of_vertex])


_Patches = tuple[list[NDArray[np.int64]], NDArray[np.float64]]  # vertices of each, and lengths of the rims


def find_limbs(skeleton: Skeleton, mesh: Mesh, known: Limbs | None = None) -> Limbs:
    """Find the limbs of a mesh that bulge out of the balls of a skeleton, after those that are known.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, in the coordinates of the mesh, and with a node for each of its vertices.
    mesh : Mesh
    known : Limbs, optional
        Those whose ends have no tip, which come first. A limb that contains a vertex of one of these is left out.
    """
    distances, ratios = _ball_distances(skeleton, mesh)
    limb_of_vertex = np.full(len(mesh.vertices), -1) if known is None else np.array(known.limb_of_vertex)
    ends, radii = ([], []) if known is None else (known.ends.tolist(), known.radii.tolist())
    n_known = len(ends)
    for patches in _bulging_patches(mesh, ratios, LEVELS):
        for vertices, rim in zip(*patches, strict=True):
            end = int(vertices[distances[vertices].argmax()])
            if ratios[end] < MIN_BRANCH_RATIO:
                continue
            limbs = {*limb_of_vertex[vertices].tolist()} - {-1}
            if len(limbs) > 1:
                continue
            if not limbs:
                limbs = {len(ends)}
                ends.append(-1)
                radii.append(rim / (2 * np.pi))
            limb = limbs.pop()
            if limb >= n_known:
                limb_of_vertex[vertices] = limb
                ends[limb] = end
    return Limbs(np.array(ends, dtype=np.int64), np.array(radii, dtype=np.float64), limb_of_vertex)


def _ball_distances(skeleton: Skeleton, mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n,) distances of the vertices from the skeleton, and (n,) distances over radii, 0 for vertices without a face.

    Of the ratios at the nearest point of the skeleton and at the vertex's own node, the smaller one counts.
    """
    distances, nearest, inscribed = nearest_on_edges(skeleton, mesh.vertices)
    node_of_vertex, k = cKDTree(skeleton.nodes).query(nearest)[1], len(skeleton.nodes)
    counts = np.maximum(np.bincount(node_of_vertex, minlength=k), 1)
    local = np.bincount(node_of_vertex, local_radii(mesh), k) / counts
    radii, own, used = np.maximum(inscribed, local[node_of_vertex]), skeleton.node_of_vertex, mesh.used_vertices
    own_distances = vector_lengths(mesh.vertices - skeleton.nodes.take(own, axis=0))
    own_radii = np.maximum(skeleton.radii, local)[own]
    ratios = np.zeros(len(mesh.vertices))
    smaller = [each[used] / np.maximum(of[used], TINY) for each, of in ((distances, radii), (own_distances, own_radii))]
    ratios[used] = np.minimum(*smaller)
    return distances, ratios


def _bulging_patches(mesh: Mesh, heights: NDArray[np.float64], levels: NDArray[np.float64]) -> Iterator[_Patches]:
    """Find the disks above each of the levels that bulge as much as limbs; heights are linear in each face."""
    (a, b, c), (i, j) = (heights[cells].T for cells in (mesh.faces, mesh.edges))
    tops_of_faces, tops_of_edges = np.maximum(np.maximum(a, b), c), np.maximum(i, j)
    by_face, by_edge = (stable_float_order(tops, descending=True) for tops in (tops_of_faces, tops_of_edges))
    corners, edges = np.ascontiguousarray(mesh.faces[by_face].T), mesh.edges[by_edge]
    areas, is_boundary = mesh.face_areas[by_face], mesh.faces_per_edge[by_edge] == 1
    depths_of_faces, depths_of_edges = -tops_of_faces[by_face], -tops_of_edges[by_edge]
    bottoms = np.minimum(i, j)[by_edge]
    for level in levels.tolist():
        k, m = np.searchsorted(depths_of_faces, -level), np.searchsorted(depths_of_edges, -level)
        inner, boundary = edges[:m].compress(bottoms[:m] > level, axis=0), edges[:m].compress(is_boundary[:m], axis=0)
        yield _patches_above(mesh.vertices, heights, level, corners[:, :k], areas[:k], inner, boundary)


def _patches_above(
    V: NDArray[np.float64],
    heights: NDArray[np.float64],
    level: float,
    corners: NDArray[np.int64],
    areas: NDArray[np.float64],
    inner: NDArray[np.int64],
    boundary: NDArray[np.int64],
) -> _Patches:
    """Find the disks above a level that bulge as much as limbs.

    Parameters
    ----------
    V : (n, 3) array of float
    heights : (n,) array of float
    level : float
    corners : (3, k) array of int
        Of the faces with a vertex above the level.
    areas : (k,) array of float
    inner : (e, 2) array of int
        The edges between two vertices above the level.
    boundary : (b, 2) array of int
        The edges of one face with a vertex above the level.
    """
    n, is_above = len(heights), heights > level
    roots, vertices = component_roots(inner, np.zeros(n, dtype=np.int64)), np.flatnonzero(is_above)
    x, y, z = is_above[corners]
    patch, is_whole = roots[np.where(x, corners[0], np.where(y, corners[1], corners[2]))], x & y & z
    root = roots[vertices]
    n_vertices, n_edges, n_faces = (
        np.bincount(each, minlength=n) for each in (root, roots[inner[:, 0]], patch[is_whole])
    )
    is_disk = n_vertices - n_edges + n_faces == 1
    of_disk = np.flatnonzero(is_disk[patch])  # the rest of the body is no disk
    patch, areas = patch[of_disk], areas[of_disk]
    is_cut = np.flatnonzero(~is_whole[of_disk])
    cut = corners.take(of_disk[is_cut], axis=1)
    segments = level_segments(V, cut, heights[cut] - level)
    areas[is_cut] *= segments.shares_above
    i, j = boundary.T
    i, j = np.where(is_above[i], [i, j], [j, i])  # boundary edges, from a vertex above the level
    to_j = np.where(is_above[j], 1.0, (heights[i] - level) / np.where(is_above[j], 1.0, heights[i] - heights[j]))
    P, Q = (V.take(each, axis=0) for each in (i, j))
    starts = np.concatenate([segments.starts, P])
    stops = np.concatenate([segments.stops, P + to_j[:, None] * (Q - P)])
    rims, widths = _rims(starts, stops, np.concatenate([patch[is_cut], roots[i]]), n)
    area_of_patch = np.bincount(patch, areas, n)
    is_limb = is_disk & (rims > 0) & (area_of_patch > MIN_BULGE * rims * widths)
    is_chosen, chosen = is_limb[root], np.flatnonzero(is_limb)
    vertices, root = vertices[is_chosen], root[is_chosen]
    parts = split_at(vertices[stable_order(root)], np.cumsum(n_vertices[chosen])[:-1]) if len(chosen) else []
    return parts, rims[chosen]


def _rims(
    starts: NDArray[np.float64], stops: NDArray[np.float64], patch: NDArray[np.int64], n: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measure the rim of each of n patches: the length of its segments, and the largest distance from their mean."""
    lengths = vector_lengths(stops - starts)
    rims = np.bincount(patch, lengths, n).astype(np.float64)
    moments = np.stack([np.bincount(patch, x * lengths, n) for x in (starts + stops).T / 2], axis=1)
    means = moments / np.maximum(rims, TINY)[:, None]
    widths = np.zeros(n)
    for points in (starts, stops):
        np.maximum.at(widths, patch, vector_lengths(points - means.take(patch, axis=0)))
    return rims, widths
