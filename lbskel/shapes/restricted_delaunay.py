"""Surfaces of unions of tubes with edges in proportion to the local radius, by restricted Delaunay triangulation.

Points are spread over the surface; of their Delaunay tetrahedra, those with the circumcenter inside the solid are
kept, and their boundary is the surface. It is closed, and a manifold homeomorphic to the solid's surface if the points
are dense enough; where they are not, midpoints of edges are added to the points, or points are removed: Boissonnat,
Oudot 2005, "Provably good sampling and meshing of surfaces", https://doi.org/10.1016/j.gmod.2005.01.004.

A grid as in :mod:`lbskel.shapes.isosurface` has cells of one size, which do not fit tubes of very different radii.
"""

from __future__ import annotations

__all__ = ["EDGE_LENGTH", "mesh_tubes", "volume_factor"]

from collections.abc import Sequence
from itertools import pairwise

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.shapes.isosurface import project
from lbskel.shapes.primitives import section_frames
from lbskel.shapes.round_cones import Branch, Solid, solid_of, subdivide

# Length of the edges in local radii: thirteen vertices around a tube. At most 0.7 keeps samples of a round tube dense
# enough (tried on trees of vessels; there is no committed table).
EDGE_LENGTH = 0.5
# In edge lengths: depth of a sample below the surface of another tube above which it is dropped; scatter that breaks
# ties between tetrahedra of one sphere; distance of two samples below which one is dropped. Guesses.
MAX_DEPTH, SCATTER, MIN_SPACING = 0.7, 0.03, 0.7
# Bend of the surface, in edge lengths, up to which two cones of a tube share one ring of samples; a guess.
RING_TOLERANCE = 0.3
# Longest edge of a triangle, relative to the wanted length, above which a sample is added at its middle: anywhere, and
# at vertices where the surface is not a manifold. Guesses.
MAX_EDGE, MIN_EDGE = 1.9, 0.6
# Most times that samples are added: trees of vessels take one or two, tubes around real neurons up to six.
MAX_ROUNDS = 12


def volume_factor(edge_length: float = EDGE_LENGTH) -> float:
    """Compute the factor on radii with which a mesh with its vertices on the tube has the volume of the given tube.

    Rings of m vertices, turned by half a side against their neighbors, have the area of a polygon of m sides; half-way
    between two rings the section has 2 m corners, at the midpoints of edges. Simpson's rule gives the volume between.

    Parameters
    ----------
    edge_length : float
        In tube radii.
    """
    angle = 2 * np.pi / _n_around(edge_length)
    ring, middle = np.sin(angle) / angle, np.cos(angle / 4) ** 2 * np.sin(angle / 2) / (angle / 2)
    return float(((ring + 2 * middle) / 3) ** -0.5)


def mesh_tubes(branches: Sequence[Branch], *, edge_length: float = EDGE_LENGTH) -> Mesh:
    """Mesh the surface of a union of tubes with rounded ends, blended where they meet, by nearly equilateral triangles.

    Parameters
    ----------
    branches : sequence of Branch
        As for :func:`lbskel.shapes.solid_of`.
    edge_length : float
        Length of the edges, in local radii.

    Raises
    ------
    MeshError
        If the surface does not become a closed manifold: two tubes touch, or are closer than an edge.
    """
    solid = solid_of(branches)
    points, lengths = _samples(branches, edge_length)
    depth = -solid.distance(points)
    kept = depth < MAX_DEPTH * lengths
    points, lengths = points[kept], lengths[kept]
    points, lengths = _thinned(_projected(solid, points, lengths), lengths)
    for number in range(MAX_ROUNDS):
        scatter = SCATTER * lengths[:, None] * np.random.default_rng(0).standard_normal(points.shape)
        faces = _restricted_faces(solid, points + scatter)
        mesh = Mesh(points, faces)
        broken = _broken_vertices(mesh)
        is_broken = np.isin(faces, broken).any(axis=1)
        corners, allowed = points[faces], lengths[faces].min(axis=1)
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        longest, edge = edges.max(axis=1), edges.argmax(axis=1)
        limit = MAX_EDGE if number == 0 else np.inf  # gaps where tubes meet are filled once
        split = longest > np.where(is_broken, MIN_EDGE, limit) * allowed
        if not split.any():
            if not is_broken.any():
                break
            lengths, points = np.delete(lengths, broken), np.delete(points, broken, axis=0)
            continue
        largest = np.flatnonzero(split)[np.argsort(-(longest / allowed)[split], kind="stable")]
        middles, spacing = _edge_middles(corners[largest], edge[largest]), longest[largest] / 2
        added, spacing = _thinned(_projected(solid, middles, spacing), spacing)
        used = np.unique(faces)
        points, lengths = np.concatenate([points[used], added]), np.concatenate([lengths[used], spacing])
    used, rows = np.unique(mesh.faces, return_inverse=True)
    surface = Mesh(mesh.vertices[used], rows.reshape(-1, 3))
    if not surface.is_closed_manifold:
        raise MeshError("the tubes cannot be meshed as one closed surface: move those that nearly touch apart")
    return surface


def _n_around(edge_length: float) -> int:
    """Compute the number of vertices around a tube."""
    return max(round(2 * np.pi / edge_length), 3)


