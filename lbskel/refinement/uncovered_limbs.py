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

__all__ = ["BallDistances", "Limbs", "ball_distances", "find_limbs"]

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.sorting import stable_order
from lbskel.refinement.extrema import GeodesicExtrema
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

# Lower bound on the bulge of a limb, that of a cone with an angle of 54 degrees between axis and side. "Bulge of limbs"
# in benchmarks/results/neurons.md and "Noise on real meshes" in refinement.md: with less, noise makes limbs, and with
# more, short limbs are missed
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


@dataclass(frozen=True, eq=False)
class BallDistances:
    """Distances of the vertices of a mesh from a skeleton, and the radii that they are compared with.

    Parameters
    ----------
    mesh : Mesh
    distances : (n,) array of float
        From the nearest point of the skeleton.
    ratios : (n,) array of float
        Distance over radius, the smaller of that there and that at the vertex's own node; 0 without a face.
    """

    mesh: Mesh
    distances: NDArray[np.float64]
    ratios: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Patches:
    """The parts of a surface above a level that bulge as limbs: vertices, and the lengths of the rims."""

    vertices: list[NDArray[np.int64]]
    rims: NDArray[np.float64]


def ball_distances(skeleton: Skeleton, mesh: Mesh) -> BallDistances:
    """Measure how far the vertices of a mesh are from the balls of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, in the coordinates of the mesh, and with a node for each of its vertices.
    mesh : Mesh
    """
    distances, nearest, inscribed = nearest_on_edges(skeleton, mesh.vertices)
    node_of_vertex, k = cKDTree(skeleton.nodes).query(nearest)[1], len(skeleton.nodes)
    counts = np.maximum(np.bincount(node_of_vertex, minlength=k), 1)
    local = np.bincount(node_of_vertex, local_radii(mesh), k) / counts
    radii, own, used = np.maximum(inscribed, local[node_of_vertex]), skeleton.node_of_vertex, mesh.used_vertices
    own_distances = np.linalg.norm(mesh.vertices - skeleton.nodes[own], axis=1)
    own_radii = np.maximum(skeleton.radii, local)[own]
    ratios = np.zeros(len(mesh.vertices))
    smaller = [each[used] / np.maximum(of[used], TINY) for each, of in ((distances, radii), (own_distances, own_radii))]
    ratios[used] = np.minimum(*smaller)
    return BallDistances(mesh, distances, ratios)


def find_limbs(balls: BallDistances, missed: GeodesicExtrema) -> Limbs:
    """Find the limbs of a mesh that bulge out of the balls of a skeleton, after those that are known to be missed.

    Parameters
    ----------
    balls : BallDistances
    missed : GeodesicExtrema
        The ends without a tip, whose limbs come first. A limb that contains a vertex of one of these is left out.
    """
    limb_of_vertex = np.array(missed.limb_of_vertex)
    ends, radii = missed.vertices.tolist(), missed.radii.tolist()
    for patches in _bulging_patches(balls.mesh, balls.ratios, LEVELS):
        for vertices, rim in zip(patches.vertices, patches.rims, strict=True):
            limbs = {*limb_of_vertex[vertices].tolist()} - {-1}
            end = int(vertices[balls.distances[vertices].argmax()])
            if len(limbs) > 1 or balls.ratios[end] < MIN_BRANCH_RATIO:
                continue
            if not limbs:
                limbs = {len(ends)}
                ends.append(-1)
                radii.append(rim / (2 * np.pi))
            limb = limbs.pop()
            if limb >= len(missed.vertices):
                limb_of_vertex[vertices] = limb
                ends[limb] = end
    return Limbs(np.array(ends, dtype=np.int64), np.array(radii, dtype=np.float64), limb_of_vertex)


