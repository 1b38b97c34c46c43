"""The vertices and triangles of a surface, connected so that paths along edges depend little on its triangulation.

A path along the edges of a mesh zigzags where no edge leads its way, and takes the long way around a fan of thin
triangles. The edges of the intrinsic Delaunay triangulation of the same surface lead to near vertices, and the
diagonals across them to those behind.
"""

from __future__ import annotations

__all__ = ["SurfaceGraph", "surface_graph"]

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.graphs import positive_edge_lengths
from lbskel.geometry.intrinsic_triangulation import (
    IntrinsicTriangulation,
    cotangents_of_lengths,
    delaunay,
    half_edge_twins,
)
from lbskel.geometry.mesh import Mesh

# Added to every edge, relative to the diameter bound: graphs drop length 0. A guess, far below what lengths are rounded
# to
MIN_EDGE_LENGTH = 1e-12


@dataclass(frozen=True, eq=False)
class SurfaceGraph:
    """A triangulation of a surface, and its diagonals.

    Parameters
    ----------
    faces : (m, 3) array of int
    edges : (k, 2) array of int
        Each once.
    lengths : (k,) array of float
        Positive.
    diagonals : (d, 2) array of int
        Pairs of vertices opposite an edge whose triangles, unfolded in a plane, are convex.
    diagonal_lengths : (d,) array of float
        In that plane.
    """

    faces: NDArray[np.int64]
    edges: NDArray[np.int64]
    lengths: NDArray[np.float64]
    diagonals: NDArray[np.int64]
    diagonal_lengths: NDArray[np.float64]


def surface_graph(mesh: Mesh) -> SurfaceGraph:
    """Connect the vertices of a mesh along its intrinsic Delaunay triangulation.

    Parameters
    ----------
    mesh : Mesh
        Its own edges are used, without diagonals, if one of them has more than two faces, or two that are not oriented
        consistently.
    """
    twins = half_edge_twins(mesh.faces)
    if twins is None:
        lengths = positive_edge_lengths(mesh)
        return SurfaceGraph(mesh.faces, mesh.edges, lengths, np.empty((0, 2), dtype=np.int64), np.empty(0))
    lengths = igl.edge_lengths(mesh.vertices, mesh.faces) + MIN_EDGE_LENGTH * mesh.diameter_bound
    triangulation = delaunay(IntrinsicTriangulation(mesh.faces, lengths, twins))
    F, lengths, twins = triangulation.faces, triangulation.lengths.ravel(), triangulation.twins
    is_first = (twins < 0) | (np.arange(len(twins)) < twins)
    edges = np.stack([F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()], axis=1)
    return SurfaceGraph(F, edges[is_first], lengths[is_first], *_diagonals(triangulation))


def _diagonals(triangulation: IntrinsicTriangulation) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Unfold the two triangles at each edge, and measure their other diagonal where they are convex."""
    lengths, twins = triangulation.lengths.ravel(), triangulation.twins
    half_edges = np.arange(len(twins)).reshape(-1, 3)
    following, preceding = half_edges[:, [1, 2, 0]].ravel(), half_edges[:, [2, 0, 1]].ravel()
    angles = np.arctan2(1.0, cotangents_of_lengths(triangulation.lengths)).ravel()
    first = np.flatnonzero(np.arange(len(twins)) < twins)
    second = twins[first]
    # an edge leads from the corner that follows the one opposite it to the corner that precedes that
    at_start = angles[following[first]] + angles[preceding[second]]
    at_end = angles[preceding[first]] + angles[following[second]]
    a, b = lengths[preceding[first]], lengths[following[second]]  # the sides that meet at its start
    diagonals = np.sqrt((a - b) ** 2 + 4 * a * b * np.sin(at_start / 2) ** 2)
    ends = np.stack([triangulation.faces.ravel()[first], triangulation.faces.ravel()[second]], axis=1)
    is_convex = np.maximum(at_start, at_end) < np.pi
    return ends[is_convex], diagonals[is_convex]
