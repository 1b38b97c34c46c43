"""Plane sections of a mesh: the closed curve round a point, its centroid and size.

A section is cut exactly, triangle by triangle, so it does not depend on how densely the surface is sampled. Of the
curves that a plane cuts, the smallest that goes round the point counts, or the nearest where none does. Area and
centroid come from Green's theorem over its segments.
"""

from __future__ import annotations

__all__ = ["Sections", "cut"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lbskel.mesh import Mesh

AT_ONCE = 8_000_000  # signed distances held at a time


@dataclass(frozen=True, eq=False)
class Sections:
    """One section for each of k planes.

    Parameters
    ----------
    is_cut : (k,) array of bool
        Whether the plane meets the mesh at all.
    surrounds : (k,) array of bool
        Whether the curve goes round the point.
    centroids : (k, 3) array of float
        Of the area inside the curve; of the curve itself where it is not closed. The point itself where nothing is cut.
    areas : (k,) array of float
    lengths : (k,) array of float
        Of the curve.
    radii : (k,) array of float
        Mean distance of the curve from its centroid.
    own : (k,) array of float
        Share of the curve's length on faces with the label of the plane, or with a negative one, which is nobody's.
    """

    is_cut: NDArray[np.bool_]
    surrounds: NDArray[np.bool_]
    centroids: NDArray[np.float64]
    areas: NDArray[np.float64]
    lengths: NDArray[np.float64]
    radii: NDArray[np.float64]
    own: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Segments:
    """Where planes cut triangles: plane, face, the two mesh edges cut, and the two points, counter-clockwise."""

    plane: NDArray[np.int64]
    face: NDArray[np.int64]
    edges: NDArray[np.int64]
    points: NDArray[np.float64]


def cut(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    *,
    face_labels: NDArray[np.int64] | None = None,
    labels: NDArray[np.int64] | None = None,
) -> Sections:
    """The section of a mesh round each point, in the plane through it.

    Parameters
    ----------
    mesh : Mesh
    points, normals : (k, 3) array of float
        The planes; normals of length one.
    face_labels : (m,) array of int, optional
    labels : (k,) array of int, optional
        With these, ``own`` tells how much of each curve lies on faces of the plane's own label.
    """
    at_once = max(1, AT_ONCE // len(mesh.vertices))
    parts = [
        _segments(mesh, points[first : first + at_once], normals[first : first + at_once], first)
        for first in range(0, max(1, len(points)), at_once)
    ]
    joined = _Segments(
        plane=np.concatenate([part.plane for part in parts]),
        face=np.concatenate([part.face for part in parts]),
        edges=np.concatenate([part.edges for part in parts]),
        points=np.concatenate([part.points for part in parts]),
    )
    return _measure(mesh, points, normals, joined, face_labels, labels)


def _segments(mesh: Mesh, points: NDArray[np.float64], normals: NDArray[np.float64], first: int) -> _Segments:
    """Every triangle cut by every plane."""
    F, m = mesh.faces, len(mesh.faces)
    height = mesh.vertices @ normals.T - np.einsum("ki,ki->k", normals, points)
    above = height >= 0
    face, plane = _crossings(np.packbits(above, axis=1), F)
    corner_above = above[F[face], plane[:, None]]
    odd = corner_above == (corner_above.sum(axis=1, keepdims=True) == 1)
    lone = np.argmax(odd, axis=1)
    left, right = (lone + 1) % 3, (lone + 2) % 3
    ends, edges = [], []
    for other, opposite in ((left, right), (right, left)):
        start, end = F[face, lone], F[face, other]
        h0, h1 = height[start, plane], height[end, plane]
        share = (h0 / (h0 - h1))[:, None]
        ends.append((1 - share) * mesh.vertices[start] + share * mesh.vertices[end])
        edges.append(mesh.edge_of_half_edge[opposite * m + face])
    q, pairs = np.stack(ends, axis=1), np.stack(edges, axis=1)
    corners = mesh.vertices[F[face]]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    runs_back = np.einsum("ij,ij->i", q[:, 1] - q[:, 0], np.cross(normals[plane], outward)) < 0
    q[runs_back], pairs[runs_back] = q[runs_back, ::-1], pairs[runs_back, ::-1]
    return _Segments(plane + first, face, pairs, q)


def _crossings(above: NDArray[np.uint8], F: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces and planes that cross, from a bit per vertex and plane: eight planes are compared at a time."""
    first = above[F[:, 0]]
    differs = (first ^ above[F[:, 1]]) | (first ^ above[F[:, 2]])
    face, byte = np.nonzero(differs)
    row, bit = np.nonzero(np.unpackbits(differs[face, byte][:, None], axis=1))
    return face[row], 8 * byte[row] + bit


def _frames(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 2, 3) two unit vectors in each plane, right-handed with its normal."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)


def _measure(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    segments: _Segments,
    face_labels: NDArray[np.int64] | None,
    labels: NDArray[np.int64] | None,
) -> Sections:
    """Join segments to curves, choose one for each plane, and measure it."""
    k, plane = len(points), segments.plane
    keys, ends = np.unique(plane[:, None] * len(mesh.edges) + segments.edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = coo_array((np.ones(len(ends), dtype=np.int8), (ends[:, 0], ends[:, 1])), shape=(len(keys), len(keys)))
    n_curves, curve_of_end = connected_components(graph, directed=False)
    curve = curve_of_end[ends[:, 0]] if len(ends) else np.empty(0, dtype=np.int64)
    plane_of_curve = np.zeros(n_curves, dtype=np.int64)
    plane_of_curve[curve] = plane

    def total(values: NDArray) -> NDArray[np.float64]:
        return np.asarray(np.bincount(curve, weights=values, minlength=n_curves), dtype=np.float64)

    frames = _frames(normals)
    a, b = np.einsum("sij,sej->esi", frames[plane], segments.points - points[plane][:, None, :])
    cross, dot = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)
    pieces = np.linalg.norm(b - a, axis=1)
    length, area = total(pieces), total(cross) / 2
    winding = total(np.arctan2(cross, dot)) / (2 * np.pi)
    is_closed = np.hypot(total(b[:, 0] - a[:, 0]), total(b[:, 1] - a[:, 1])) < 1e-6 * length
    has_area = is_closed & (np.abs(area) > 1e-12 * length**2)
    centroid = np.empty((n_curves, 2))
    for axis in range(2):
        middle = a[:, axis] + b[:, axis]
        by_area = total(middle * cross) / np.where(has_area, 6 * area, 1)
        by_length = total(middle * pieces) / np.where(length > 0, 2 * length, 1)
        centroid[:, axis] = np.where(has_area, by_area, by_length)
    nearest = np.full(n_curves, np.inf)
    np.minimum.at(nearest, curve, _distance_to_origin(a, b))

    surrounds = np.abs(winding) > 0.5
    order = np.lexsort((np.where(surrounds, np.abs(area), nearest), ~surrounds, plane_of_curve))
    is_first = np.ones(n_curves, dtype=bool)
    is_first[1:] = np.diff(plane_of_curve[order]) > 0
    chosen = order[is_first]
    at = plane_of_curve[chosen]

    def per_plane(values: NDArray, otherwise: float = 0.0) -> NDArray:
        result = np.full(k, otherwise, dtype=values.dtype)
        result[at] = values[chosen]
        return result

    radius = total(pieces * np.linalg.norm((a + b) / 2 - centroid[curve], axis=1)) / np.where(length > 0, length, 1)
    is_own = np.ones(len(plane), dtype=bool)
    if face_labels is not None and labels is not None:
        label = face_labels[segments.face]
        is_own = (label == labels[plane]) | (label < 0)
    moved = np.zeros((k, 2))
    moved[at] = centroid[chosen]
    return Sections(
        is_cut=per_plane(np.ones(n_curves, dtype=bool)),
        surrounds=per_plane(surrounds),
        centroids=points + np.einsum("ki,kij->kj", moved, frames),
        areas=per_plane(np.abs(area)),
        lengths=per_plane(length),
        radii=per_plane(radius),
        own=per_plane(total(pieces * is_own) / np.where(length > 0, length, 1)),
    )


def _distance_to_origin(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each planar segment from the origin."""
    along = b - a
    squared = (along * along).sum(axis=1)
    share = np.clip(-(a * along).sum(axis=1) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(a + share[:, None] * along, axis=1)