def _bulging_patches(mesh: Mesh, heights: NDArray[np.float64], levels: NDArray[np.float64]) -> Iterator[_Patches]:
    """Find the disks above each of the levels that bulge as much as limbs; heights are linear in each face."""
    by_top = []
    for cells in (mesh.faces, mesh.edges):
        tops = heights[cells].max(axis=1)
        order = np.argsort(-tops, kind="stable")
        by_top.append((order, -tops[order]))
    for level in levels.tolist():
        face, edge = (order[: np.searchsorted(depths, -level)] for order, depths in by_top)
        yield _patches_above(mesh, heights, level, face, edge)


def _patches_above(
    mesh: Mesh, heights: NDArray[np.float64], level: float, face: NDArray[np.int64], edge: NDArray[np.int64]
) -> _Patches:
    """Find the disks above a level that bulge as much as limbs, from the faces and edges with a vertex above it."""
    n, is_above = len(heights), heights > level
    edges, faces = mesh.edges[edge], mesh.faces[face]
    inner = edges[is_above[edges].all(axis=1)]
    roots = component_roots(inner, np.zeros(n, dtype=np.int64))
    n_above = is_above[faces].sum(axis=1)
    is_cut, is_single = n_above < 3, n_above == 1
    odd = (is_above[faces] == is_single[:, None]).argmax(axis=1)  # the corner that is alone on its side of the level
    a, b, c = (faces[np.arange(len(faces)), (odd + k) % 3] for k in range(3))
    patch, cut = roots[np.where(is_single, a, b)], np.stack([a, b, c])[:, is_cut]
    to_b, to_c = ((heights[cut[0]] - level) / (heights[cut[0]] - heights[other]) for other in cut[1:])
    areas = np.array(mesh.face_areas[face])
    areas[is_cut] *= np.where(is_single[is_cut], to_b * to_c, 1 - to_b * to_c)
    V, (i, j) = mesh.vertices, edges[mesh.faces_per_edge[edge] == 1].T
    i, j = np.where(is_above[i], [i, j], [j, i])  # boundary edges, from a vertex above the level
    to_j = np.where(is_above[j], 1.0, (heights[i] - level) / np.where(is_above[j], 1.0, heights[i] - heights[j]))
    starts, stops = (
        np.concatenate([V[p] + share[:, None] * (V[q] - V[p]), along])
        for p, q, share, along in (
            (cut[0], cut[1], to_b, V[i]),
            (cut[0], cut[2], to_c, V[i] + to_j[:, None] * (V[j] - V[i])),
        )
    )
    rims, widths = _rims(starts, stops, np.concatenate([patch[is_cut], roots[i]]), n)
    area_of_patch, vertices = np.bincount(patch, areas, n), np.flatnonzero(is_above)
    n_vertices, n_edges, n_faces = (
        np.bincount(each, minlength=n) for each in (roots[vertices], roots[inner[:, 0]], patch[~is_cut])
    )
    is_limb = (n_vertices - n_edges + n_faces == 1) & (rims > 0) & (area_of_patch > MIN_BULGE * rims * widths)
    vertices, chosen = vertices[is_limb[roots[vertices]]], np.flatnonzero(is_limb)
    order = stable_order(roots[vertices])
    parts = np.split(vertices[order], np.cumsum(n_vertices[chosen])[:-1]) if len(chosen) else []
    return _Patches(parts, rims[chosen])


def _rims(
    starts: NDArray[np.float64], stops: NDArray[np.float64], patch: NDArray[np.int64], n: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measure the rim of each of n patches: the length of its segments, and the largest distance from their mean."""
    lengths = np.linalg.norm(stops - starts, axis=1)
    rims = np.bincount(patch, lengths, n).astype(np.float64)
    moments = np.stack([np.bincount(patch, x * lengths, n) for x in (starts + stops).T / 2], axis=1)
    means = moments / np.maximum(rims, TINY)[:, None]
    widths = np.zeros(n)
    for points in (starts, stops):
        np.maximum.at(widths, patch, np.linalg.norm(points - means[patch], axis=1))
    return rims, widths
