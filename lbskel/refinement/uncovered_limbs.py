"""Limbs that a skeleton leaves uncovered: parts of the surface that stand out of its balls, and are longer than wide.

A vertex at distance d from the nearest point of the skeleton, where the radius is R, is uncovered if d > c R, and if
this holds for the node whose region it is in, too: across a gap, a thin branch may be nearer than the own, thick one. A
connected set of uncovered vertices of area A, whose end, the vertex farthest from the skeleton, has the excess
l = d - c R, is a limb if

    2 pi l^2 / A > min_elongation.

For a round limb of radius r, A = 2 pi r l, so the left side is l / r. A hemisphere has 1, and the rim of a flat part,
which is long relative to its excess, has less. A vertex that noise has moved outwards is no limb: l must exceed the
height of noise, which is the roughness of the surface times the length of the longest edge at the end, several times.

Limbs whose end has no tip near it (:mod:`lbskel.refinement.extrema`) come first, and are not found twice.
"""

from __future__ import annotations

__all__ = ["BallDistances", "Limbs", "ball_distances", "find_limbs"]

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.roughness import roughness
from lbskel.geometry.shape_diameter import local_radii
from lbskel.refinement.extrema import GeodesicExtrema
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.skeleton import Skeleton

# Upper bound on the radius of the skeleton at a node, which is the mean distance of the vertices nearest to it, in
# units of their mean thickness: the vertices of a limb without a branch are nearest to its base, and far from it. A
# section three times as wide as thick has a mean radius of about one thickness.
MAX_WIDTH = 1.0
# Lower bound on the excess of a limb, in heights of noise, against branches along vertices that noise has moved. "Noise
# on real meshes" in benchmarks/results/refinement.md
MIN_NOISE_RATIO = 8.0
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class Limbs:
    """Limbs of a surface along which its skeleton has no branch.

    Parameters
    ----------
    ends : (u,) array of int
        The vertex at the end of each limb.
    bases : (u, 3) array of float
        A point of the skeleton near the limb, from which a straight axis leads to the end.
    base_radii : (u,) array of float
        The radius of the skeleton there.
    radii : (u,) array of float
        Radius of a round limb of the same length, or excess, and area.
    min_reaches : (u,) array of float
        Distance from the axis of a limb within which it covers the ends of limbs after it, in radii of the limb.
    limb_of_vertex : (n,) array of int
        The limb of each vertex of the mesh, -1 for none.
    """

    ends: NDArray[np.int64]
    bases: NDArray[np.float64]
    base_radii: NDArray[np.float64]
    radii: NDArray[np.float64]
    min_reaches: NDArray[np.float64]
    limb_of_vertex: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class BallDistances:
    """Distances of the vertices of a mesh from a skeleton, and the radii that they are compared with.

    Parameters
    ----------
    mesh : Mesh
    distances : (n,) array of float
        From the nearest point of the skeleton.
    nearest : (n, 3) array of float
        That point.
    radii : (n,) array of float
        The radius of the skeleton there.
    ratios : (n,) array of float
        Distance over radius, the smaller of that there and that at the vertex's own node; 0 without a face.
    """

    mesh: Mesh
    distances: NDArray[np.float64]
    nearest: NDArray[np.float64]
    radii: NDArray[np.float64]
    ratios: NDArray[np.float64]


