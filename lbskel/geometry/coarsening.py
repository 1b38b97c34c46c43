"""Coarsening between contraction steps: short edges are collapsed, so that later steps solve smaller systems.

Edges collapse in rounds; no two collapses of a round touch each other. An edge collapses only if its ends have no other
common neighbors than the third corners of its faces, and these corners keep another face. On a closed manifold this is
the link condition, so the surface keeps its topology and every handle (Dey, Edelsbrunner, Guha, Nekhayev 1999,
"Topology preserving edge contraction", Publ. Inst. Math. 66). A limb that has become thin keeps rings of three
vertices.
"""

from __future__ import annotations

__all__ = ["Coarsened", "coarsen"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.edge_collapse import independent_collapses, short_edges
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.vertex_map import VertexMap

MAX_ROUNDS = 6  # rounds of collapses between two steps; a guess: edges still short collapse after the next step
N_SELECTIONS = 3  # independent sets of edges chosen in one round; with maximal sets skeletons were less accurate
MIN_PROGRESS = 0.02  # fraction of the vertices that a round must remove for another to follow; a guess
MIN_VERTICES = 200  # no coarsening below this: the time saved is negligible, the ends of limbs get too coarse; a guess
LENGTH_DIGITS = 9  # decimals of a length, in diameter bounds, that order edges, so that rounding does not decide ties


@dataclass(frozen=True, eq=False)
class Coarsened:
    """A mesh with merged vertices, and the map from the vertices of the original mesh.

    Parameters
    ----------
    mesh : Mesh
        Of k vertices, each at the weighted mean position of the original vertices merged into it.
    vertex_map : VertexMap
        From the n vertices of the original mesh to those of ``mesh``.
    kept : (k,) array of int
        For each vertex of ``mesh`` one original vertex, the one that the others were merged into.
    weights : (k,) array of float
        Sum of the weights of the merged vertices; the contraction uses the initial ring areas, in squared diameter
        bounds.
    was_closed_manifold : bool
        Whether the original mesh is a closed manifold, which the link condition keeps so.
    """

    mesh: Mesh
    vertex_map: VertexMap
    kept: NDArray[np.int64]
    weights: NDArray[np.float64]
    was_closed_manifold: bool

    @classmethod
    def unmerged(cls, mesh: Mesh, weights: NDArray[np.float64]) -> Coarsened:
        """Represent a mesh none of whose vertices has been merged.

        Parameters
        ----------
        mesh : Mesh
        weights : (n,) array of float
        """
        n = len(mesh.vertices)
        return cls(mesh, VertexMap.identity(n), np.arange(n), weights, mesh.is_closed_manifold)


def coarsen(current: Coarsened, max_lengths: NDArray[np.float64]) -> Coarsened:
    """Collapse edges that are shorter than the limits of both their ends.

    Parameters
    ----------
    current : Coarsened
        All of its vertices belong to a face.
    max_lengths : (n,) array of float
        Limit for each vertex of the original mesh, in the units of ``current.mesh``.
    """
    V, F, W = np.array(current.mesh.vertices), current.mesh.faces, np.array(current.weights)
    kept, vertex_map = current.kept, current.vertex_map
    for _ in range(MAX_ROUNDS):
        if len(V) <= MIN_VERTICES:
            break
        removed, target = _choose_collapses(V, F, max_lengths[kept], not current.was_closed_manifold)
        if len(removed) <= MIN_PROGRESS * len(V):
            break
        both = W[removed] + W[target]
        share = np.divide(W[removed], both, out=np.full(len(removed), 0.5), where=both > 0)[:, None]
        V[target] += share * (V[removed] - V[target])
        W[target] += W[removed]
        is_kept = np.ones(len(V), dtype=bool)
        is_kept[removed] = False
        new_index = np.cumsum(is_kept) - 1
        new_index[removed] = new_index[target]
        F = new_index[F]
        F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
        V, W, kept = V[is_kept], W[is_kept], kept[is_kept]
        vertex_map = vertex_map.compose(VertexMap(new_index))
    if len(V) == len(current.mesh.vertices):
        return current
    mesh = Mesh(V, F)
    if current.was_closed_manifold:  # the check would take longer than a round
        mesh.__dict__["is_closed_manifold"] = True
    return Coarsened(mesh, vertex_map, kept, W, current.was_closed_manifold)


def _choose_collapses(
    V: NDArray[np.float64], F: NDArray[np.int64], max_lengths: NDArray[np.float64], both_directions: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Choose edges for one round, shorter ones first; return the vertices to remove and those to merge them into."""
    edges, edge_numbers, lengths = short_edges(V, F, max_lengths, both_directions)
    # Knuth's multiplicative hash orders edges of equal length, so that in a row of such edges more than one can precede
    # all of its neighbors
    hashed = edge_numbers * 2654435761 % 2**32
    rank = np.rint(lengths * 10**LENGTH_DIGITS).astype(np.int64) << 32 | hashed  # one integer, fast to sort
    target, removed = edges[stable_order(rank)].T.copy()
    is_chosen = independent_collapses(F, len(V), target, removed, N_SELECTIONS)
    return removed[is_chosen], target[is_chosen]