def _samples(branches: Sequence[Branch], edge_length: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Spread points over each tube and its rounded ends, in rings: (n, 3) points and (n,) edge lengths.

    A ring at the latitude a of a sphere around the axis is where a cone with radii that decrease by sin a touches it.
    """
    height = np.sqrt(3) / 2 * edge_length
    points: list[NDArray[np.float64]] = []
    lengths = []
    for number, (polyline, radii) in enumerate(branches):
        spheres = subdivide(np.atleast_2d(polyline), np.ravel(radii), f"branch {number}")
        axis, R = _even_in_radii(spheres[:, :3], spheres[:, 3], height)
        frames = section_frames(axis)
        along = np.cross(frames[:, 0], frames[:, 1])
        slopes = np.diff(-R) / np.linalg.norm(np.diff(axis, axis=0), axis=1)
        tilts = np.concatenate([[-np.pi / 2], np.arcsin(np.clip(slopes, -1, 1)), [np.pi / 2]])
        for k, (before, after) in enumerate(pairwise(tilts)):
            n_bands = int(np.ceil((after - before) / height - RING_TOLERANCE))
            latitudes = np.linspace(before, after, n_bands + 1) if n_bands > 0 else [(before + after) / 2]
            for latitude in latitudes:
                n = max(round(_n_around(edge_length) * np.cos(latitude)), 1)
                around = 2 * np.pi * (np.arange(n) + 0.5 * (len(points) % 2)) / n
                across = np.stack([np.cos(around), np.sin(around)], axis=1) @ frames[k]
                points.append(axis[k] + R[k] * (np.cos(latitude) * across + np.sin(latitude) * along[k]))
                lengths.append(np.full(n, edge_length * R[k]))
    return np.concatenate(points), np.concatenate(lengths)


def _even_in_radii(
    points: NDArray[np.float64], radii: NDArray[np.float64], spacing: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sample a polyline and its radii at equal distances, measured in local radii and at most ``spacing``."""
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1) / ((radii[1:] + radii[:-1]) / 2)
    position = np.append(0.0, np.cumsum(pieces))
    sampled = np.linspace(0.0, position[-1], max(int(np.ceil(position[-1] / spacing)), 1) + 1)
    axis = np.stack([np.interp(sampled, position, column) for column in points.T], axis=1)
    return axis, np.interp(sampled, position, radii)


def _projected(solid: Solid, points: NDArray[np.float64], lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move points onto the surface, those of each octave of edge lengths together, by steps of at most an edge."""
    points, octave = points.copy(), np.floor(np.log2(lengths))
    for each in np.unique(octave):
        group = np.flatnonzero(octave == each)
        step = 2.0**each
        points[group] = project(solid, points[group], step=step)
    return points


def _thinned(
    points: NDArray[np.float64], lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Drop points that are too near to one of smaller edge length, or to an earlier one of equal edge length."""
    nearby = cKDTree(points).query_ball_point(points, MIN_SPACING * lengths)
    kept = np.ones(len(points), dtype=bool)
    for i in np.flatnonzero([len(found) > 1 for found in nearby]):
        kept[i] = not any(kept[j] and (lengths[j], j) < (lengths[i], i) for j in nearby[i])
    return points[kept], lengths[kept]


def _restricted_faces(solid: Solid, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Find the boundary of the Delaunay tetrahedra with circumcenters inside the solid: (m, 3), facing outwards."""
    triangulation = Delaunay(points)
    tetrahedra, neighbors = triangulation.simplices.astype(np.int64), triangulation.neighbors
    centers = _circumcenters(points[tetrahedra])
    candidates = np.flatnonzero(((centers >= points.min(axis=0)) & (centers <= points.max(axis=0))).all(axis=1))
    inside = np.zeros(len(tetrahedra) + 1, dtype=bool)  # the last for neighbor -1
    inside[candidates] = solid.distance(centers[candidates]) < 0
    tetrahedron, apex = np.nonzero(inside[:-1, None] & ~inside[neighbors])
    corners = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[apex]
    faces: NDArray[np.int64] = np.take_along_axis(tetrahedra[tetrahedron], corners, axis=1)
    a, b, c = points[faces].transpose(1, 0, 2)
    faces_inwards = (np.cross(b - a, c - a) * (points[tetrahedra[tetrahedron, apex]] - a)).sum(axis=1) > 0
    faces[faces_inwards] = faces[faces_inwards][:, ::-1]
    return faces


def _circumcenters(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (t, 3) centers of the spheres through (t, 4, 3) corners; not finite for flat tetrahedra."""
    a = corners[:, 0]
    b, c, d = (corners[:, k] - a for k in (1, 2, 3))
    squares = [(edge**2).sum(axis=1, keepdims=True) for edge in (b, c, d)]
    crossed = [np.cross(c, d), np.cross(d, b), np.cross(b, c)]
    with np.errstate(divide="ignore", invalid="ignore"):
        total = sum(square * normal for square, normal in zip(squares, crossed, strict=True))
        centers: NDArray[np.float64] = a + total / (2 * (b * crossed[0]).sum(axis=1, keepdims=True))
    return centers


def _broken_vertices(mesh: Mesh) -> NDArray[np.int64]:
    """List the vertices at which the surface is not a closed manifold: at edges, or where two parts of it touch."""
    at_edges = mesh.edges[mesh.faces_per_edge != 2].ravel()
    pinched = np.flatnonzero(~igl.is_vertex_manifold(mesh.faces)) if len(at_edges) == 0 else at_edges
    return np.unique(np.append(at_edges, pinched))


def _edge_middles(corners: NDArray[np.float64], edge: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute the middle of one edge of each triangle, of (m, 3, 3) corners: from corner ``edge - 1`` to ``edge``."""
    rows = np.arange(len(corners))
    middles: NDArray[np.float64] = (corners[rows, edge] + corners[rows, edge - 1]) / 2
    return middles
