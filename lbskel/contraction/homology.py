"""Tunnel loops of a closed surface: an integer cochain that tells them from loops that bound in the solid.

A loop on a closed surface of genus g bounds inside the solid if and only if it is linked with no loop just outside the
surface. A cochain gives every edge a number, with sum zero around every face, so that its sum along any loop is the
linking number of the loop with one outer loop. Where the outer loop is a combination of all, with random coefficients
modulo 2^64, the sum is zero for a loop around a limb, and for a loop around a tunnel it is zero with a probability of
about 2^-64 only. So one column stands for all g.
"""

from __future__ import annotations

__all__ = ["Tunnels", "find_tunnels", "outer_loops", "transfer_cochain"]

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from lbskel.contraction.homology_basis import HomologyBasis, Integers, homology_basis
from lbskel.contraction.linking_form import LinkingForm, OuterLoops, linking_form, random_integers
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

BLOCK = 64  # cochains made at a time, a column each, which bounds memory and the time between checks; a guess
N_VIEWS = 2  # projections of each copy: where one meets a coincidence, another does not
SMOOTHING_ROUNDS = (0, 3, 10, 30)  # smoothed copies to try; measured on tori with noise up to two edge lengths
MAX_FOLD_COSINE = -0.2  # an edge is folded if the normals of its faces have a smaller cosine; a guess
# fraction of folded edges above which a surface may intersect itself; measured below 0.002 on clean surfaces, above
# 0.04 on surfaces that intersect themselves
MAX_FOLDED_FRACTION = 0.02


@dataclass(frozen=True, eq=False)
class Tunnels:
    """Which loops of a surface are around its tunnels.

    Parameters
    ----------
    genus : int
        Number of tunnels, g below.
    n_edges : int
        Number of edges of the surface, k below.
    form : LinkingForm or None
        None for a surface without tunnels.
    """

    genus: int
    n_edges: int
    form: LinkingForm | None

    def cochain(self) -> NDArray[np.int64]:
        """(k, 1) value of each edge, modulo 2^64; the sum is zero along loops that bound inside, up to chance."""
        return self._columns([random_integers(2 * self.genus, 0)])

    def independent_cochains(self, limit: int, *, deadline: Deadline = NEVER) -> Iterator[NDArray[np.int64]]:
        """Yield g columns in blocks: values of each edge, the rank of whose sums over loops is theirs, up to chance.

        Parameters
        ----------
        limit : int
            Bound on the coefficients of the outer loops, which are random.
        deadline : Deadline
            After it, OutOfTime is raised in place of the next block.
        """
        for first in deadline.until(range(0, self.genus, BLOCK)):
            numbers = range(1 + first, 1 + min(first + BLOCK, self.genus))
            yield self._columns([random_integers(2 * self.genus, i) % np.uint64(limit) for i in numbers])

    def _columns(self, combinations: list[Integers]) -> NDArray[np.int64]:
        """(k, c) cochains of linking numbers with combinations of the outer loops."""
        if self.form is None:
            return np.zeros((self.n_edges, len(combinations)), dtype=np.int64)
        columns = [self.form.basis.flow_across(self.form.apply(x)) for x in combinations]
        return np.stack(columns, axis=1).view(np.int64)


def find_tunnels(mesh: Mesh, *, deadline: Deadline = NEVER) -> Tunnels | None:
    """Compute the linking numbers of the loops on a surface with those just outside it.

    A surface with many folded edges, as noise leaves it, may intersect itself. Then smoothed copies are evaluated too,
    until one agrees with an earlier one; if none does, the last one that could be evaluated counts.

    Parameters
    ----------
    mesh : Mesh
        One closed manifold component.
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    Tunnels or None
        None if the linking numbers of neither the surface nor its smoothed copies are those of an embedded surface.
    """
    genus, n_edges = mesh.genus, len(mesh.edges)
    assert genus is not None, "a closed manifold has a genus"
    if genus == 0:
        return Tunnels(0, n_edges, None)
    deadline.check()
    basis = _outward_basis(mesh)
    found: list[LinkingForm] = []
    for smoothed in _smoothed_copies(basis.mesh):
        form = _consistent_form(basis, smoothed, deadline)
        Surface(mesh).memoize("outer loops", partial(getattr, form, "outside", None))  # those of the first, unsmoothed
        if form is None:
            continue
        is_confirmed = any(form.has_kernel_of(other) for other in found)
        found.append(form)
        if is_confirmed or not _has_folds(mesh):
            break
    return Tunnels(genus, n_edges, found[-1]) if found else None


