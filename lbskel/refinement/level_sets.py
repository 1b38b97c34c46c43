"""The centerline of a limb from the level sets of the geodesic distance to its end.

Contraction may pull a limb back to its base, where its centerline is lost. The vertices mapped to the end of a skeleton
are a patch of the surface; where that patch is a limb, the level sets of the distance from its end are closed curves
around it, and their centroids lie on its axis (Verroust, Lazarus 2000, "Extracting skeletal curves from 3D scattered
data", https://doi.org/10.1007/PL00007210).
"""

from __future__ import annotations

__all__ = ["GeodesicCap", "find_geodesic_caps"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, dijkstra

from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order, unique_inverse

LEVEL_SPACING = 0.5  # between level sets, in radii of the limb; a guess, benchmarks/results/constants.md
MAX_LEVELS = 500  # per limb, which bounds the memory that hair-thin limbs take; a guess
CAP_LENGTH = np.pi / 2  # from the end of a round limb to the rim of its hemispherical cap along the surface, in radii
MIN_EDGE_LENGTH = 1e-12  # added to every edge, relative to the diameter bound, since csgraph takes length 0 for no edge


@dataclass(frozen=True, eq=False)
class GeodesicCap:
    """The part of a patch of surface that is nearer to its end than its border is.

    Parameters
    ----------
    end : (3,) array of float
        The vertex farthest from the border.
    length : float
        Distance along edges from the end to the nearest vertex of the border.
    radius : float
        Radius of a round limb of this length and area.
    corners : (f, 3, 3) array of float
        Positions of the corners of its faces.
    edges : (f, 3) array of int
        The number of the edge from each corner to the next.
    distances : (f, 3) array of float
        Distance along edges from the end to each corner.
    """

    end: NDArray[np.float64]
    length: float
    radius: float
    corners: NDArray[np.float64]
    edges: NDArray[np.int64]
    distances: NDArray[np.float64]

    @cached_property
    def axis(self) -> NDArray[np.float64]:
        """(k, 3) centroids of the level sets from the border to the cap of the end; empty if the patch is only a cap.

        Of several curves at one level, the one whose centroid is nearest to that of the level before is used.
        """
        first = CAP_LENGTH * self.radius
        if not 0 < first < self.length:
            return np.empty((0, 3))
        n_levels = int(min((self.length - first) / (LEVEL_SPACING * self.radius), MAX_LEVELS))
        levels = np.linspace(first, self.length, 2 + n_levels)[:-1]
        level_of_curve, centroids = self._level_curves(levels)
        points = [self.end]
        for level in range(len(levels)):
            candidates = centroids[level_of_curve == level]
            if len(candidates):
                points.append(candidates[np.linalg.norm(candidates - points[-1], axis=1).argmin()])
        return np.array(points[:0:-1]).reshape(-1, 3)

    def _level_curves(self, levels: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Compute the level and the centroid of each connected curve at these distances from the end."""
        is_above = self.distances[None] >= levels[:, None, None]
        level, face = np.nonzero(is_above.any(axis=2) & ~is_above.all(axis=2))
        is_above, heights = is_above[level, face], self.distances[face] - levels[level, None]
        is_cut = is_above != np.roll(is_above, -1, axis=1)  # two of the three edges of each face
        start, end = (self.corners[face][is_cut], np.roll(self.corners[face], -1, axis=1)[is_cut])
        low, high = heights[is_cut], np.roll(heights, -1, axis=1)[is_cut]
        points = (start + (low / (low - high))[:, None] * (end - start)).reshape(-1, 2, 3)
        segments = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        key = level[:, None] * (self.edges.max(initial=0) + 1) + self.edges[face][is_cut].reshape(-1, 2)
        crossings, ends = unique_inverse(key.ravel())
        ends = ends.reshape(-1, 2)
        graph = weighted_graph(ends, np.ones(len(ends)), len(crossings))
        curve = connected_components(graph, directed=False)[1][ends[:, 0]]
        lengths = np.bincount(curve, segments)
        moments = np.stack([np.bincount(curve, axis * segments) for axis in points.mean(axis=1).T], axis=1)
        level_of_curve = np.zeros(len(lengths), dtype=np.int64)
        level_of_curve[curve] = level
        has_length = lengths > 0
        return level_of_curve[has_length], moments[has_length] / lengths[has_length, None]


def find_geodesic_caps(mesh: Mesh, patch_of_vertex: NDArray[np.int64]) -> dict[int, GeodesicCap]:
    """Find the geodesic cap of each patch of a surface, by the number of the patch.

    Parameters
    ----------
    mesh : Mesh
    patch_of_vertex : (n,) array of int
        -1 for vertices of no patch. A patch without a border, or without inner vertices, has no cap.
    """
    V, patch, m = mesh.vertices, patch_of_vertex, len(mesh.faces)
    start, end = patch[mesh.edges].T
    border = np.unique(mesh.edges[start != end])
    border = border[patch[border] >= 0]
    if len(border) == 0:
        return {}
    within = mesh.edges[(start == end) & (start >= 0)]
    lengths = np.linalg.norm(V[within[:, 0]] - V[within[:, 1]], axis=1) + MIN_EDGE_LENGTH * mesh.diameter_bound
    graph = weighted_graph(within, lengths, len(V))
    depth = dijkstra(graph, directed=False, indices=border, min_only=True)
    inner = np.flatnonzero(np.isfinite(depth) & (depth > 0))
    inner = inner[np.lexsort((inner, -depth[inner]))]
    ends = inner[np.unique(patch[inner], return_index=True)[1]]
    if len(ends) == 0:
        return {}
    distances = dijkstra(graph, directed=False, indices=ends, min_only=True)
    face = np.flatnonzero(np.isfinite(distances[mesh.faces]).all(axis=1))
    patch_of_corner = patch[mesh.faces[face]]
    face = face[(patch_of_corner == patch_of_corner[:, :1]).all(axis=1)]
    lengths = np.full(int(patch.max()) + 1, np.inf)
    np.minimum.at(lengths, patch[border], distances[border])
    patch_of_face = patch[mesh.faces[face, 0]]
    is_near = distances[mesh.faces[face]].mean(axis=1) <= lengths[patch_of_face]
    face, patch_of_face = face[is_near], patch_of_face[is_near]
    order = stable_order(patch_of_face)
    face, cuts = face[order], np.searchsorted(patch_of_face[order], np.arange(len(lengths) + 1))
    caps = {}
    for tip in ends.tolist():
        length = float(lengths[patch[tip]])
        own = face[cuts[patch[tip]] : cuts[patch[tip] + 1]]
        caps[int(patch[tip])] = GeodesicCap(
            end=V[tip],
            length=length,
            radius=float(mesh.face_areas[own].sum()) / (2 * np.pi * length),
            corners=V[mesh.faces[own]],
            edges=np.stack([mesh.edge_of_half_edge[corner * m + own] for corner in (2, 0, 1)], axis=1),
            distances=distances[mesh.faces[own]],
        )
    return caps
