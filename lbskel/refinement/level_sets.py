"""Limbs traced over the surface: where contraction has drawn one back to where it begins, its axis is lost but not it.

What an end of a skeleton stands for is a piece of surface. Where that is a limb, the distance over it from its far end
has level curves round it, and their centroids lie on its axis: Verroust, Lazarus 2000, "Extracting skeletal curves from
3D scattered data", https://doi.org/10.1007/PL00007210.
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
from lbskel.geometry.sorting import numbered

STEP = 0.5  # of the radius, from one level curve to the next
MOST_LEVELS = 500  # of a limb as thin as a hair
CAP = np.pi / 2  # radii from the end of a round limb to the edge of the half ball there
SHORTEST = 1e-12  # of the extent: added to every edge, since no length would mean no edge


@dataclass(frozen=True, eq=False)
class GeodesicCap:
    """A piece of surface as far as its border is from its end.

    Parameters
    ----------
    end : (3,) array of float
        The vertex farthest from the border.
    length : float
        From the end to where the border is nearest, along edges.
    radius : float
        Of a round limb of that length and area.
    corners : (f, 3, 3) array of float
        Of its faces.
    edges : (f, 3) array of int
        A number for the edge from each corner to the next.
    far : (f, 3) array of float
        Distance from the end to each corner, along edges.
    """

    end: NDArray[np.float64]
    length: float
    radius: float
    corners: NDArray[np.float64]
    edges: NDArray[np.int64]
    far: NDArray[np.float64]

    @cached_property
    def axis(self) -> NDArray[np.float64]:
        """(k, 3) centroids of level curves, from the border to the cap of the end; none where that is beyond.

        Of several curves at one level the one nearest to that of the level before counts.
        """
        first = CAP * self.radius
        if not 0 < first < self.length:
            return np.empty((0, 3))
        n_levels = int(min((self.length - first) / (STEP * self.radius), MOST_LEVELS))
        levels = np.linspace(first, self.length, 2 + n_levels)[:-1]
        level_of_curve, centroids = self._curves(levels)
        places = [self.end]
        for level in range(len(levels)):
            here = centroids[level_of_curve == level]
            if len(here):
                places.append(here[np.linalg.norm(here - places[-1], axis=1).argmin()])
        return np.array(places[:0:-1]).reshape(-1, 3)

    def _curves(self, levels: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The level of each curve at these distances, and its centroid."""
        above = self.far[None] >= levels[:, None, None]
        level, face = np.nonzero(above.any(axis=2) & ~above.all(axis=2))
        above, heights = above[level, face], self.far[face] - levels[level, None]
        is_cut = above != np.roll(above, -1, axis=1)  # two of the three edges of each face
        start, end = (self.corners[face][is_cut], np.roll(self.corners[face], -1, axis=1)[is_cut])
        low, high = heights[is_cut], np.roll(heights, -1, axis=1)[is_cut]
        points = (start + (low / (low - high))[:, None] * (end - start)).reshape(-1, 2, 3)
        pieces = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        key = level[:, None] * (self.edges.max(initial=0) + 1) + self.edges[face][is_cut].reshape(-1, 2)
        crossings, ends = numbered(key.ravel())
        ends = ends.reshape(-1, 2)
        graph = weighted_graph(ends, np.ones(len(ends)), len(crossings))
        curve = connected_components(graph, directed=False)[1][ends[:, 0]]
        lengths = np.bincount(curve, pieces)
        sums = np.stack([np.bincount(curve, axis * pieces) for axis in points.mean(axis=1).T], axis=1)
        level_of_curve = np.zeros(len(lengths), dtype=np.int64)
        level_of_curve[curve] = level
        there = lengths > 0
        return level_of_curve[there], sums[there] / lengths[there, None]


def find_geodesic_caps(mesh: Mesh, piece_of_vertex: NDArray[np.int64]) -> dict[int, GeodesicCap]:
    """The limb that each piece of a surface is, by the number of the piece.

    Parameters
    ----------
    mesh : Mesh
    piece_of_vertex : (n,) array of int
        -1 for vertices of none. A piece without a border, or all border, is no limb.
    """
    V, piece, m = mesh.vertices, piece_of_vertex, len(mesh.faces)
    start, end = piece[mesh.edges].T
    border = np.unique(mesh.edges[start != end])
    border = border[piece[border] >= 0]
    if len(border) == 0:
        return {}
    within = mesh.edges[(start == end) & (start >= 0)]
    lengths = np.linalg.norm(V[within[:, 0]] - V[within[:, 1]], axis=1) + SHORTEST * mesh.diameter_bound
    graph = weighted_graph(within, lengths, len(V))
    depth = dijkstra(graph, directed=False, indices=border, min_only=True)
    deep = np.flatnonzero(np.isfinite(depth) & (depth > 0))
    deep = deep[np.lexsort((deep, -depth[deep]))]
    ends = deep[np.unique(piece[deep], return_index=True)[1]]
    if len(ends) == 0:
        return {}
    far = dijkstra(graph, directed=False, indices=ends, min_only=True)
    face = np.flatnonzero(np.isfinite(far[mesh.faces]).all(axis=1))
    corner_pieces = piece[mesh.faces[face]]
    face = face[(corner_pieces == corner_pieces[:, :1]).all(axis=1)]
    limbs = {}
    for tip in ends.tolist():
        length = float(far[border[piece[border] == piece[tip]]].min())
        mine = face[piece[mesh.faces[face, 0]] == piece[tip]]
        mine = mine[far[mesh.faces[mine]].mean(axis=1) <= length]
        limbs[int(piece[tip])] = GeodesicCap(
            end=V[tip],
            length=length,
            radius=float(mesh.face_areas[mine].sum()) / (2 * np.pi * length),
            corners=V[mesh.faces[mine]],
            edges=np.stack([mesh.edge_of_half_edge[corner * m + mine] for corner in (2, 0, 1)], axis=1),
            far=far[mesh.faces[mine]],
        )
    return limbs
