"""Coarsening between the steps of a contraction: what has collapsed is collapsed, so that later steps cost less.

Short edges become vertices, in rounds of collapses that do not touch each other. Only edges whose ends have no more
than two neighbors in common collapse, the link condition: the surface keeps its topology, so every tunnel stays (Dey,
Edelsbrunner, Guha, Nekhayev 1999, "Topology preserving edge contraction", Publ. Inst. Math. 66). A limb that has become
thin keeps rings of three vertices.
"""

from __future__ import annotations

__all__ = ["Coarsened", "coarsen"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.edge_collapse import independent_collapses, short_edges
from lbskel.geometry.mesh import Mesh

ROUNDS = 6  # at most, at a time: what is left is for after the next step
SELECTIONS = 3  # of collapses among the edges of one round; with all that are possible accuracy was worse
WORTHWHILE = 0.02  # of the vertices must go in a round for another to pay
FEWEST = 200  # vertices that are left at least: fewer take no time worth saving, and show the ends of limbs less well
DIGITS = 9  # of a length that count, on a mesh of extent 1: of equal ones the order does not depend on rounding


@dataclass(frozen=True, eq=False)
class Coarsened:
    """A mesh of fewer vertices than the one it came from, and what they stand for.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : (n,) array of int
        For each vertex of the first mesh, the one it went into.
    kept : (k,) array of int
        The vertex of the first mesh that each is named after; its place is the mean of all that went into it.
    weights : (k,) array of float
        Sums over these.
    """

    mesh: Mesh
    vertex_map: NDArray[np.int64]
    kept: NDArray[np.int64]
    weights: NDArray[np.float64]


def coarsen(before: Coarsened, limits: NDArray[np.float64]) -> Coarsened:
    """Collapse edges that are shorter than the limits at both their ends.

    Parameters
    ----------
    before : Coarsened
        A closed manifold that uses all its vertices.
    limits : (n,) array of float
        For each vertex of the first mesh.
    """
    V, F, W = np.array(before.mesh.vertices), before.mesh.faces, np.array(before.weights)
    kept, vertex_map = before.kept, before.vertex_map
    for _ in range(ROUNDS):
        if len(V) <= FEWEST:
            break
        gone, target = _round(V, F, limits[kept])
        if len(gone) <= WORTHWHILE * len(V):
            break
        both = W[gone] + W[target]
        share = np.divide(W[gone], both, out=np.full(len(gone), 0.5), where=both > 0)[:, None]
        V[target] += share * (V[gone] - V[target])
        W[target] += W[gone]
        stays = np.ones(len(V), dtype=bool)
        stays[gone] = False
        new_of = np.cumsum(stays) - 1
        new_of[gone] = new_of[target]
        F = new_of[F]
        F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
        V, W, kept, vertex_map = V[stays], W[stays], kept[stays], new_of[vertex_map]
    if len(V) == len(before.mesh.vertices):
        return before
    return Coarsened(Mesh(V, F), vertex_map, kept, W)


def _round(
    V: NDArray[np.float64], F: NDArray[np.int64], limits: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vertices that go and those they go into: the shortest edges first, none next to another."""
    edges, places, lengths = short_edges(V, F, limits)
    mixed = places * 2654435761 % 2**32  # of equal lengths in a row of edges more than the first can be the least about
    rank = np.rint(lengths * 10**DIGITS).astype(np.int64) << 32 | mixed  # one number each, which is fast to sort by
    target, gone = edges[np.argsort(rank)].T.copy()
    is_chosen = independent_collapses(F, len(V), target, gone, SELECTIONS)
    return gone[is_chosen], target[is_chosen]
