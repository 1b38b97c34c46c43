"""Meshes in closed form, on which the values of operators are known: no remeshing, the same numbers on every machine.

The faces of closed surfaces point outwards.
"""

from __future__ import annotations

__all__ = [
    "capsule",
    "cylinder",
    "flat_grid",
    "join_rings",
    "schwarz_lantern",
    "section_frames",
    "sphere",
    "torus",
    "tube",
]

from itertools import pairwise

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import MeshError
from lbskel.geometry.arrays import checked_points
from lbskel.geometry.mesh import Mesh


def sphere(subdivisions: int = 3) -> Mesh:
    """Build the unit sphere from an icosahedron by k 1-to-4 subdivisions: 10 * 4**k + 2 vertices.

    Parameters
    ----------
    subdivisions : int
        The number k.
    """
    V, F = igl.icosahedron()
    for _ in range(subdivisions):
        V, F = igl.upsample(V, F)
        V /= np.linalg.norm(V, axis=1, keepdims=True)
    return Mesh(V, F)


def _grid_faces(n: int, m: int) -> NDArray[np.int64]:
    """Triangulate a grid of n rows of m vertices: (2 (n-1) (m-1), 3) faces, all diagonals in the same direction."""
    a = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    b, c, d = a + m, a + m + 1, a + 1
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def join_rings(
    rings: NDArray[np.float64], poles: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
) -> Mesh:
    """Join rings of points by triangles, and close the ends by triangle fans to two poles if these are given.

    Parameters
    ----------
    rings : (n, m, 3) array of float
        Each counterclockwise as seen from the rings before it, for faces that point outwards.
    poles : tuple of two (3,) arrays of float, optional
    """
    n, m, _ = rings.shape
    closed = np.append(np.arange(m), 0)  # columns of a ring, the first one repeated at the end
    F = (np.arange(n)[:, None] * m + closed).ravel()[_grid_faces(n, m + 1)]
    V = rings.reshape(-1, 3)
    if poles is None:
        return Mesh(V, F)
    first, last = n * m, n * m + 1
    ring_edges = np.array(list(pairwise(closed)))
    first_fan = np.insert(ring_edges, 0, first, axis=1)
    last_fan = np.insert(ring_edges[:, ::-1] + (n - 1) * m, 0, last, axis=1)
    return Mesh(np.concatenate([V, poles]), np.concatenate([F, first_fan, last_fan]))


def _circle(m: int) -> NDArray[np.float64]:
    """Sample the unit circle at (m, 2) points, counterclockwise from (1, 0)."""
    angle = 2 * np.pi * np.arange(m) / m
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def torus(R: float = 1.0, r: float = 0.4, n: int = 48, m: int = 24) -> Mesh:
    """Build the torus around the z axis.

    Parameters
    ----------
    R, r : float
        Radii of the center circle and of the tube.
    n, m : int
        Number of sections, and of vertices in each. Vertex ``i * m + j`` is at the angle ``2 pi i / n`` around the
        axis and ``2 pi j / m`` around the tube.
    """
    around, section = _circle(n), R * np.array([1, 0]) + r * _circle(m)
    V = np.concatenate(
        [around[:, None] * section[None, :, :1], np.broadcast_to(section[None, :, 1:], (n, m, 1))], axis=2
    )
    wrap = np.arange(n * m).reshape(n, m)[np.ix_(np.append(np.arange(n), 0), np.append(np.arange(m), 0))]
    return Mesh(V.reshape(-1, 3), wrap.ravel()[_grid_faces(n + 1, m + 1)])


def cylinder(radius: float = 1.0, height: float = 2.0, n: int = 32, m: int = 17) -> Mesh:
    """Build the side of a cylinder around the z axis, open at both ends and centered at the origin.

    Parameters
    ----------
    radius, height : float
    n, m : int
        Number of vertices in each ring, and of rings.
    """
    flat = np.broadcast_to(radius * _circle(n), (m, n, 2))
    z = np.broadcast_to(np.linspace(height / 2, -height / 2, m)[:, None, None], (m, n, 1))
    return join_rings(np.concatenate([flat, z], axis=2))


