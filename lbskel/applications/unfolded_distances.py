"""Distances along a surface by unfolding its triangles: nearly exact.

Where the surface is flat, they are exact if every triangle on the straight path has corners whose own straight paths
arrive across its edge; where one does not, the path bends at a vertex. On irregular triangles of a square the mean
error is 2e-4 of the largest distance, and the largest 2e-2.

:mod:`lbskel._kernels.unfolding` has the formula. Vertices are visited in a given order until no distance gets smaller.
In the order of the heat that arrives from the sources, two sweeps do most of the work, without a priority queue.

A triangle with distances from two sources would be unfolded towards a point between them. So with several sources the
surface is divided into the regions of the sources, by the distances found first. Each region, a little enlarged, is
then computed again as a surface of its own. The shortest path to the nearest source stays in its region. Each vertex
then belongs to the source that is nearest by the new distances, and regions that have grown are computed again.

The two sheets of a tufted cover must not be unfolded: its flips make triangles that reach across a boundary, or across
an edge of three faces. The distances of their corners come from other sheets, and shorten those behind them.
"""

from __future__ import annotations

__all__ = ["UnfoldedSurface", "single_sheet"]

from functools import cached_property

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lbskel._kernels.unfolding import lower_distances
from lbskel.geometry.intrinsic_triangulation import IntrinsicTriangulation, delaunay, half_edge_twins, interior_twins
from lbskel.operators.intrinsic_delaunay import mollified_lengths
from lbskel.operators.robust import MOLLIFY_FACTOR, distinct_faces

MAX_SWEEPS = 1_000  # a guess, against cycles caused by rounding; seven were the most on nine meshes
# Rings of triangles that are added to the region of a source, so that a border can move by as many in a round; a third
# makes hardly a difference (benchmarks/results/applications_geodesics.md, "Several sources")
RINGS = 2
MAX_ROUNDS = 50  # a guess, against borders that move to and fro; 15 were the most on 946 sets of sources


