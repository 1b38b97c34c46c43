"""Linking numbers of all loops of a closed surface with all loops just outside it, as signed crossings.

The linking number of two closed curves is the number of times that one passes above the other in a projection, from
its right to its left, minus the number from left to right. Inner loops run along edges, outer ones across edges, from
the center of one face to the middle of a side to the center of the next face. They meet in the middle of an edge
alone; there the outer one, shifted outwards, passes above if the outside is above the edge. So one sparse matrix X of
the signed crossings of edges with pieces of outer loops gives all linking numbers, as exact integers.

M_ij, the linking number of gamma_i with delta_j shifted outwards (:mod:`lbskel.contraction.homology_basis`), is the
matrix of the projection of the loops of the surface on those that bound outside, along those that bound inside
(Alexander duality). So M M = M, and M J + J M^T = J with the intersections J of gamma_i with gamma_j. Together these
say that the rank is the genus. Both are tested on random vectors (Freivalds 1979, "Fast probabilistic algorithms",
https://doi.org/10.1007/3-540-09526-8_5); the probability that a wrong M passes is below 2^-30.
"""

from __future__ import annotations

__all__ = ["LinkingForm", "linking_cochain", "linking_form"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from lbskel._kernels.bvh import bounding_boxes, spatial_order
from lbskel._kernels.linking import crossings_above
from lbskel.contraction.homology_basis import HomologyBasis, Integers
from lbskel.geometry.mesh import Mesh

BOX_MARGIN = 1e-12  # of the boxes of segments, relative to the largest coordinate, above rounding errors; a guess


@dataclass(frozen=True, eq=False)
class LinkingForm:
    """Linking numbers of the loops along edges with the loops across edges, shifted outwards.

    Parameters
    ----------
    basis : HomologyBasis
    crossings : (k, k) sparse array of uint64
        For each edge, and each edge that an outer loop crosses from left to right: how often this passes above.
    """

    basis: HomologyBasis
    crossings: csr_array

    def apply(self, x: Integers) -> Integers:
        """(2g,) linking number of each gamma_i with sum x_j delta_j."""
        return self.basis.sums_along(self.crossings @ self.basis.flow_across(x))

    def apply_transposed(self, x: Integers) -> Integers:
        """(2g,) linking number of sum x_i gamma_i with each delta_j."""
        return self.basis.sums_across(self.crossings.T @ self.basis.flow_along(x))

    def is_consistent(self) -> bool:
        """Whether the linking numbers are those of an embedded surface, up to chance."""
        x = random_integers(len(self.basis.generators), 1)
        projected = self.apply(x)
        if not np.array_equal(self.apply(projected), projected):
            return False
        met = self.basis.intersections(x)
        adjoint = self.basis.intersections(self.apply_transposed(x))
        return np.array_equal(self.apply(met) + adjoint, met)

    def has_kernel_of(self, other: LinkingForm) -> bool:
        """Whether the same loops bound inside according to both, up to chance; both are consistent."""
        projected = self.apply(random_integers(len(self.basis.generators), 2))
        return np.array_equal(other.apply(projected), projected)


def random_integers(n: int, seed: int) -> Integers:
    """(n,) integers, the same each time."""
    return np.random.default_rng(seed).integers(0, 2**64, n, dtype=np.uint64)


def linking_form(basis: HomologyBasis, mesh: Mesh, view: NDArray[np.float64]) -> LinkingForm:
    """Count the crossings of inner and outer loops in one projection.

    Parameters
    ----------
    basis : HomologyBasis
    mesh : Mesh
        The surface that the basis is of, or another with its faces.
    view : (3, 3) array of float
        A rotation; its last column is the direction of the projection.
    """
    k, m = len(mesh.edges), len(mesh.faces)
    V = mesh.vertices @ view
    lower = np.flatnonzero(basis.flow_along(random_integers(len(basis.generators), 0)))  # other edges are in no loop
    rows, columns, values = _crossings(basis, V, V[mesh.edges[lower]], basis.sides[lower] % m)
    above = basis.generators[_is_outside_above(basis, V)]
    values = np.concatenate([values, np.full(len(above), -1).astype(np.uint64)])
    rows, columns = np.append(lower[rows], above), np.append(columns, above)
    return LinkingForm(basis, coo_array((-values, (rows, columns)), shape=(k, k)).tocsr())


def linking_cochain(
    basis: HomologyBasis,
    points: NDArray[np.float64],
    edges: NDArray[np.int64],
    combinations: list[Integers],
    view: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Count the crossings of the edges of a graph inside a surface with combinations of its outer loops.

    Parameters
    ----------
    basis : HomologyBasis
        Of the surface.
    points : (n, 3) array of float
        The nodes of the graph.
    edges : (e, 2) array of int
    combinations : list of c arrays of 2g uint64
        Coefficients of the outer loops.
    view : (3, 3) array of float
        As for :func:`linking_form`.

    Returns
    -------
    (e, c) array of int
        The sum along a cycle is its linking number with each combination.
    """
    nobody = np.full((len(edges), 2), -1)
    rows, columns, values = _crossings(basis, basis.mesh.vertices @ view, (points @ view)[edges], nobody)
    crossings = coo_array((values, (rows, columns)), shape=(len(edges), len(basis.mesh.edges))).tocsr()
    return np.stack([crossings @ basis.flow_across(x) for x in combinations], axis=1).view(np.int64)


def _crossings(
    basis: HomologyBasis, V: NDArray[np.float64], segments: NDArray[np.float64], skipped: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], Integers]:
    """Find where outer loops pass above segments, along the third axis.

    Returns the row of each segment, the edge that the outer loop crosses there from left to right, and the sign.
    """
    mesh, m = basis.mesh, len(basis.mesh.faces)
    sides = np.flatnonzero(basis.flow_across(random_integers(len(basis.generators), 0))[mesh.edge_of_half_edge])
    start, end = mesh.half_edges[sides].T
    pieces = np.concatenate([V[mesh.faces].mean(axis=1)[sides % m], (V[start] + V[end]) / 2])
    n = len(sides)
    ends = np.stack([np.arange(n), np.arange(n, 2 * n), np.arange(n, 2 * n)], axis=1)
    order = spatial_order(pieces, ends)
    corners, boxes = bounding_boxes(pieces, ends, order, BOX_MARGIN * float(np.abs(V).max()))
    row, piece, sign = crossings_above(
        np.ascontiguousarray(segments.reshape(-1, 6)),
        skipped,
        np.ascontiguousarray(corners[:, :6]),
        sides[order] % m,
        boxes,
    )
    # a piece leads from its face to the middle of the edge, as the flow to the right does in the face on the left
    side = sides[order[piece]]
    return row, mesh.edge_of_half_edge[side], sign.astype(np.uint64) * basis.sign[side]


def _is_outside_above(basis: HomologyBasis, V: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(2g,) whether the outside of the surface lies above the middle of each generator."""
    m = len(basis.mesh.faces)
    start, end = V[basis.mesh.edges[basis.generators]].transpose(1, 0, 2)
    side, corner = basis.sides[basis.generators] % m, basis.sides[basis.generators] // m
    left, right = (V[basis.mesh.faces[side[:, i], corner[:, i]]] - start for i in (0, 1))
    t = end - start
    left_of, right_of = (t[:, 0] * to[:, 1] - t[:, 1] * to[:, 0] > 0 for to in (left, right))
    is_convex = np.einsum("ij,ij->i", t, np.cross(left, right)) < 0
    above: NDArray[np.bool_] = np.where(left_of == right_of, is_convex, left_of)
    return above
