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
from lbskel.geometry.mirrors import Mirror, mirrors_at_centroid, principal_axes
from lbskel.geometry.surface_queries import Surface

# Swept in benchmarks/results/rig.md, "Constants"
MAX_DEVIATION = 0.01  # distance of a mirror image from the surface, relative to the diameter bound
MIN_SHARE = 0.95  # of the vertices that must have such a mirror image
TWIN_DISTANCE = 1e-3  # distance of a vertex from the mirror image of its twin, relative to the diameter bound


@dataclass(frozen=True, eq=False)
class MirrorPlane(Mirror):
    """A plane of symmetry; its normal points to the side that is called left, and has a positive largest component.

    Parameters
    ----------
    point, normal : (3,) array of float
    twins : (n,) array of int
        For each vertex the vertex at its mirror image; -1 where there is none.
    """

    twins: NDArray[np.int64]


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
    used = V[mesh.used_vertices]
    best: tuple[float, Mirror] | None = None
    for mirror in mirrors_at_centroid(mesh, [*np.eye(3), *principal_axes(mesh)]):
        distance = Surface(mesh).distance(mirror.mirrored(used)) / limit
        if (distance <= MAX_DEVIATION).mean() >= MIN_SHARE and (best is None or distance.mean() < 0.5 * best[0]):
            best = float(distance.mean()), mirror
    if best is None:
        return None
    _, plane = best
    distance, twin = cKDTree(V).query(plane.mirrored(V))
    is_twin = (distance <= TWIN_DISTANCE * limit) & (twin[twin] == np.arange(len(twin)))
    return MirrorPlane(plane.point, plane.normal, np.where(is_twin, twin, -1))
