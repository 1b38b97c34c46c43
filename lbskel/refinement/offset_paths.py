"""Shortest paths below a surface, along the edges of the mesh with its vertices moved inwards.

A vertex is moved inwards by half the thickness of the shape, but no deeper than the depth given for each path.
"""

from __future__ import annotations

__all__ = ["moved_inwards", "paths_below_surface"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.dijkstra import OffsetPaths
from lbskel.geometry.graphs import edge_length_graph
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface


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
    used = surface.mesh.used_vertices
    surface.inner_offset(used)  # measures the thickness at all of them, which the search needs
    search = surface.memoize("offset paths", lambda: _search(surface))
    paths: list[NDArray[np.float64]] = []
    for start, end, depth in zip(starts, ends, depths.tolist(), strict=True):
        moved = moved_inwards(used, depth, surface)
        first, last = (int(used[vector_lengths(moved - point).argmin()]) for point in (start, end))
        path = search.path(first, last, depth)
        paths.append(moved_inwards(path if len(path) else np.array([last]), depth, surface))
    return paths


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
    """Make the search along the edges of the mesh, whose thickness is known at all vertices."""
    graph = edge_length_graph(surface.mesh)
    return OffsetPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), *surface.inward_rays, 0.0)
