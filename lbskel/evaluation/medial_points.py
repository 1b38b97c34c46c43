"""Distances between a skeleton and the medial points of its surface, which refinement does not use.

A medial point lies one local radius under a vertex, along the normal; on a tube it is on the axis. Neither
cross-sections nor inscribed balls nor geodesic distances are used, by which refinement places nodes and finds limbs, so
that an error of these shows here. Local radii are half the shape diameter (Shapira, Shamir, Cohen-Or 2008,
https://doi.org/10.1007/s00371-007-0197-5). ``benchmarks/results/judge.md`` compares the distances, and the parts that
they leave uncovered, with known axes.
"""

from __future__ import annotations

__all__ = ["MedialDistances", "medial_distances"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags_array, eye_array
from scipy.spatial import cKDTree

from lbskel.geometry.bvh import build_aabb_tree
from lbskel.geometry.components import find_crumbs
from lbskel.geometry.deadline import Deadline
from lbskel.geometry.graphs import connected_labels, weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, triangle_normals
from lbskel.geometry.shape_diameter import local_radii
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.skeleton import Skeleton

N_SAMPLES = 500  # points along the skeleton, which bound the time; benchmarks/results/judge.md
SHARE_ALONG, SHARE_COVERED = 95, 98  # percentiles, of the length and of the area; guesses
MAX_UNCOVERED = 1.0  # distance of a medial point from the skeleton, in radii, above which its vertex is uncovered;
# "Ends that are cut off" in benchmarks/results/judge.md
MIN_PART = np.pi  # area of an uncovered part that counts, in squared radii: that of the section of its limb
MAX_FLUX = 0.5  # area of the opening of a part relative to that of the part: a hemisphere has 0.5, a longer cap less, a
# patch on one side of a limb up to 1; swept in the same table
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True)
class MedialDistances:
    """Distances between a skeleton and the medial points of its surface, in local radii.

    Parameters
    ----------
    accuracy_95 : float
        95th percentile, by length, of the distance from the skeleton to the nearest medial point.
    coverage_98 : float
        98th percentile, by area, of the distance from the medial points to the skeleton.
    uncovered_parts : int
        Limbs, or stretches of them, whose medial points are farther than one radius from the skeleton: connected parts
        of the surface that close around.
    """

    accuracy_95: float
    coverage_98: float
    uncovered_parts: int


def medial_distances(
    skeleton: Skeleton,
    mesh: Mesh,
    widths: NDArray[np.float64],
    thickness: NDArray[np.float64],
    *,
    deadline: Deadline,
) -> MedialDistances:
    """Measure the distances between a skeleton and the medial points of a mesh, both ways.

    In a flat part the medial points form a sheet on both sides of its skeleton, with its edges at twice the mean
    distance of a region from its center: points may be farther by twice what that exceeds the thickness.

    Parameters
    ----------
    skeleton : Skeleton
    mesh : Mesh
    widths : (n,) array of float
        For each vertex of the mesh, the mean distance of the vertices of its region from their center.
    thickness : (n,) array of float
        For each vertex of the mesh, the mean local radius of the vertices of its region.
    deadline : Deadline
    """
    area_vectors = _area_vectors(mesh)
    medial, radii = _medial_points(mesh, area_vectors, deadline)
    points = _evenly_along(skeleton)
    to_medial, _ = build_aabb_tree(medial, mesh.faces).nearest(points, deadline=deadline)
    used = mesh.used_vertices
    accuracy = to_medial / np.maximum(radii[used[cKDTree(medial[used]).query(points)[1]]], TINY)
    to_skeleton, _, _ = nearest_on_edges(skeleton, medial)
    sheet = 2 * np.maximum(widths - np.maximum(thickness, radii), 0)
    scale = np.max([radii, widths, thickness, np.full(len(radii), TINY)], axis=0)
    coverage = np.maximum(to_skeleton - sheet, 0) / scale
    is_skeletal = np.zeros(len(mesh.vertices), dtype=bool)
    is_skeletal[used] = ~find_crumbs(mesh)[mesh.component_of_vertex[used]]
    return MedialDistances(
        accuracy_95=float(np.percentile(accuracy, SHARE_ALONG)),
        coverage_98=_percentile(coverage, np.where(is_skeletal, mesh.vertex_areas, 0), SHARE_COVERED),
        uncovered_parts=_n_parts(mesh, is_skeletal & (coverage > MAX_UNCOVERED), area_vectors, radii),
    )


def _evenly_along(skeleton: Skeleton) -> NDArray[np.float64]:
    """(s, 3) points at equal distances along all edges together; the nodes if there is no length."""
    ends = np.cumsum(skeleton.edge_lengths)
    if skeleton.length <= 0:
        return skeleton.nodes
    at = (np.arange(N_SAMPLES) + 0.5) / N_SAMPLES * ends[-1]
    edge = np.searchsorted(ends, at)
    share = ((ends[edge] - at) / skeleton.edge_lengths[edge])[:, None]
    i, j = skeleton.edges[edge].T
    points: NDArray[np.float64] = share * skeleton.nodes[i] + (1 - share) * skeleton.nodes[j]
    return points


def _medial_points(
    mesh: Mesh, area_vectors: NDArray[np.float64], deadline: Deadline
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 3) medial point of every vertex and (n,) radii there.

    Normals and radii are means over each vertex and its neighbors, so that noise does not scatter the points.
    """
    n = len(mesh.vertices)
    graph = weighted_graph(mesh.edges, np.ones(len(mesh.edges)), n)
    around = graph + graph.T + eye_array(n)
    means = diags_array(1 / around.sum(axis=1)) @ around
    radii = means @ local_radii(mesh, deadline=deadline)
    return mesh.vertices - radii[:, None] * normalized(means @ normalized(area_vectors)), radii


def _percentile(values: NDArray[np.float64], weights: NDArray[np.float64], percent: float) -> float:
    """Find the value below which the given percentage of the weights lies."""
    order = np.argsort(values, kind="stable")
    sums = np.cumsum(weights[order])
    row = np.searchsorted(sums, percent / 100 * sums[-1])
    return float(values[order[min(int(row), len(order) - 1)]])


def _n_parts(
    mesh: Mesh,
    is_uncovered: NDArray[np.bool_],
    area_vectors: NDArray[np.float64],
    radii: NDArray[np.float64],
) -> int:
    """Count the connected parts of the uncovered vertices that have the area of a section and close around."""
    own = np.flatnonzero(is_uncovered)
    if len(own) == 0:
        return 0
    areas, row = mesh.vertex_areas[own], np.cumsum(is_uncovered) - 1
    edges = row[mesh.edges[is_uncovered[mesh.edges].all(axis=1)]]
    part = connected_labels(edges, len(own))
    in_squared_radii = np.bincount(part, areas / np.maximum(radii[own], TINY) ** 2)
    flux = np.linalg.norm([np.bincount(part, x[own]) for x in area_vectors.T], axis=0)
    is_part = (in_squared_radii >= MIN_PART) & (flux <= MAX_FLUX * np.bincount(part, areas))
    return int(is_part.sum())


def _area_vectors(mesh: Mesh) -> NDArray[np.float64]:
    """(n, 3) area of the surface at each vertex, a third of its faces', as a vector along the normal."""
    thirds = triangle_normals(*mesh.vertices.take(mesh.faces.T, axis=0)) / 6
    corners = mesh.faces.ravel()
    return np.stack([np.bincount(corners, np.repeat(x, 3), len(mesh.vertices)) for x in thirds.T], axis=1)