def capsule(length: float = 2.0, radius: float = 0.5, n: int = 32) -> Mesh:
    """Build a capsule around the z axis, a cylinder closed by two half spheres, centered at the origin.

    Parameters
    ----------
    length : float
        Of the cylinder, between the centers of the half spheres.
    radius : float
    n : int
        Number of vertices around the axis.
    """
    polar = np.linspace(0, np.pi / 2, n // 4 + 1)[1:]
    n_bands = max(int(np.ceil(length * n / (2 * np.pi * radius))), 1)
    rho = radius * np.concatenate([np.sin(polar), np.ones(n_bands - 1), np.sin(polar)[::-1]])
    cap = length / 2 + radius * np.cos(polar)
    z = np.concatenate([cap, np.linspace(length / 2, -length / 2, n_bands + 1)[1:-1], -cap[::-1]])
    rings = np.concatenate([rho[:, None, None] * _circle(n), np.broadcast_to(z[:, None, None], (len(z), n, 1))], axis=2)
    pole = np.array([0, 0, length / 2 + radius])
    return join_rings(rings, (pole, -pole))


def section_frames(polyline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute two unit vectors across a polyline at each of its points, transported along it without twist.

    Both are normal to the mean direction of the two segments at the point.

    Parameters
    ----------
    polyline : (n, 3) array of float

    Returns
    -------
    (n, 2, 3) array of float
        The cross product of the two has the direction of the polyline.
    """
    segments = np.diff(polyline, axis=0)
    segments /= np.linalg.norm(segments, axis=1, keepdims=True)
    tangents = np.concatenate([segments[:1], segments[:-1] + segments[1:], segments[-1:]])
    normal = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    frames = []
    for tangent in tangents:
        normal = normal - tangent * (normal @ tangent) / (tangent @ tangent)
        normal /= np.linalg.norm(normal)
        frames.append([normal, np.cross(tangent, normal) / np.linalg.norm(tangent)])
    return np.array(frames)


def tube(polyline: ArrayLike, radius: ArrayLike, *, sides: int = 16, rounded: bool = False) -> Mesh:
    """Build a closed tube along an open polyline.

    The section at a point is normal to the mean direction of the two segments there: see :func:`section_frames`.

    Parameters
    ----------
    polyline : (n, 3) array_like of float
    radius : float or (n,) array_like of float
        One for all points or one per point.
    sides : int
        Number of vertices in each section.
    rounded : bool
        Whether half spheres around the first and the last point close the tube, in place of flat sections; with fewer
        than 8 sides they are cones of the same height.

    Raises
    ------
    MeshError
        If the polyline has fewer than two points, or two neighbors that coincide.
    """
    P = checked_points(polyline, "points of the polyline")
    if len(P) < 2:
        raise MeshError(f"the polyline must have two points or more, not {len(P)}")
    if len(equal := np.flatnonzero((P[1:] == P[:-1]).all(axis=1))):
        raise MeshError(f"points {equal[0]} and {equal[0] + 1} of the polyline, counted from 0, coincide; remove one")
    R = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(P))
    poles = (P[-1], P[0])
    if rounded:
        steps = np.arange(1, max(sides // 4, 1)) * np.pi / 2 / max(sides // 4, 1)  # angles above the end sections
        first, last = ((P[i] - P[j]) / np.linalg.norm(P[i] - P[j]) * R[i] for i, j in ((0, 1), (-1, -2)))
        poles = (P[-1] + last, P[0] + first)
        heights, lowered = np.sin(steps)[:, None], np.cos(steps)
        P = np.concatenate([P[0] + heights[::-1] * first, P, P[-1] + heights * last])
        R = np.concatenate([R[0] * lowered[::-1], R, R[-1] * lowered])
    frames = section_frames(P)
    rings = P[:, None] + R[:, None, None] * (_circle(sides) @ frames)
    return join_rings(rings[::-1], poles)


def flat_grid(n: int = 16, m: int = 16) -> Mesh:
    """Triangulate the unit square in the plane z = 0 with n by m vertices, n along x; faces point to +z.

    Parameters
    ----------
    n, m : int
        Number of vertices along x and along y.
    """
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, m), indexing="ij")
    return Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(n * m)], axis=1), _grid_faces(n, m))


def schwarz_lantern(n: int = 16, m: int = 16) -> Mesh:
    """Build the Schwarz lantern inscribed in the cylinder of radius 1 and height 1.

    Its vertices are on the cylinder, yet its area converges to that of the cylinder only if m grows more slowly than
    n^2.

    Parameters
    ----------
    n : int
        Number of vertices in each ring; each ring is turned by half a side against the one below.
    m : int
        Number of bands between rings.
    """
    turn = np.pi / n * (np.arange(m + 1) % 2)
    angle = 2 * np.pi * np.arange(n) / n + turn[:, None]
    z = np.broadcast_to(np.linspace(0, 1, m + 1)[:, None], angle.shape)
    V = np.stack([np.cos(angle), np.sin(angle), z], axis=2).reshape(-1, 3)
    faces = []
    for band in range(m):
        low, high = band * n, (band + 1) * n
        current, following = np.arange(n), (np.arange(n) + 1) % n
        above = current if band % 2 == 0 else following  # the upper vertex over the lower edge (current, following)
        faces.append(np.stack([low + current, low + following, high + above], axis=1))
        below = following if band % 2 == 0 else current
        faces.append(np.stack([high + current, low + below, high + following], axis=1))
    return Mesh(V, np.concatenate(faces))
