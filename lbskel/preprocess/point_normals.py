"""Outward normals of points, and the area that each point stands for.

The normal of a point is that of the least-squares plane of its neighbors. Signs follow a minimum spanning tree of the
angles between neighbors (Hoppe, DeRose, Duchamp, McDonald, Stuetzle 1992, https://doi.org/10.1145/133994.134011). Then
each normal is replaced by the direction in which the winding number of all of them falls, which makes noisy normals
smooth and wrong signs right (Lin, Shi, Liu 2024, "Fast and globally consistent normal orientation based on the winding
number normal consistency", https://doi.org/10.1145/3687895).
"""

from __future__ import annotations

__all__ = ["OrientedPoints", "oriented"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.normals import normalized
from lbskel.preprocess.dipole_tree import DipoleTree

N_NEIGHBORS = 16  # of a point in its plane of least squares, and for its area; a guess
N_LINKS = 8  # nearest neighbors that the sign of a normal can follow; a guess
SMOOTHING = (3.0, 2.0)  # widths of the dipoles, in spacings, in each round that corrects the normals; a guess
MIN_ANGLE_COST = 1e-6  # of an edge between parallel normals: a cost of zero would be no edge


@dataclass(frozen=True, eq=False)
class OrientedPoints:
    """Points of a surface with normals and areas.

    Parameters
    ----------
    points : (n, 3) array of float
    normals : (n, 3) array of float
        Of unit length, outward.
    areas : (n,) array of float
        Of the disk that a point stands for.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    areas: NDArray[np.float64]

    @property
    def spacings(self) -> NDArray[np.float64]:
        """(n,) distance between neighbors: the side of a square of the point's area."""
        spacings: NDArray[np.float64] = np.sqrt(self.areas)
        return spacings

    def field(self, smoothing: float) -> DipoleTree:
        """Build the winding number of the points, smoothed over some spacings."""
        return DipoleTree.of(self.points, self.areas[:, None] * self.normals, smoothing * self.spacings)


def oriented(points: NDArray[np.float64]) -> OrientedPoints:
    """Estimate the outward normals and the areas of points.

    Parameters
    ----------
    points : (n, 3) array of float
        Distinct, of a closed surface or parts of one; more than N_NEIGHBORS.
    """
    distances, neighbors = cKDTree(points).query(points, k=N_NEIGHBORS)
    offsets = points[neighbors] - points[neighbors].mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))[1][:, :, 0]
    areas = np.pi * distances[:, -1] ** 2 / (N_NEIGHBORS - 0.5)
    found = OrientedPoints(points, _with_signs(points, normals, areas, neighbors[:, 1 : N_LINKS + 1]), areas)
    for smoothing in SMOOTHING:
        gradient = found.field(smoothing).field(points)[1]
        found = OrientedPoints(points, normalized(-gradient), areas)
    return found


def _with_signs(
    points: NDArray[np.float64], normals: NDArray[np.float64], areas: NDArray[np.float64], neighbors: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Give normals the signs that neighbors agree on, such that the volume of each connected part is positive."""
    n, k = neighbors.shape
    links = np.sort(np.stack([np.repeat(np.arange(n), k), neighbors.ravel()], axis=1), axis=1)
    links = np.stack(np.divmod(np.unique(links @ [n, 1]), n), axis=1)
    cosines = np.abs((normals[links[:, 0]] * normals[links[:, 1]]).sum(axis=1))
    graph = weighted_graph(links, np.maximum(1 - cosines, 0) + MIN_ANGLE_COST, n)
    n_parts, part = connected_components(graph, directed=False)
    first = np.unique(part, return_index=True)[1]
    tree = minimum_spanning_tree(graph).tocoo()
    # the first points hang on one more node, so that one search reaches every part
    edges = np.concatenate([np.stack([tree.row, tree.col], axis=1), np.stack([first, np.full(n_parts, n)], axis=1)])
    found, parent = breadth_first_order(weighted_graph(edges, np.ones(len(edges)), n + 1), n, directed=False)
    above = np.where(parent[:n] < n, parent[:n], np.arange(n))
    agrees = np.where((normals * normals[above]).sum(axis=1) < 0, -1.0, 1.0)
    sign = np.ones(n + 1)
    for node, up in zip(found[1:].tolist(), parent[found[1:]].tolist(), strict=True):
        sign[node] = sign[up] * agrees[node]
    signed = normals * sign[:n, None]
    count = np.bincount(part)
    centers = np.stack([np.bincount(part, column) / count for column in points.T], axis=1)
    volumes = np.bincount(part, areas * (signed * (points - centers[part])).sum(axis=1))
    outward: NDArray[np.float64] = signed * np.where(volumes < 0, -1.0, 1.0)[part, None]
    return outward
