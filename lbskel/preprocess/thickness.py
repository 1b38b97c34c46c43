"""How thick a shape is at each face: how far a ray inwards from it goes, the shape diameter.

Shapira, Shamir, Cohen-Or 2008, "Consistent mesh partitioning and skeletonisation using the shape diameter function",
https://doi.org/10.1007/s00371-007-0197-5; here with one ray along the normal and the smaller of it and a cone's median.
"""

from __future__ import annotations

__all__ = ["local_thickness"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.mesh import Mesh

RAYS = 4  # around the normal
CONE = np.radians(30.0)
OFF = 1e-5  # of the diagonal, that rays start inside, beyond their own face


def local_thickness(mesh: Mesh, faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) how far the surface opposite lies from the centre of each chosen face; infinite where there is none.

    Parameters
    ----------
    mesh : Mesh
        Facing outwards.
    faces : (k,) array of int
        Numbers of faces; each takes five rays.
    """
    if len(faces) == 0:
        return np.empty(0)
    A, B, C = mesh.vertices[mesh.faces[faces]].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    inward = -np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    sides = np.linalg.norm(B - A, axis=1, keepdims=True)
    aside = np.divide(B - A, sides, out=np.zeros_like(A), where=sides > 0)
    across = np.cross(inward, aside)
    tree = igl.AABB()
    tree.init(mesh.vertices, mesh.faces)
    origins = (A + B + C) / 3 + OFF * mesh.diagonal * inward
    depths = []
    for turn in range(RAYS):
        around = 2 * np.pi * turn / RAYS
        slant = np.cos(around) * aside + np.sin(around) * across
        depths.append(np.cos(CONE) * _ahead(tree, mesh, origins, np.cos(CONE) * inward + np.sin(CONE) * slant))
    straight = _ahead(tree, mesh, origins, inward)
    thickness = np.minimum(straight, np.median(depths, axis=0))
    return np.where(lengths[:, 0] > 0, thickness, np.inf)


def _ahead(tree: igl.AABB, mesh: Mesh, origins: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray:
    """(m,) how far the surface lies in each direction; infinite where it is never met."""
    face, far, _ = tree.intersect_ray_first(mesh.vertices, mesh.faces, origins, np.ascontiguousarray(directions))
    return np.where(face >= 0, far, np.inf)
