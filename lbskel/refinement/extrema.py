"""The ends of a shape, found on its surface alone: where a skeleton has to have a tip.

The mean geodesic distance to the rest of the surface is largest at the ends of limbs (Hilaga, Shinagawa, Kohmura, Kunii
2001, https://doi.org/10.1145/383259.383282). From every maximum a limb grows downwards until it meets another one, by
union and find over the vertices in falling order. With its length l from end to border and its area A it counts where

    2 pi l^2 / A > ELONGATION

(a round limb of radius r has A = 2 pi r l, so this is l / r), where it falls off by a share of its length, and where
it is a disc: what is cut out of a ring has a maximum too, but no end.

Distances run along the edges between CELLS cells of the surface, so that neither noise nor the size of the mesh counts.
"""

from __future__ import annotations

__all__ = ["GeodesicExtrema", "find_extrema", "is_missed"]

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial.distance import cdist

from lbskel._kernels.connectivity import pieces
from lbskel._kernels.dijkstra import ShortestPaths
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import numbered
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton

CELLS = 2000
SOURCES = 40  # cells to which the mean distance is taken
FEWEST_CELLS = 6  # of a limb whose length and area can be told
ELONGATION = 2.8  # a half ball has 2.5, a ball on a stalk half its radius long 2.9; shapes without ends have up to 2.7
REACH = 3.0  # radii of a limb from its end within which a tip reaches it; measured up to 2.5 where the tip is right
STANDS_OUT = 1.75  # radii of the nearest node, and of its limb, from which on an end that has no tip is missed
FALL = 0.15  # of its length by which the mean distance falls along a limb; on a rod it is one half, on a ball nothing


@dataclass(frozen=True, eq=False)
class GeodesicExtrema:
    """The ends of a shape.

    Parameters
    ----------
    vertices : (e,) array of int
        The vertex at each end.
    lengths : (e,) array of float
        Of each limb, along the surface from its end to where it meets another one.
    radii : (e,) array of float
        Of a round limb of that length and area.
    limb_of_vertex : (n,) array of int
        The limb that each vertex of the mesh is on, -1 on none.
    """

    vertices: NDArray[np.int64]
    lengths: NDArray[np.float64]
    radii: NDArray[np.float64]
    limb_of_vertex: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Cells:
    """Vertices grouped about seeds, with their areas and the lengths of the ways between neighboring seeds."""

    seeds: NDArray[np.int64]
    cell_of_vertex: NDArray[np.int64]
    areas: NDArray[np.float64]
    graph: csr_array

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """(p, 2) neighbors, each pair in both orders."""
        return np.stack(self.graph.nonzero(), axis=1).astype(np.int64)

    @cached_property
    def ways(self) -> ShortestPaths:
        """To look for ways between cells."""
        return ShortestPaths(self.graph.indptr.astype(np.int64), self.graph.indices.astype(np.int64), self.graph.data)


def find_extrema(mesh: Mesh) -> GeodesicExtrema:
    """Find the ends of limbs, once for each mesh.

    Parameters
    ----------
    mesh : Mesh
        Of any number of components; those that are small beside the whole are not looked at closely.
    """
    return Surface(mesh).memoize("find_extrema", lambda: _found(mesh))


def _found(mesh: Mesh) -> GeodesicExtrema:
    cells = _cells(mesh)
    k = len(cells.seeds)
    sources = np.unique(np.linspace(0, k - 1, SOURCES).astype(np.int64))
    far = cells.ways.distances(sources)
    is_reached = np.isfinite(far)
    height = np.where(is_reached, far, 0).sum(axis=0) / np.maximum(is_reached.sum(axis=0), 1)
    component = pieces(cells.pairs, np.zeros(k, dtype=np.int64))
    limbs = [limb for limb in _limbs(cells, height) if _is_disc(mesh, cells, component, limb[0])]
    limb_of_cell = np.full(k + 1, -1)  # the last is that of vertices without a cell
    for number, (inner, *_) in enumerate(limbs):
        limb_of_cell[inner] = number
    return GeodesicExtrema(
        vertices=cells.seeds[[limb[0][0] for limb in limbs]] if limbs else np.empty(0, dtype=np.int64),
        lengths=np.array([length for _, length, _ in limbs]),
        radii=np.array([area / (2 * np.pi * length) for _, length, area in limbs]),
        limb_of_vertex=limb_of_cell[cells.cell_of_vertex],
    )


def is_missed(found: GeodesicExtrema, mesh: Mesh, skeleton: Skeleton) -> NDArray[np.bool_]:
    """(e,) whether an end of a mesh has no tip near, and stands out of the nearest ball of the skeleton."""
    if len(found.vertices) == 0:
        return np.empty(0, dtype=bool)
    apart = cdist(mesh.vertices[found.vertices], skeleton.nodes)
    has_tip = (apart[:, skeleton.degrees <= 1] <= REACH * found.radii[:, None]).any(axis=1)
    limit = STANDS_OUT * np.maximum(skeleton.radii[apart.argmin(axis=1)], found.radii)
    return ~has_tip & (apart.min(axis=1) > limit)


