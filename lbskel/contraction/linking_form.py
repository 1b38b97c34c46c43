"""Linking numbers of all loops of a closed surface with all loops just outside it, as signed crossings.

The linking number of two closed curves is the number of times that the first passes above the second in a projection,
from left to right of the second, minus the number from right to left. Inner loops run along edges, outer ones across
edges, from the center of one face to the middle of a side to the center of the next face. They meet in the middle of an
edge alone; there the outer one, shifted outwards, passes above if the outside is above the edge. So one sparse matrix X
of the signed crossings of edges with pieces of outer loops gives all linking numbers, as exact integers.

M_ij, the linking number of gamma_i with delta_j shifted outwards (:mod:`lbskel.contraction.homology_basis`), is the
matrix of the projection of the loops of the surface on those that bound outside, along those that bound inside
(Alexander duality). So M M = M, and M J + J M^T = J with the intersections J of gamma_i with gamma_j. Together these
say that the rank is the genus. Both are tested on random vectors (Freivalds 1979, "Fast probabilistic algorithms",
https://doi.org/10.1007/3-540-09526-8_5); the probability that a wrong M passes is below 2^-30.
"""

from __future__ import annotations

__all__ = ["LinkingForm", "OuterLoops", "linking_form", "random_integers"]

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
class OuterLoops:
    """The loops across edges, projected, in a search tree.

    Parameters
    ----------
    basis : HomologyBasis
    view : (3, 3) array of float
        A rotation; its last column is the direction of the projection.
    sides : (s,) array of int
        The half-edge of each piece, which leads from the center of its face to its middle; in the order of the tree.
    pieces : (s, 6) array of float
        Both ends of each piece, in the rotated coordinates.
    boxes : (2 p, 6) array of float
        The boxes of the pieces, as :func:`lbskel._kernels.bvh.bounding_boxes` makes them.
    """

    basis: HomologyBasis
    view: NDArray[np.float64]
    sides: NDArray[np.int64]
    pieces: NDArray[np.float64]
    boxes: NDArray[np.float64]

    def crossings(
        self, segments: NDArray[np.float64], skipped: NDArray[np.int64] | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Integers]:
        """Find where the loops pass above segments.

        Parameters
        ----------
        segments : (q, 2, 3) array of float
        skipped : (q, 2) array of int, optional
            Faces whose pieces are not compared with each segment.

        Returns
        -------
        rows, edges : (c,) arrays of int
            For each crossing the segment, and the edge that the piece belongs to.
        signs : (c,) array of uint64
            1 if a loop that crosses the edge from left to right passes from the right of the segment to its left,
            else -1.
        """
        none = np.full((len(segments), 2), -1)
        row, piece, sign = crossings_above(
            np.ascontiguousarray((segments @ self.view).reshape(-1, 6)),
            none if skipped is None else skipped,
            self.pieces,
            self.sides % len(self.basis.mesh.faces),
            self.boxes,
        )
        # a piece leads from its face to the middle of the edge, as the flow to the right does in the face on the left
        side = self.sides[piece]
        return row, self.basis.mesh.edge_of_half_edge[side], sign.astype(np.uint64) * self.basis.sign[side]


@dataclass(frozen=True, eq=False)
class LinkingForm:
    """Linking numbers of the loops along edges with the loops across edges, shifted outwards.

    Parameters
    ----------
    outside : OuterLoops
    crossings : (k, k) sparse array of uint64
        For each edge, and each edge that an outer loop crosses from left to right: how often this loop passes above
        the first edge from its left to its right, minus how often from right to left.
    """

    outside: OuterLoops
    crossings: csr_array

    @property
    def basis(self) -> HomologyBasis:
        """The loops of the surface."""
        return self.outside.basis

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
        The surface of the basis, or another one with the same faces.
    view : (3, 3) array of float
        A rotation; its last column is the direction of the projection.
    """
    k, m = len(mesh.edges), len(mesh.faces)
    lower = np.flatnonzero(basis.flow_along(random_integers(len(basis.generators), 0)))  # other edges are in no loop
    outside = _outer_loops(basis, mesh, view)
    rows, columns, values = outside.crossings(mesh.vertices[mesh.edges[lower]], basis.sides[lower] % m)
    above = basis.generators[_is_outside_above(basis, mesh.vertices @ view)]
    values = np.concatenate([values, np.full(len(above), -1).astype(np.uint64)])
    rows, columns = np.append(lower[rows], above), np.append(columns, above)
    return LinkingForm(outside, coo_array((-values, (rows, columns)), shape=(k, k)).tocsr())


def _outer_loops(basis: HomologyBasis, mesh: Mesh, view: NDArray[np.float64]) -> OuterLoops:
    """Project the loops across edges."""
    V = mesh.vertices @ view
    sides = np.flatnonzero(basis.flow_across(random_integers(len(basis.generators), 0))[mesh.edge_of_half_edge])
    start, end = mesh.half_edges[sides].T
    points = np.concatenate([V[mesh.faces].mean(axis=1)[sides % len(mesh.faces)], (V[start] + V[end]) / 2])
    n = len(sides)
    ends = np.stack([np.arange(n), np.arange(n, 2 * n), np.arange(n, 2 * n)], axis=1)
    order = spatial_order(points, ends)
    corners, boxes = bounding_boxes(points, ends, order, BOX_MARGIN * float(np.abs(V).max()))
    return OuterLoops(basis, view, sides[order], np.ascontiguousarray(corners[:, :6]), boxes)


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
