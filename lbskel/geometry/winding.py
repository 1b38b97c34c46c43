"""Winding numbers of any triangles, closed or open, with few operations where the surface has few holes.

The winding number of Jacobson, Kavan, Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized
winding numbers", https://doi.org/10.1145/2461912.2461916, is linear in the faces. So it is that of the surface closed
by fans of triangles, an integer counted along a ray, less that of the fans. Only these need the tree of libigl's fast
winding number, Barill, Dickson, Schmidt, Levin, Jacobson 2018, https://doi.org/10.1145/3197517.3201337. On the 45,000
faces and 320 rim edges of a neuron both took a seventh of the time of that tree over all faces, as measured.
"""

from __future__ import annotations

__all__ = ["WindingNumbers", "winding_numbers_of"]

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.geometry.bvh import AABBTree, build_aabb_tree
from lbskel.geometry.deadline import NEVER, Deadline, in_slices
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class WindingNumbers:
    """Winding numbers of faces as those of a closed surface and of other faces together.

    Parameters
    ----------
    closed : AABBTree, optional
        Of consistently oriented faces without a boundary.
    others : igl.FastWindingNumberBVH, optional
        Of the other faces.
    """

    closed: AABBTree | None
    others: igl.FastWindingNumberBVH | None

    def around(self, points: NDArray[np.float64], *, deadline: Deadline = NEVER) -> NDArray[np.float64]:
        """(k,) winding number around each point.

        Parameters
        ----------
        points : (k, 3) array of float
        deadline : Deadline
        """
        numbers = np.zeros(len(points))
        if self.closed is not None:
            numbers += self.closed.winding_numbers(points, deadline=deadline)
        if (tree := self.others) is not None:
            (of_others,) = in_slices(lambda some: (tree.winding_number(some),), points, deadline=deadline)
            numbers += of_others
        return numbers


def winding_numbers_of(mesh: Mesh) -> WindingNumbers:
    """Build the trees for the winding numbers of a mesh.

    The surface is closed by fans if these have fewer faces than it has.

    Parameters
    ----------
    mesh : Mesh
    """
    rim = _rim(mesh)
    if len(rim) >= len(mesh.faces):
        return WindingNumbers(None, _fast_tree(mesh.vertices, mesh.faces))
    vertices, fans = _fans(mesh.vertices, rim)
    closed = build_aabb_tree(vertices, np.concatenate([mesh.faces, fans]))
    return WindingNumbers(closed, _fast_tree(vertices, fans[:, ::-1]) if len(fans) else None)


def _rim(mesh: Mesh) -> NDArray[np.int64]:
    """(r, 2) directed edges that the faces need to be closed, against the direction of those faces.

    An edge with more faces of one direction than of the other is listed as often as the excess.
    """
    start, end = mesh.half_edges.T
    sign = np.where(start < end, 1.0, -1.0)
    excess = np.bincount(mesh.edge_of_half_edge, sign, minlength=len(mesh.edges)).astype(np.int64)
    edges = mesh.edges[excess != 0]
    excess = excess[excess != 0]
    rim: NDArray[np.int64] = np.repeat(np.where(excess[:, None] > 0, edges[:, ::-1], edges), np.abs(excess), axis=0)
    return rim


def _fans(vertices: NDArray[np.float64], rim: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Fans of triangles over the edges of a rim, around the mean of the midpoints of the edges that are connected.

    Returns
    -------
    tuple
        The vertices followed by the centers, and the (r, 3) fan faces.
    """
    used, row = np.unique(rim, return_inverse=True)
    graph = weighted_graph(row.reshape(-1, 2), np.ones(len(rim)), len(used))
    n_fans, fan_of_vertex = connected_components(graph, directed=False)
    fan = fan_of_vertex[row.reshape(-1, 2)[:, 0]].astype(np.int64)
    midpoints = vertices[rim].mean(axis=1)
    sums = np.stack([np.bincount(fan, x, minlength=n_fans) for x in midpoints.T], axis=1)
    centers = sums / np.bincount(fan, minlength=n_fans)[:, None]
    return np.concatenate([vertices, centers]), np.column_stack([rim, len(vertices) + fan])


def _fast_tree(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> igl.FastWindingNumberBVH:
    """Build libigl's tree of a set of triangles."""
    tree = igl.FastWindingNumberBVH()
    tree.init(vertices, np.ascontiguousarray(faces))
    return tree
