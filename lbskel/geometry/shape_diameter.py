"""How thick a shape is at each face: how far a ray inwards from it goes, the shape diameter.

Shapira, Shamir, Cohen-Or 2008, "Consistent mesh partitioning and skeletonization using the shape diameter function",
https://doi.org/10.1007/s00371-007-0197-5; here with one ray along the normal and the smaller of it and a cone's median.
"""

from __future__ import annotations

__all__ = ["local_thickness", "straight_thickness"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface

RAYS = 4  # around the normal
CONE = np.radians(30.0)
OFF = 1e-5  # of the diagonal, that rays start inside, beyond their own face


def straight_thickness(mesh: Mesh, faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) how far a ray goes straight in from the center of each chosen face; infinite where it meets nothing."""
    origins, inward, _ = _inwards(mesh, faces)
    return Surface(mesh).ray_distance(origins, inward)


def local_thickness(mesh: Mesh, faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) how far the surface opposite lies from the center of each chosen face; infinite where there is none.

    Parameters
    ----------
    mesh : Mesh
        Facing outwards, if it is open.
    faces : (k,) array of int
        Numbers of faces; each takes five rays.
    """
    if len(faces) == 0:
        return np.empty(0)
    origins, inward, aside = _inwards(mesh, faces)
    across = np.cross(inward, aside)
    depths = []
    for turn in range(RAYS):
        around = 2 * np.pi * turn / RAYS
        slant = np.cos(around) * aside + np.sin(around) * across
        ahead = Surface(mesh).ray_distance(origins, np.cos(CONE) * inward + np.sin(CONE) * slant)
        depths.append(np.cos(CONE) * ahead)
    thickness = np.minimum(Surface(mesh).ray_distance(origins, inward), np.median(depths, axis=0))
    return np.where(inward.any(axis=1), thickness, np.inf)


def _inwards(
    mesh: Mesh, faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) places just under the centers of faces, and unit directions in from there and along the faces."""
    A, B, C = mesh.vertices[mesh.faces[faces]].transpose(1, 0, 2)
    outwards = -1 if mesh.is_closed and mesh.volume < 0 else 1
    inward, aside = -outwards * _unit(np.cross(B - A, C - A)), _unit(B - A)
    return (A + B + C) / 3 + OFF * mesh.diagonal * inward, inward, aside


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors made of length one; what has no length stays."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)
