"""The plane of symmetry of a mesh, and the mirror images of its vertices.

Candidates are the planes through the centroid whose normals are the axes of the coordinates and the principal axes of
the surface. A mesh is symmetric where the mirror images of its vertices lie on it.
"""

from __future__ import annotations

__all__ = ["MirrorPlane", "find_mirror_plane"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface

# Swept in benchmarks/results/rig.md, "Constants"
MAX_DEVIATION = 0.01  # distance of a mirror image from the surface, relative to the diameter bound
MIN_SHARE = 0.95  # of the vertices that must have such a mirror image
TWIN_DISTANCE = 1e-3  # distance of a vertex from the mirror image of its twin, relative to the diameter bound


@dataclass(frozen=True, eq=False)
class MirrorPlane:
    """A plane of symmetry.

    Parameters
    ----------
    point, normal : (3,) array of float
        The normal points to the side that is called left; its largest component is positive.
    twins : (n,) array of int
        For each vertex the vertex at its mirror image; -1 where there is none.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    twins: NDArray[np.int64]

    def heights(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) signed distance of points from the plane, positive on the left."""
        heights: NDArray[np.float64] = (points - self.point) @ self.normal
        return heights

    def mirrored(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, 3) mirror images of points."""
        return points - 2 * self.heights(points)[:, None] * self.normal


def find_mirror_plane(mesh: Mesh) -> MirrorPlane | None:
    """Find the plane about which a mesh is symmetric; None if there is none.

    Axes of the coordinates are tried first. A later plane replaces one found before only if the mean deviation of the
    mirror images from the surface is less than half as large.

    Parameters
    ----------
    mesh : Mesh
    """
    V, limit = mesh.vertices, mesh.diameter_bound
    if not (limit > 0 and mesh.area > 0):
        return None
    used = mesh.used_vertices
    offsets = (V[mesh.faces].mean(axis=1) - mesh.centroid) / limit
    principal = np.linalg.eigh((offsets * (mesh.face_areas / mesh.area)[:, None]).T @ offsets)[1].T
    best: tuple[float, NDArray[np.float64]] | None = None
    for normal in (*np.eye(3), *principal):
        normal = normal * np.sign(normal[np.argmax(np.abs(normal))])
        images = V[used] - 2 * ((V[used] - mesh.centroid) @ normal)[:, None] * normal
        distance = Surface(mesh).distance(images) / limit
        if (distance <= MAX_DEVIATION).mean() >= MIN_SHARE and (best is None or distance.mean() < 0.5 * best[0]):
            best = float(distance.mean()), normal
    if best is None:
        return None
    plane = MirrorPlane(mesh.centroid, best[1], np.full(len(V), -1))
    distance, twin = cKDTree(V).query(plane.mirrored(V))
    is_twin = (distance <= TWIN_DISTANCE * limit) & (twin[twin] == np.arange(len(twin)))
    return MirrorPlane(mesh.centroid, best[1], np.where(is_twin, twin, -1))
