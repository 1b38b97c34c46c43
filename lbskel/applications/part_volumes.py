"""Volumes of the parts of a surface, each closed by cones over its boundary.

Edges between parts, and boundary edges of the mesh, that are connected have one apex, the center of their lengths. An
edge between two parts so has the same cap on both sides, and the volumes sum to that of the mesh.
"""

from __future__ import annotations

__all__ = ["part_volumes"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.graphs import connected_labels
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.point_stars import distinct_points
from lbskel.geometry.sorting import unique_inverse


def part_volumes(mesh: Mesh, part_of_face: NDArray[np.int64], n_parts: int) -> NDArray[np.float64]:
    """(p,) volume of each part.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented, outwards. Vertices at one place count as one.
    part_of_face : (m,) array of int
    n_parts : int
    """
    first, place = distinct_points(mesh.vertices)
    n, points = len(first), mesh.vertices[first] - mesh.vertices[first].mean(axis=0)
    corners = points[place[mesh.faces]]
    own: NDArray[np.float64] = np.linalg.det(corners) / 6
    start, end = place[mesh.half_edges].T
    edges, edge = unique_inverse(np.minimum(start, end) * n + np.maximum(start, end))
    sides, side = unique_inverse(np.tile(part_of_face, 3) * len(edges) + edge)
    turns = np.bincount(side, np.sign(end - start))  # of each part at each edge, from the lower place to the higher one
    part, rim = np.divmod(sides[turns != 0], len(edges))
    ends = np.stack(np.divmod(edges, n), axis=1)
    is_rim = np.zeros(len(edges), dtype=bool)
    is_rim[rim] = True
    group = connected_labels(ends[is_rim], n)
    a, b = points[ends].transpose(1, 0, 2)
    length = np.where(is_rim, np.linalg.norm(b - a, axis=1), 0.0)
    weight = np.bincount(group[ends[:, 0]], length)
    sums = np.stack([np.bincount(group[ends[:, 0]], length * x) for x in ((a + b) / 2).T], axis=1)
    apex = sums / np.where(weight > 0, weight, 1.0)[:, None]
    caps: NDArray[np.float64] = np.linalg.det(np.stack([b, a, apex[group[ends[:, 0]]]], axis=1)[rim]) / 6
    volumes = np.bincount(part_of_face, own, minlength=n_parts).astype(np.float64)
    volumes += np.bincount(part, turns[turns != 0] * caps, minlength=n_parts)
    return volumes
