"""Cells of a surface, and distances between them along the surface.

The cells are geodesic Voronoi cells around seeds that are evenly spaced in the list of vertices with a face. There is
one for each ``CELL_AREA`` squared local radii of area, and at least ``N_CELLS``. Distances follow a graph of the
surface (:mod:`lbskel.geometry.surface_graph`), from seed to seed.
"""

from __future__ import annotations

__all__ = ["SurfaceCells", "surface_cells"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.deadline import Deadline
from lbskel.geometry.graphs import shortest_edges, shortest_paths
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_graph import SurfaceGraph, surface_graph

# Lower bound on the number of cells of a surface, if it has as many vertices: a limb needs several to be found.
# A guess; with 1,400 cells the scores of three of 35 meshes change, with 2,800 that of one
# (benchmarks/results/constants.md)
N_CELLS = 2000
# Upper bound on the area of a cell, in squared local radii: a limb has a cell for each 2.5 radii of its length.
# "Cells of a surface" in benchmarks/results/neurons.md
CELL_AREA = 16.0


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """Geodesic Voronoi cells around k seeds.

    Parameters
    ----------
    surface : SurfaceGraph
    seeds : (k,) array of int
        Vertices.
    cell_of_vertex : (n,) array of int
        -1 for vertices of components without a seed, and of no face.
    areas : (k,) array of float
    adjacency, distances : (k, k) sparse arrays
        Distances between the seeds of adjacent cells: along edges, and along edges and diagonals.
    """

    surface: SurfaceGraph
    seeds: NDArray[np.int64]
    cell_of_vertex: NDArray[np.int64]
    areas: NDArray[np.float64]
    adjacency: csr_array
    distances: csr_array

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """(p, 2) adjacent cells, each pair in both orders."""
        pairs: NDArray[np.int64] = np.stack(self.adjacency.nonzero(), axis=1).astype(np.int64)
        return pairs

    @cached_property
    def shortest_paths(self) -> ShortestPaths:
        """Shortest paths between seeds."""
        return shortest_paths(self.distances)


def surface_cells(mesh: Mesh, deadline: Deadline) -> SurfaceCells:
    """Assign every vertex to the nearest seed along edges.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    surface, used, n = surface_graph(mesh), mesh.used_vertices, len(mesh.vertices)
    seeds = used[np.unique(np.linspace(0, len(used) - 1, _n_cells(mesh, deadline)).astype(np.int64))]
    graph = shortest_edges(surface.edges, surface.lengths, n)
    to_seed, _, source = dijkstra(graph, indices=seeds, min_only=True, return_predecessors=True)
    cell, k = np.where(source >= 0, np.searchsorted(seeds, source), -1), len(seeds)

    def between_cells(pairs: NDArray[np.int64], lengths: NDArray[np.float64]) -> csr_array:
        ends, (i, j) = cell[pairs], pairs.T
        is_crossing = (ends[:, 0] != ends[:, 1]) & (ends[:, 0] >= 0)
        return shortest_edges(ends[is_crossing], (lengths + (to_seed[i] + to_seed[j]))[is_crossing], k)

    adjacency = between_cells(surface.edges, surface.lengths)
    pairs = np.concatenate([surface.edges, surface.diagonals])
    distances = between_cells(pairs, np.concatenate([surface.lengths, surface.diagonal_lengths]))
    corners, thirds = cell[mesh.faces.ravel()], np.repeat(mesh.face_areas / 3, 3)
    has_cell = corners >= 0
    areas = np.bincount(corners[has_cell], thirds[has_cell], minlength=k).astype(np.float64)
    return SurfaceCells(surface, seeds, cell, areas, adjacency, distances)


def _n_cells(mesh: Mesh, deadline: Deadline) -> int:
    """Compute the number of cells from the area in squared local radii."""
    a, b, c = local_radii(mesh, deadline=deadline)[mesh.faces].T
    squared = ((a + b + c) / 3) ** 2
    in_radii = np.divide(mesh.face_areas, squared, out=np.zeros_like(squared), where=squared > 0).sum()
    return int(max(in_radii / CELL_AREA, N_CELLS))
