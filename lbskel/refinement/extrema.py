"""The ends of a shape, found on its surface alone: where a skeleton must have a tip.

The mean geodesic distance to the rest of the surface is maximal at the ends of limbs (Hilaga, Shinagawa, Kohmura, Kunii
2001, https://doi.org/10.1145/383259.383282). From every maximum a limb grows downwards until it meets another one, by
union-find over cells of the surface in descending order of that distance. A limb with length l from its end to its
border and area A is accepted if it is long enough,

    2 pi l^2 / A > MIN_ELONGATION

(a round limb of radius r has A = 2 pi r l, so this is l / r), and if it is a topological disk: a part of a ring has a
maximum too, but no end.

A limb encloses a part of the solid; what encloses a part of the outside, as a hole drilled into a side does, is a pit
and has no end.

Distances are measured between cells of the surface (:mod:`lbskel.refinement.surface_cells`), so that noise and the
triangulation hardly change which ends are found. Lengths vary a little with the order of the vertices, as the cells do.
"""

from __future__ import annotations

__all__ = ["GeodesicExtrema", "find_extrema", "is_missed"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel._kernels.connectivity import component_roots
from lbskel.geometry.components import components
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.surface_cells import N_CELLS, SurfaceCells, surface_cells
from lbskel.skeleton.edge_distances import nearest_on_edges
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

N_SOURCES = 40  # cells to which the mean distance is taken; a guess, benchmarks/results/constants.md
MIN_CELLS = 6  # of a limb whose length and area can be measured; a guess, benchmarks/results/constants.md
MIN_ELONGATION = 2.8  # of a limb; a hemisphere has 2.5, a ball on a stalk half its radius long 2.9, and our shapes
# without ends have up to 2.7; a guess between
TIP_REACH = 3.0  # distance from the end of a limb within which a tip reaches it, in radii of the limb: 2 to 3 are
# alike, with 4 a limb of a creature is missed, rows "reach of a tip" in benchmarks/results/refinement.md


@dataclass(frozen=True, eq=False)
class GeodesicExtrema:
    """The ends of a shape's limbs.

    Parameters
    ----------
    vertices : (e,) array of int
        The vertex at each end.
    lengths : (e,) array of float
        Distance along the surface from each end to where its limb meets another one.
    radii : (e,) array of float
        Radius of a round limb of that length and area.
    limb_of_vertex : (n,) array of int
        The limb of each vertex of the mesh, -1 for none.
    """

    vertices: NDArray[np.int64]
    lengths: NDArray[np.float64]
    radii: NDArray[np.float64]
    limb_of_vertex: NDArray[np.int64]


_Limb = tuple[NDArray[np.int64], float, float]  # the cells of a limb, its end first, its length and its area


def find_extrema(mesh: Mesh, *, deadline: Deadline = NEVER) -> GeodesicExtrema:
    """Find the ends of the limbs of a mesh; computed once per mesh.

    A component with at least N_CELLS vertices is measured by itself, so that its ends are those that its own body has;
    the smaller ones share one set of cells.

    Parameters
    ----------
    mesh : Mesh
        Of any number of components. A component so small that it has no cell has no ends.
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    find = _find_extrema if mesh.n_components == 1 else _find_on_components
    found: GeodesicExtrema = Surface(mesh).memoize("find_extrema", lambda: find(mesh, deadline))
    return found


def _find_on_components(mesh: Mesh, deadline: Deadline) -> GeodesicExtrema:
    """Find the ends of each large component, and those of the others, which share their cells."""
    large = [part for part in components(mesh) if len(part.vertices) >= N_CELLS]
    is_small = np.ones(len(mesh.vertices), dtype=bool)
    for part in large:
        is_small[part.vertices] = False
    found = [(part.vertices, find_extrema(part.mesh, deadline=deadline)) for part in large]
    if len(faces := mesh.faces[is_small[mesh.faces[:, 0]]]):
        others = Mesh(mesh.vertices, faces) if large else mesh
        found.append((np.arange(len(mesh.vertices)), _find_extrema(others, deadline)))
    limb_of_vertex, n_limbs = np.full(len(mesh.vertices), -1), 0
    for vertices, own in found:
        is_limb = own.limb_of_vertex >= 0
        limb_of_vertex[vertices[is_limb]] = own.limb_of_vertex[is_limb] + n_limbs
        n_limbs += len(own.vertices)
    return GeodesicExtrema(
        vertices=np.concatenate([vertices[own.vertices] for vertices, own in found]),
        lengths=np.concatenate([own.lengths for _, own in found]),
        radii=np.concatenate([own.radii for _, own in found]),
        limb_of_vertex=limb_of_vertex,
    )


def _find_extrema(mesh: Mesh, deadline: Deadline) -> GeodesicExtrema:
    """Find the ends of a surface whose components share its cells."""
    cells = surface_cells(mesh, deadline)
    deadline.check()
    k = len(cells.seeds)
    sources = np.unique(np.linspace(0, k - 1, N_SOURCES).astype(np.int64))
    distances = cells.shortest_paths.distances(sources)
    is_reached = np.isfinite(distances)
    height = np.where(is_reached, distances, 0).sum(axis=0) / np.maximum(is_reached.sum(axis=0), 1)
    limbs = _grow_limbs(cells, height)
    members = [inner for inner, *_ in limbs]
    is_end = _are_disks(members, cells) & _is_solid(mesh, _limb_of_vertex(members, cells), len(limbs))
    limbs = [limbs[number] for number in np.flatnonzero(is_end)]
    radii = np.array([area / (2 * np.pi * length) for _, length, area in limbs])
    ends = [_end_of_cell(int(limb[0][0]), cells, mesh, radius) for limb, radius in zip(limbs, radii, strict=True)]
    return GeodesicExtrema(
        vertices=np.array(ends, dtype=np.int64),
        lengths=np.array([length for _, length, _ in limbs]),
        radii=radii,
        limb_of_vertex=_limb_of_vertex([inner for inner, *_ in limbs], cells),
    )


def _end_of_cell(cell: int, cells: SurfaceCells, mesh: Mesh, radius: float) -> int:
    """Find the vertex at the end of a limb in its highest cell: the seed, or the last one of a cell longer than that.

    Cells are as large as the whole surface asks for. One that covers much of a thin limb has its end a radius of the
    limb and more beyond its seed, away from the cells around it.
    """
    seed, vertices = int(cells.seeds[cell]), np.flatnonzero(cells.cell_of_vertex == cell)
    first, last = cells.adjacency.indptr[cell : cell + 2]
    around = mesh.vertices[cells.seeds[cells.adjacency.indices[first:last]]].mean(axis=0)
    farthest = int(vertices[vector_lengths(mesh.vertices[vertices] - around).argmax()])
    return farthest if np.linalg.norm(mesh.vertices[farthest] - mesh.vertices[seed]) > radius else seed


def is_missed(extrema: GeodesicExtrema, mesh: Mesh, skeleton: Skeleton) -> NDArray[np.bool_]:
    """(e,) whether an end of a mesh has no tip near it, and is as far from the skeleton as a branch that is not pruned.

    That is MIN_BRANCH_RATIO radii, inscribed or local ones of the surface: a tip next to a flat cap has a small ball.

    Parameters
    ----------
    extrema : GeodesicExtrema
    mesh : Mesh
        The mesh of the extrema.
    skeleton : Skeleton
        With inscribed radii, in the coordinates of the mesh.
    """
    ends, tips = mesh.vertices[extrema.vertices], skeleton.nodes[skeleton.degrees <= 1]
    to_tip = cKDTree(tips).query(ends)[0] if len(tips) else np.inf
    distances, nearest, inscribed = nearest_on_edges(skeleton, ends)
    thickness = local_radii(mesh)[Surface(mesh).vertex_tree.query(nearest)[1]]
    is_far = distances > MIN_BRANCH_RATIO * np.maximum(inscribed, thickness)
    return np.asarray(is_far & (to_tip > TIP_REACH * extrema.radii))


def _grow_limbs(cells: SurfaceCells, height: NDArray[np.float64]) -> list[_Limb]:
    """Find the limbs of a surface by union-find over the cells in order of descending height."""
    pointers, neighbors = cells.adjacency.indptr.tolist(), cells.adjacency.indices.tolist()
    group = [-1] * len(height)
    members: dict[int, list[int]] = {}
    is_body: dict[int, bool] = {}  # whether a group holds more than one limb
    limbs: list[_Limb] = []
    for cell in np.argsort(-height, kind="stable").tolist():
        around = {group[near] for near in neighbors[pointers[cell] : pointers[cell + 1]]}
        around.discard(-1)
        if not around:
            group[cell], members[cell], is_body[cell] = cell, [cell], False
            continue
        if len(around) == 1:
            into = around.pop()
        else:
            adjacent = sorted(around)
            into = max(adjacent, key=lambda g: height[members[g][0]])
            found = {g: limb for g in adjacent if not is_body[g] and (limb := _as_limb(cells, members[g]))}
            largest = max(adjacent, key=lambda g: len(members[g]))
            is_body[into] = (
                any(is_body[g] for g in adjacent) or len(found) > 1 or (len(found) == 1 and largest not in found)
            )
            if is_body[into]:
                limbs.extend(found.values())
            elif found:  # a limb absorbs smaller groups that are no limbs
                into = largest
            for other in adjacent:
                if other != into:
                    for member in members[other]:
                        group[member] = into
                    members[into] += members.pop(other)
        group[cell] = into
        members[into].append(cell)
    return limbs


def _as_limb(cells: SurfaceCells, members: list[int]) -> _Limb | None:
    """Measure a group of cells as a limb; None if it is not elongated."""
    if len(members) < MIN_CELLS:
        return None
    inner = np.array(members)
    kinds = np.full(len(cells.seeds), 2, dtype=np.int8)
    kinds[inner] = 1
    length, area = cells.shortest_paths.nearest_goal(inner[:1], kinds)[0], float(cells.areas[inner].sum())
    return (inner, length, area) if 2 * np.pi * length**2 > MIN_ELONGATION * area else None


def _limb_of_vertex(limbs: list[NDArray[np.int64]], cells: SurfaceCells) -> NDArray[np.int64]:
    """(n,) the limb of each vertex, from the cells of each limb; -1 for none."""
    limb_of_cell = np.full(len(cells.seeds) + 1, -1)  # the last entry is for vertices without a cell
    for number, inner in enumerate(limbs):
        limb_of_cell[inner] = number
    return limb_of_cell[cells.cell_of_vertex]


def _are_disks(limbs: list[NDArray[np.int64]], cells: SurfaceCells) -> NDArray[np.bool_]:
    """Whether the cells of each limb, alone or with the cells that they cut off from the rest, form a disk."""
    component = component_roots(cells.pairs, np.zeros(len(cells.seeds), dtype=np.int64))
    are_disks = _count_as_disks(limbs, cells)
    for number in np.flatnonzero(~are_disks).tolist():
        limb = limbs[number]
        is_outside = component == component[limb[0]]
        is_outside[limb] = False
        piece = component_roots(cells.pairs, is_outside.astype(np.int64))
        is_cut_off = is_outside & (piece != np.bincount(piece[is_outside]).argmax())
        if is_cut_off.any():
            [are_disks[number]] = _count_as_disks([np.append(limb, np.flatnonzero(is_cut_off))], cells)
    return are_disks


def _count_as_disks(limbs: list[NDArray[np.int64]], cells: SurfaceCells) -> NDArray[np.bool_]:
    """Whether the vertices of each limb's cells have the Euler characteristic of a disk."""
    limb_of_vertex = _limb_of_vertex(limbs, cells)
    vertices, edges, faces = np.arange(len(limb_of_vertex))[:, None], cells.surface.edges, cells.surface.faces
    owners = [_limb_of_all_corners(limb_of_vertex, simplices) for simplices in (vertices, edges, faces)]
    n_vertices, n_edges, n_faces = (np.bincount(own[own >= 0], minlength=len(limbs)) for own in owners)
    return np.asarray(n_vertices - n_edges + n_faces == 1)


def _is_solid(mesh: Mesh, limb_of_vertex: NDArray[np.int64], n_limbs: int) -> NDArray[np.bool_]:
    """Whether each limb encloses a part of the solid, between its faces and the middle of its rim.

    The volume between these has the sign of that of the limb's component; an open one encloses nothing, so that all of
    its limbs count.
    """
    component, n_components = mesh.component_of_vertex, mesh.n_components
    (i, j), own = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T, _limb_of_all_corners(limb_of_vertex, mesh.faces)
    rim = i[(limb_of_vertex[i] >= 0) & (limb_of_vertex[j] != limb_of_vertex[i])]
    counts = np.maximum(np.bincount(limb_of_vertex[rim], minlength=n_limbs), 1)
    middles = [np.bincount(limb_of_vertex[rim], x, n_limbs) / counts for x in mesh.vertices[rim].T]
    is_within = own >= 0
    limb, corners = own[is_within], mesh.vertices.take(mesh.faces[is_within], axis=0)
    volumes = _volumes(corners - np.stack(middles, axis=1)[limb][:, None], limb, n_limbs)
    wholes = _volumes(mesh.vertices.take(mesh.faces, axis=0), component[mesh.faces[:, 0]], n_components)
    is_open = np.bincount(component[mesh.edges[mesh.faces_per_edge == 1, 0]], minlength=n_components) > 0
    part = np.zeros(n_limbs, dtype=np.int64)
    part[limb] = component[mesh.faces[is_within, 0]]
    return np.asarray(is_open[part] | (volumes * wholes[part] >= 0))


def _limb_of_all_corners(limb_of_vertex: NDArray[np.int64], simplices: NDArray[np.int64]) -> NDArray[np.int64]:
    """(s,) the limb that all corners of each simplex belong to, -1 for none."""
    limb = np.array(limb_of_vertex[simplices[:, 0]])
    for corner in simplices.T[1:]:
        limb[limb_of_vertex[corner] != limb] = -1
    return limb


def _volumes(corners: NDArray[np.float64], part: NDArray[np.int64], n_parts: int) -> NDArray[np.float64]:
    """Signed volume between the faces of each part, with corners (m, 3, 3), and the origin."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.bincount(part, np.einsum("fi,fi->f", a, np.cross(b, c)) / 6, n_parts).astype(np.float64)