def single_sheet(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> IntrinsicTriangulation:
    """Build the mollified triangulation of any mesh with flips only at edges of two consistently oriented faces.

    Parameters
    ----------
    vertices : (n, 3) array of float
    faces : (m, 3) array of int
        Only the distinct ones are used, oriented consistently where that is possible.
    """
    F = distinct_faces(faces)
    if not len(F):
        return IntrinsicTriangulation(F, np.empty((0, 3)), np.empty(0, dtype=np.int64))
    if half_edge_twins(F) is None:
        F = igl.bfs_orient(F)[0]
    lengths, _ = mollified_lengths(F, igl.edge_lengths(vertices, F), MOLLIFY_FACTOR)
    return delaunay(IntrinsicTriangulation(F, lengths, interior_twins(F)))


class UnfoldedSurface:
    """A triangulation prepared for distances from many sources.

    Parameters
    ----------
    faces : (m, 3) array of int
        Of a Delaunay triangulation, since a front passes over long edges less well.
    lengths : (m, 3) array of float
        Of the edges opposite the corners.
    n_vertices : int
    """

    def __init__(self, faces: NDArray[np.int64], lengths: NDArray[np.float64], n_vertices: int) -> None:
        self._vertex = np.ascontiguousarray(faces, dtype=np.int64).ravel()
        self._length = np.ascontiguousarray(lengths).ravel()
        self._corners = np.argsort(self._vertex, kind="stable")
        self._first = np.append(0, np.cumsum(np.bincount(self._vertex, minlength=n_vertices)))

    def distance(self, sources: NDArray[np.int64], order: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n,) distance of every vertex to the nearest of the sources; infinite if no triangles connect them.

        Parameters
        ----------
        sources : (s,) array of int
        order : (k,) array of int
            The vertices to be reached, about from the nearest to the farthest.
        """
        merged = self._lowered(sources, order)
        different = np.unique(sources)
        return merged if len(different) == 1 else self._by_regions(different, merged)

    def _lowered(self, sources: NDArray[np.int64], order: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n,) distance to the nearest source, as if all sources were one: too short where two are about as near."""
        distances = np.full(len(self._first) - 1, np.inf)
        distances[sources] = 0.0
        lower_distances(self._vertex, self._length, self._first, self._corners, order, distances, MAX_SWEEPS)
        return distances

    def _by_regions(self, sources: NDArray[np.int64], merged: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) distance to the nearest source, from the distances in a copy of the region of each source."""
        nearest, stale = self._nearest(sources, merged), np.arange(len(sources))
        keys, found = np.empty(0, dtype=np.int64), np.empty(0)
        for _ in range(MAX_ROUNDS):
            kept = ~np.isin(keys % len(sources), stale)
            computed = self._enlarged(np.where(np.isin(nearest, stale), nearest, -1), len(sources))
            keys = np.append(keys[kept], computed)
            found = np.append(found[kept], self._in_regions(computed, sources, stale, merged))
            vertex, source = np.divmod(keys, len(sources))
            distances = np.full(len(merged), np.inf)
            np.minimum.at(distances, vertex, found)
            is_least = np.isfinite(found) & (found == distances[vertex])
            nearest = np.full(len(merged), -1)
            nearest[vertex[is_least]] = source[is_least]
            needed = self._enlarged(nearest, len(sources))
            stale = np.unique(needed[~np.isin(needed, keys)] % len(sources))
            if len(stale) == 0:
                break
        return np.where(np.isfinite(distances), distances, merged)

    def _enlarged(self, nearest: NDArray[np.int64], n_sources: int) -> NDArray[np.int64]:
        """(c,) vertices of the regions with rings around them, ascending, as vertex * n_sources + source."""
        known = np.flatnonzero(nearest >= 0)
        shape = (len(nearest), n_sources)
        member = csr_array((np.ones(len(known), dtype=bool), (known, nearest[known])), shape=shape)
        for _ in range(RINGS):
            member = (member + self._adjacent @ member).tocsr()
        member.sort_indices()
        vertex = np.repeat(np.arange(len(nearest)), np.diff(member.indptr))
        keys: NDArray[np.int64] = vertex * n_sources + member.indices
        return keys

    def _in_regions(
        self,
        keys: NDArray[np.int64],
        sources: NDArray[np.int64],
        chosen: NDArray[np.int64],
        merged: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """(c,) distances in the regions of some sources, each a surface of its own with copies of its vertices."""
        vertex, source = np.divmod(keys, len(sources))
        shape = (len(merged), len(sources))
        member = csr_array((np.ones(len(keys), dtype=bool), (vertex, source)), shape=shape)
        faces = self._vertex.reshape(-1, 3)
        a, b, c = (member[faces[:, k]] for k in range(3))
        common = (a * b * c).tocoo()
        copies = np.searchsorted(keys, faces[common.row] * len(sources) + common.col[:, None])
        regions = UnfoldedSurface(copies, self._length.reshape(-1, 3)[common.row], len(keys))
        own = np.searchsorted(keys, sources[chosen] * len(sources) + chosen)
        by_distance = np.argsort(merged[vertex], kind="stable")
        return regions._lowered(own, by_distance[: np.count_nonzero(np.isfinite(merged[vertex]))])

    @cached_property
    def _adjacent(self) -> csr_array:
        """(n, n) whether two vertices have an edge."""
        start, end = self._vertex, self._vertex.reshape(-1, 3)[:, [1, 2, 0]].ravel()
        n = len(self._first) - 1
        half = csr_array((np.ones(len(start), dtype=bool), (start, end)), shape=(n, n))
        return (half + half.T).tocsr()

    def _nearest(self, sources: NDArray[np.int64], distances: NDArray[np.float64]) -> NDArray[np.int64]:
        """(n,) number of the source that each vertex is nearest to along edges; -1 where none is reached."""
        n = len(distances)
        start = np.repeat(self._vertex, 2)
        face, corner = np.divmod(np.arange(len(self._vertex)), 3)
        other = np.stack([3 * face + (corner + 1) % 3, 3 * face + (corner + 2) % 3], axis=1)
        length = self._length[other[:, ::-1]].ravel()
        end = self._vertex[other].ravel()
        through = np.where(distances[end] < distances[start], distances[end] + length, np.inf)
        least = np.full(n, np.inf)
        np.minimum.at(least, start, through)
        parent = np.arange(n)
        is_least = np.isfinite(through) & (through == least[start])
        parent[start[is_least]] = end[is_least]
        parent[sources] = sources
        while True:
            following = parent[parent]
            if np.array_equal(following, parent):
                break
            parent = following
        number = np.full(n, -1)
        number[sources] = np.arange(len(sources))
        return number[parent]