def outer_loops(mesh: Mesh, *, deadline: Deadline = NEVER) -> OuterLoops | None:
    """Project the loops just outside a surface; computed once per mesh, by this function or :func:`find_tunnels`.

    Parameters
    ----------
    mesh : Mesh
        One closed manifold component.
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    OuterLoops or None
        In a direction in which their linking numbers are those of an embedded surface; None if there is none.
    """

    def make() -> OuterLoops | None:
        basis = _outward_basis(mesh)
        form = _consistent_form(basis, basis.mesh, deadline)
        return None if form is None else form.outside

    deadline.check()
    found: OuterLoops | None = Surface(mesh).memoize("outer loops", make)
    return found


def _outward_basis(mesh: Mesh) -> HomologyBasis:
    """Build the loops of a surface, with its faces turned outwards."""
    return homology_basis(mesh if mesh.volume >= 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1]))


def _consistent_form(basis: HomologyBasis, mesh: Mesh, deadline: Deadline) -> LinkingForm | None:
    """Count linking numbers in the first projection in which they are those of an embedded surface."""
    for seed in deadline.until(range(N_VIEWS)):
        axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        if (form := linking_form(basis, mesh, axes * np.linalg.det(axes))).is_consistent():
            return form
    return None


def _smoothed_copies(mesh: Mesh) -> Iterator[Mesh]:
    """Yield the mesh, then copies with each vertex moved half way to the mean of its neighbors, ever more times."""
    n = len(mesh.vertices)
    i, j = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
    degrees = np.maximum(graph.sum(axis=1), 1)[:, None]
    vertices, done = mesh.vertices, 0
    for rounds in SMOOTHING_ROUNDS:
        for _ in range(rounds - done):
            vertices = (vertices + graph @ vertices / degrees) / 2
        done = rounds
        yield mesh.with_vertices(vertices)


def _has_folds(mesh: Mesh) -> bool:
    """Whether the surface is folded back on itself at more than a few edges."""
    normals = mesh.face_normals
    first, second = stable_order(mesh.edge_of_half_edge).reshape(-1, 2).T % len(mesh.faces)
    cosines = np.einsum("ij,ij->i", normals[first], normals[second])
    return float((cosines < MAX_FOLD_COSINE).mean()) > MAX_FOLDED_FRACTION


def transfer_cochain(
    cochain: NDArray[np.int64], mesh: Mesh, edges: NDArray[np.int64], vertex_map: VertexMap
) -> NDArray[np.int64]:
    """Transfer a cochain to a graph each of whose nodes stands for a connected patch of vertices.

    Parameters
    ----------
    cochain : (k, c) array of int
        On ``mesh.edges``. It sums to zero along loops within a patch, and along loops to an adjacent patch and back.
    mesh : Mesh
    edges : (l, 2) array of int
        Edges of the graph, with ascending ends; each joins two patches that an edge of ``mesh`` joins.
    vertex_map : VertexMap
        From the vertices of ``mesh`` to the nodes.

    Returns
    -------
    (l, c) array of int
        For each edge: the sum along a path between the centers of two patches that stays in the patches.
    """
    patch = vertex_map.indices
    n = len(patch)
    i, j = mesh.edges.T
    within = np.flatnonzero(patch[i] == patch[j])
    center = np.unique(patch, return_index=True)[1]
    to_center = np.stack([np.full(len(center), n), center], axis=1)
    links = np.concatenate([np.stack([i[within], j[within]], axis=1), to_center])
    graph = weighted_graph(links, np.ones(len(links), dtype=np.int8), n + 1)
    parent = breadth_first_order(graph, n, directed=False)[1][:n].astype(np.int64)
    parent = np.where(parent == n, np.arange(n), parent)
    keys = i * n + j
    row = np.searchsorted(keys, np.minimum(parent, np.arange(n)) * n + np.maximum(parent, np.arange(n)))
    sign = np.sign(np.arange(n) - parent)  # zero at a center, which has no parent
    offset = sign[:, None] * cochain[np.minimum(row, len(keys) - 1)]  # from the parent
    while (parent != parent[parent]).any():  # by pointer jumping, from the center in the end
        offset, parent = offset + offset[parent], parent[parent]
    a, b = patch[i], patch[j]
    between = np.flatnonzero(a != b)
    value: NDArray[np.int64] = (offset[i] + cochain - offset[j])[between]
    a, b = a[between], b[between]
    value[a > b] *= -1
    size = int(patch.max()) + 1
    found, first = np.unique(np.minimum(a, b) * size + np.maximum(a, b), return_index=True)
    return value[first[np.searchsorted(found, edges[:, 0] * size + edges[:, 1])]]
