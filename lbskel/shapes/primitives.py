"""Meshes in closed form, for operators whose values on them are known: no remeshing, the same numbers everywhere.

All closed ones are oriented outwards.
"""

from __future__ import annotations

__all__ = ["capsule", "cylinder", "flat_grid", "schwarz_lantern", "sphere", "torus", "tube"]

from itertools import pairwise

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.geometry.mesh import Mesh


def sphere(subdivisions: int = 3) -> Mesh:
    """The unit sphere from an icosahedron, every triangle cut in four that many times: 10 * 4**k + 2 vertices."""
    V, F = igl.icosahedron()
    for _ in range(subdivisions):
        V, F = igl.upsample(V, F)
        V /= np.linalg.norm(V, axis=1, keepdims=True)
    return Mesh(V, F)


def _grid_faces(n: int, m: int) -> NDArray[np.int64]:
    """(2 (n-1) (m-1), 3) triangles of n rows of m vertices, all diagonals in the same direction."""
    a = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    b, c, d = a + m, a + m + 1, a + 1
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def _rings(rings: NDArray[np.float64], poles: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None) -> Mesh:
    """Rings of points, (n, m, 3), joined one to the next, the ends closed by fans to two poles if these are given."""
    n, m, _ = rings.shape
    closed = np.append(np.arange(m), 0)  # the last column of a ring is its first
    F = (np.arange(n)[:, None] * m + closed).ravel()[_grid_faces(n, m + 1)]
    V = rings.reshape(-1, 3)
    if poles is None:
        return Mesh(V, F)
    first, last = n * m, n * m + 1
    side = np.array(list(pairwise(closed)))
    start = np.insert(side, 0, first, axis=1)
    end = np.insert(side[:, ::-1] + (n - 1) * m, 0, last, axis=1)
    return Mesh(np.concatenate([V, poles]), np.concatenate([F, start, end]))


def _circle(m: int) -> NDArray[np.float64]:
    """(m, 2) points of the unit circle."""
    angle = 2 * np.pi * np.arange(m) / m
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def torus(R: float = 1.0, r: float = 0.4, n: int = 48, m: int = 24) -> Mesh:
    """The torus around the z axis with n sections of m vertices; vertex ``i * m + j`` is at the angles of i and j."""
    around, section = _circle(n), R * np.array([1, 0]) + r * _circle(m)
    V = np.concatenate(
        [around[:, None] * section[None, :, :1], np.broadcast_to(section[None, :, 1:], (n, m, 1))], axis=2
    )
    wrap = np.arange(n * m).reshape(n, m)[np.ix_(np.append(np.arange(n), 0), np.append(np.arange(m), 0))]
    return Mesh(V.reshape(-1, 3), wrap.ravel()[_grid_faces(n + 1, m + 1)])


def cylinder(radius: float = 1.0, height: float = 2.0, n: int = 32, m: int = 17) -> Mesh:
    """The side of a cylinder around the z axis, open at both ends: m rings of n vertices."""
    flat = np.broadcast_to(radius * _circle(n), (m, n, 2))
    z = np.broadcast_to(np.linspace(height / 2, -height / 2, m)[:, None, None], (m, n, 1))
    return _rings(np.concatenate([flat, z], axis=2))


def capsule(length: float = 2.0, radius: float = 0.5, n: int = 32) -> Mesh:
    """All points at that distance from a segment of that length on the z axis: closed, n vertices around it."""
    polar = np.linspace(0, np.pi / 2, n // 4 + 1)[1:]
    straight = max(int(np.ceil(length * n / (2 * np.pi * radius))), 1)
    rho = radius * np.concatenate([np.sin(polar), np.ones(straight - 1), np.sin(polar)[::-1]])
    cap = length / 2 + radius * np.cos(polar)
    z = np.concatenate([cap, np.linspace(length / 2, -length / 2, straight + 1)[1:-1], -cap[::-1]])
    rings = np.concatenate([rho[:, None, None] * _circle(n), np.broadcast_to(z[:, None, None], (len(z), n, 1))], axis=2)
    pole = np.array([0, 0, length / 2 + radius])
    return _rings(rings, (pole, -pole))


def tube(polyline: ArrayLike, radius: ArrayLike, *, sides: int = 16) -> Mesh:
    """A closed tube of that radius, one or one per point, along an open polyline, with flat ends.

    The sections stand on the mean direction of the two segments and follow each other without twist.
    """
    P = np.asarray(polyline, dtype=np.float64)
    segments = np.diff(P, axis=0)
    segments /= np.linalg.norm(segments, axis=1, keepdims=True)
    tangents = np.concatenate([segments[:1], segments[:-1] + segments[1:], segments[-1:]])
    across = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    frames = []
    for tangent in tangents:
        across = across - tangent * (across @ tangent) / (tangent @ tangent)
        across /= np.linalg.norm(across)
        frames.append([across, np.cross(tangent, across) / np.linalg.norm(tangent)])
    R = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(P))
    rings = P[:, None] + R[:, None, None] * (_circle(sides) @ np.array(frames))
    return _rings(rings[::-1], (P[-1], P[0]))


def flat_grid(n: int = 16, m: int = 16) -> Mesh:
    """The unit square in the plane z = 0 with n by m vertices."""
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, m), indexing="ij")
    return Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(n * m)], axis=1), _grid_faces(n, m))


def schwarz_lantern(n: int = 16, m: int = 16) -> Mesh:
    """The lantern in the cylinder of radius 1 and height 1: m bands, n vertices around, turned by half a side each.

    Its vertices are on the cylinder and yet its area goes to that of the cylinder only if m grows more slowly than n^2.
    """
    turn = np.pi / n * (np.arange(m + 1) % 2)
    angle = 2 * np.pi * np.arange(n) / n + turn[:, None]
    z = np.broadcast_to(np.linspace(0, 1, m + 1)[:, None], angle.shape)
    V = np.stack([np.cos(angle), np.sin(angle), z], axis=2).reshape(-1, 3)
    faces = []
    for band in range(m):
        low, high = band * n, (band + 1) * n
        here, following = np.arange(n), (np.arange(n) + 1) % n
        above = (
            here if band % 2 == 0 else following
        )  # the upper vertex between ``here`` and ``following`` of the lower ring
        faces.append(np.stack([low + here, low + following, high + above], axis=1))
        below = following if band % 2 == 0 else here
        faces.append(np.stack([high + here, low + below, high + following], axis=1))
    return Mesh(V, np.concatenate(faces))