def ball_distances(skeleton: Skeleton, mesh: Mesh) -> BallDistances:
    """Measure how far the vertices of a mesh are from the balls of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        With inscribed radii, in the coordinates of the mesh, and with a node for each of its vertices.
    mesh : Mesh
    """
    distances, nearest, inscribed = nearest_on_edges(skeleton, mesh.vertices)
    node_of_vertex = cKDTree(skeleton.nodes).query(nearest)[1]
    k = len(skeleton.nodes)
    count = np.maximum(np.bincount(node_of_vertex, minlength=k), 1)
    mean, thickness = (np.bincount(node_of_vertex, of, k) / count for of in (distances, 2 * local_radii(mesh)))
    widths = np.minimum(mean, MAX_WIDTH * thickness)
    radii, own = np.maximum(inscribed, widths[node_of_vertex]), skeleton.node_of_vertex
    own_distances = np.linalg.norm(mesh.vertices - skeleton.nodes[own], axis=1)
    own_radii = np.maximum(skeleton.radii, widths)[own]
    ratios, used = np.zeros(len(mesh.vertices)), mesh.used_vertices
    smaller = [each[used] / np.maximum(of[used], TINY) for each, of in ((distances, radii), (own_distances, own_radii))]
    ratios[used] = np.minimum(*smaller)
    return BallDistances(mesh, distances, nearest, radii, ratios)


def find_limbs(balls: BallDistances, bounds: Sequence[tuple[float, float]], missed: GeodesicExtrema) -> Limbs:
    """Find the limbs of a mesh that stand out of the balls of a skeleton, after those that are known to be missed.

    Parameters
    ----------
    balls : BallDistances
    bounds : sequence of (float, float)
        Lower bounds on the distance of uncovered vertices from the skeleton, in radii of the skeleton, c, and on the
        elongation. A limb that contains one found by an earlier pair is left out.
    missed : GeodesicExtrema
        The ends without a tip, whose limbs come first. A limb that contains a vertex of one of these is left out.
    """
    limb_of_vertex, n_limbs = missed.limb_of_vertex, len(missed.vertices)
    parts = [(missed.vertices, missed.radii, np.zeros(n_limbs))]
    for min_reach, min_elongation in bounds:
        patch, ends, excess, area = _elongated_patches(balls, min_reach, min_elongation)
        has_limb = np.zeros(len(limb_of_vertex), dtype=bool)
        has_limb[patch[limb_of_vertex >= 0]] = True
        is_new = ~has_limb[patch[ends]]
        ends, excess, area = ends[is_new], excess[is_new], area[is_new]
        limb_of_patch = np.full(len(limb_of_vertex), -1)
        limb_of_patch[patch[ends]] = n_limbs + np.arange(len(ends))
        limb_of_vertex = np.where(limb_of_vertex < 0, limb_of_patch[patch], limb_of_vertex)
        parts.append((ends, area / (2 * np.pi * excess), np.full(len(ends), min_reach)))
        n_limbs += len(ends)
    ends, radii, min_reaches = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Limbs(ends, balls.nearest[ends], balls.radii[ends], radii, min_reaches, limb_of_vertex)


def _elongated_patches(
    balls: BallDistances, min_reach: float, min_elongation: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Find connected sets of uncovered vertices that are limbs.

    Returns
    -------
    tuple
        The (n,) patch of each vertex, covered ones in patches of their own, and for each limb its end, excess and area.
    """
    mesh, distances, radii = balls.mesh, balls.distances, balls.radii
    is_uncovered, n_vertices = balls.ratios > min_reach, len(mesh.vertices)
    edges = mesh.edges[is_uncovered[mesh.edges].all(axis=1)]
    patch = connected_components(weighted_graph(edges, np.ones(len(edges)), n_vertices), directed=False)[1]
    area_of_patch = np.bincount(patch, mesh.vertex_areas * is_uncovered)
    uncovered = np.flatnonzero(is_uncovered)
    uncovered = uncovered[np.argsort(-distances[uncovered], kind="stable")]
    ends = uncovered[np.sort(np.unique(patch[uncovered], return_index=True)[1])]  # the farthest of each patch
    excess, area = distances[ends] - min_reach * radii[ends], area_of_patch[patch[ends]]
    is_limb = 2 * np.pi * excess**2 > min_elongation * area
    if is_limb.any():
        is_limb &= excess > MIN_NOISE_RATIO * roughness(mesh) * mesh.longest_edges[ends]
    return patch.astype(np.int64), ends[is_limb], excess[is_limb], area[is_limb]