def _graph(edges: NDArray[np.int64], lengths: NDArray[np.float64], n: int) -> csr_array:
    """Symmetric weights, the shortest of several edges between the same two."""
    i, j = edges.T
    pairs, which = numbered(np.minimum(i, j) * n + np.maximum(i, j))
    shortest = np.full(len(pairs), np.inf)
    np.minimum.at(shortest, which, lengths)
    graph = weighted_graph(np.stack([pairs // n, pairs % n], axis=1), shortest, n)
    return graph + graph.T


def _cells(mesh: Mesh) -> _Cells:
    """Each vertex with the seed that is nearest along edges; seeds are evenly taken from the list of vertices."""
    n, used = len(mesh.vertices), mesh.used_vertices
    i, j = mesh.edges.T
    lengths = (
        np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1) + 1e-12 * mesh.diameter_bound
    )  # none may be zero
    graph = weighted_graph(mesh.edges, lengths, n)
    seeds = used[np.unique(np.linspace(0, len(used) - 1, CELLS).astype(np.int64))]
    far, _, source = dijkstra(graph, directed=False, indices=seeds, min_only=True, return_predecessors=True)
    cell = np.where(source >= 0, np.searchsorted(seeds, source), -1)
    ends = cell[mesh.edges]
    crosses = (ends[:, 0] != ends[:, 1]) & (ends[:, 0] >= 0) & (ends[:, 1] >= 0)
    ways = (lengths + far[mesh.edges].sum(axis=1))[crosses]
    corners, thirds = cell[mesh.faces.ravel()], np.repeat(mesh.face_areas / 3, 3)
    is_reached = corners >= 0  # components so small that no seed fell on them are not
    areas = np.bincount(corners[is_reached], thirds[is_reached], minlength=len(seeds)).astype(np.float64)
    return _Cells(seeds, cell, areas, _graph(ends[crosses], ways, len(seeds)))


def _limbs(cells: _Cells, height: NDArray[np.float64]) -> list[tuple[NDArray[np.int64], float, float]]:
    """The cells of each limb, its end first, with its length and area."""
    pointers, neighbors = cells.graph.indptr.tolist(), cells.graph.indices.tolist()
    group = [-1] * len(height)
    members: dict[int, list[int]] = {}
    is_body: dict[int, bool] = {}  # more than one limb
    limbs: list[tuple[NDArray[np.int64], float, float]] = []
    for cell in np.argsort(-height, kind="stable").tolist():
        meeting = sorted({group[near] for near in neighbors[pointers[cell] : pointers[cell + 1]]} - {-1})
        if not meeting:
            group[cell], members[cell], is_body[cell] = cell, [cell], False
            continue
        into = meeting[0]
        if len(meeting) > 1:
            into = max(meeting, key=lambda g: height[members[g][0]])
            found = {g: limb for g in meeting if not is_body[g] and (limb := _limb(cells, height, members[g], cell))}
            largest = max(meeting, key=lambda g: len(members[g]))
            is_body[into] = (
                any(is_body[g] for g in meeting) or len(found) > 1 or (len(found) == 1 and largest not in found)
            )
            if is_body[into]:
                limbs.extend(found.values())
            elif found:  # a limb takes up what is smaller and does not stand out
                into = largest
                is_body[into] = False
            for other in meeting:
                if other != into:
                    for member in members[other]:
                        group[member] = into
                    members[into] += members.pop(other)
        group[cell] = into
        members[into].append(cell)
    return limbs


def _limb(
    cells: _Cells, height: NDArray[np.float64], members: list[int], border: int
) -> tuple[NDArray[np.int64], float, float] | None:
    """A group of cells as a limb that meets another one at the border; None where it does not stand out."""
    if len(members) < FEWEST_CELLS:
        return None
    inner = np.array(members)
    kinds = np.full(len(height), 2, dtype=np.int8)
    kinds[inner] = 1
    length, area = cells.ways.first_of(inner[:1], kinds)[0], float(cells.areas[inner].sum())
    falls = height[members[0]] - height[border] > FALL * length
    return (inner, length, area) if falls and 2 * np.pi * length**2 > ELONGATION * area else None


def _is_disc(mesh: Mesh, cells: _Cells, component: NDArray[np.int64], limb: NDArray[np.int64]) -> bool:
    """Whether the vertices of some cells, with the cells that they cut off from the rest filled in, are a disc."""
    is_here = component == component[limb[0]]
    outside = np.array(is_here)
    outside[limb] = False
    piece = pieces(cells.pairs, outside.astype(np.int64))
    is_in = is_here & (piece != np.bincount(piece[outside]).argmax())
    is_in = np.append(is_in, False)  # the last is that of vertices without a cell
    within = is_in[cells.cell_of_vertex]
    (i, j), (a, b, c) = mesh.edges.T, mesh.faces.T
    n_edges = np.count_nonzero(within[i] & within[j])
    return bool(np.count_nonzero(within) - n_edges + np.count_nonzero(within[a] & within[b] & within[c]) == 1)
