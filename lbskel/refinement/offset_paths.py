"""Shortest paths below a surface, along the edges of the mesh with its vertices moved inwards.

A vertex is moved inwards by half the thickness of the shape, but no deeper than the depth given for each path. The
thickness takes one ray per vertex, so it is first measured in a region around each path, and everywhere only if the
search for a path leaves this region.
"""

from __future__ import annotations

__all__ = ["moved_inwards", "paths_below_surface"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.dijkstra import OffsetPaths
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.surface_queries import VERTEX_OFFSET, Surface

MIN_EDGE_LENGTH = 1e-12  # added to every edge in the mesh's units, so that edges without length count
MIN_RADIUS = 0.01  # of the region around a path that is measured first, relative to the diameter bound; speed only
SEARCH_FACTOR = 2.0  # of its radius, relative to half the gap plus the depth; it affects speed only
N_AT_ONCE = 256  # paths whose regions are searched for at once, which bounds the memory; it affects speed only


def paths_below_surface(
    starts: NDArray[np.float64], ends: NDArray[np.float64], depths: NDArray[np.float64], surface: Surface
) -> list[NDArray[np.float64]]:
    """For each path, the (k, 3) points from the moved vertex nearest to its start to the one nearest to its end.

    Parameters
    ----------
    starts, ends : (p, 3) array of float
    depths : (p,) array of float
        Upper bound on how far the vertices of each path are moved inwards.
    surface : Surface
    """
    paths: list[NDArray[np.float64]] = []
    for first in range(0, len(depths), N_AT_ONCE):
        rows = slice(first, first + N_AT_ONCE)
        paths += _some_paths(starts[rows], ends[rows], depths[rows], surface)
    return paths


def _some_paths(
    starts: NDArray[np.float64], ends: NDArray[np.float64], depths: NDArray[np.float64], surface: Surface
) -> list[NDArray[np.float64]]:
    """Compute a few paths at once."""
    half_gaps = np.linalg.norm(ends - starts, axis=1) / 2
    radii = SEARCH_FACTOR * np.maximum(half_gaps + depths, MIN_RADIUS * surface.mesh.diameter_bound)
    around = surface.vertex_tree.query_ball_point((starts + ends) / 2, radii)
    near = [_possible_nearest(points, depths, surface) for points in (starts, ends)]
    region = np.unique(np.concatenate([*around, *near[0], *near[1]]).astype(np.int64))
    surface.inner_offset(region)
    firsts, lasts = (
        [_nearest(*query, surface) for query in zip(points, found, depths, strict=True)]
        for points, found in zip((starts, ends), near, strict=True)
    )
    search = surface.memoize("offset paths", lambda: _search(surface))
    queries = list(zip(firsts, lasts, depths.tolist(), strict=True))
    found = [search.path(*query) for query in queries]
    if not all(is_known for is_known, _ in found):
        surface.inner_offset(surface.mesh.used_vertices)
        found = [answer if answer[0] else search.path(*query) for answer, query in zip(found, queries, strict=True)]
    return [
        moved_inwards(path if len(path) else np.array([last]), depth, surface)
        for (_, path), last, depth in zip(found, lasts, depths, strict=True)
    ]


def _possible_nearest(
    points: NDArray[np.float64], depths: NDArray[np.float64], surface: Surface
) -> list[NDArray[np.int64]]:
    """For each point, candidates for the vertex that is nearest to it once the vertices are moved inwards."""
    tree = surface.vertex_tree
    moved = depths + VERTEX_OFFSET * surface.mesh.diameter_bound
    return [np.array(found) for found in tree.query_ball_point(points, tree.query(points)[0] + 2 * moved)]


def _nearest(point: NDArray[np.float64], vertices: NDArray[np.int64], depth: float, surface: Surface) -> int:
    """Choose the vertex that is nearest to a point once they are moved inwards."""
    vertices = np.sort(vertices)
    return int(vertices[np.linalg.norm(moved_inwards(vertices, depth, surface) - point, axis=1).argmin()])


def moved_inwards(
    vertices: NDArray[np.int64], depths: NDArray[np.float64] | float, surface: Surface
) -> NDArray[np.float64]:
    """(k, 3) positions of vertices that are moved inwards by half the thickness there, but at most by a depth.

    Parameters
    ----------
    vertices : (k,) array of int
    depths : (k,) array of float, or float
    surface : Surface
    """
    entry, inward, thickness = surface.inner_offset(vertices)
    moved: NDArray[np.float64] = entry + np.minimum(thickness / 2, depths)[:, None] * inward
    return moved


def _search(surface: Surface) -> OffsetPaths:
    """Make the search along the edges of the mesh; it uses the thickness known at the time of each query."""
    edges = surface.mesh.edges
    both = np.concatenate([edges, edges[:, ::-1]])
    graph = weighted_graph(both, np.ones(len(both), dtype=np.int8), len(surface.mesh.vertices))
    first, neighbors = graph.indptr.astype(np.int64), graph.indices.astype(np.int64)
    return OffsetPaths(first, neighbors, *surface.inward_rays, MIN_EDGE_LENGTH)
