"""Plane sections of a mesh: the closed curve round a point, its centroid and size.

A section is cut exactly, triangle by triangle, so it does not depend on how densely the surface is sampled. Of the
curves that a plane cuts, the smallest that goes round the point counts, or the nearest where none does. Area and
centroid come from Green's theorem over its segments.

Triangles are looked for near the point first. Curves of one plane do not cross, so a closed one round the point that
lies there is inside of any that does not, and no more need be known; else the whole plane is cut.
"""

from __future__ import annotations

__all__ = ["Sections", "cut"]

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lbskel.blocks import COARSE, FINE, within
from lbskel.mesh import Mesh
from lbskel.ordering import numbered

AT_ONCE = 4_000_000  # distances from planes to blocks of faces held at a time
REACHES = (2.0, 9.0, np.inf)  # times the distance from a point to the nearest block: where its curve is looked for


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
    at_once = max(1, AT_ONCE // len(mesh.blocks.coarse.radii))
    reaches = REACHES if mesh.is_closed else REACHES[::2]  # a curve that is not closed is known as such only when whole
    parts = []
    for first in range(0, max(1, len(points)), at_once):
        some = slice(first, first + at_once)
        plane_labels = None if labels is None else labels[some]
        parts.append(_cut(mesh, points[some], normals[some], face_labels, plane_labels, reaches))
    return Sections(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Sections)))


def _cut(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    face_labels: NDArray[np.int64] | None,
    labels: NDArray[np.int64] | None,
    reaches: tuple[float, ...],
) -> Sections:
    """The sections of a few planes: near their points where that is enough, farther out otherwise."""
    balls = mesh.blocks.coarse
    squared = (points**2).sum(axis=1)[:, None] - 2 * points @ balls.centres.T + (balls.centres**2).sum(axis=1)
    beyond = np.sqrt(np.maximum(squared, 0.0)) - balls.radii
    is_met = np.abs(normals @ balls.centres.T - np.einsum("ki,ki->k", normals, points)[:, None]) <= balls.radii
    is_met &= beyond <= reaches[0] * (beyond + 2 * balls.radii).min(axis=1, keepdims=True)
    sections, is_whole = _measured(mesh, points, normals, is_met, face_labels, labels)
    rest = np.flatnonzero(~(sections.surrounds & is_whole))
    if len(rest) and len(reaches) > 1:
        rest_labels = None if labels is None else labels[rest]
        farther = _cut(mesh, points[rest], normals[rest], face_labels, rest_labels, reaches[1:])
        for each in fields(Sections):
            getattr(sections, each.name)[rest] = getattr(farther, each.name)
    return sections


def _segments(
    mesh: Mesh, points: NDArray[np.float64], normals: NDArray[np.float64], is_met: NDArray[np.bool_]
) -> _Segments:
    """Every triangle, of the blocks that each plane may meet, that it does cut."""
    F, m, (X, Y, Z) = mesh.faces, len(mesh.faces), mesh.vertices.T
    a, b, c = normals.T
    offset = np.einsum("ki,ki->k", normals, points)
    balls = mesh.blocks.fine
    plane, block = np.nonzero(is_met)
    row, ball = within(block, COARSE // FINE, len(balls.radii))
    plane, (x, y, z) = plane[row], balls.centres[ball].T
    is_met = np.abs(a[plane] * x + b[plane] * y + c[plane] * z - offset[plane]) <= balls.radii[ball]
    row, face = within(ball[is_met], FINE, m)
    plane, face = plane[is_met][row], mesh.blocks.order[face]

    def heights(corner: NDArray[np.int64], plane: NDArray[np.int64]) -> NDArray[np.float64]:
        """The same for a vertex whichever face it is asked for."""
        return a[plane] * X[corner] + b[plane] * Y[corner] + c[plane] * Z[corner] - offset[plane]

    height = np.stack([heights(F[face, corner], plane) for corner in range(3)], axis=1)
    above = height >= 0
    n_above = above.sum(axis=1)
    crosses = np.flatnonzero((n_above == 1) | (n_above == 2))
    face, plane, height, above, n_above = (
        face[crosses],
        plane[crosses],
        height[crosses],
        above[crosses],
        n_above[crosses],
    )
    lone = np.argmax(above == (n_above == 1)[:, None], axis=1)
    at = np.arange(len(face))
    left, right = (lone + 1) % 3, (lone + 2) % 3
    ends, edges = [], []
    for other, opposite in ((left, right), (right, left)):
        start, end = F[face, lone], F[face, other]
        h0, h1 = height[at, lone], height[at, other]
        share = (h0 / (h0 - h1))[:, None]
        ends.append((1 - share) * mesh.vertices[start] + share * mesh.vertices[end])
        edges.append(mesh.edge_of_half_edge[opposite * m + face])
    q, pairs = np.stack(ends, axis=1), np.stack(edges, axis=1)
    runs_back = n_above == 2  # from the left of a corner under the plane to its right is clockwise round the normal
    q[runs_back], pairs[runs_back] = q[runs_back, ::-1], pairs[runs_back, ::-1]
    return _Segments(plane, face, pairs, q)


def _frames(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 2, 3) two unit vectors in each plane, right-handed with its normal."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)


def _measured(
    mesh: Mesh,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    is_met: NDArray[np.bool_],
    face_labels: NDArray[np.int64] | None,
    labels: NDArray[np.int64] | None,
) -> tuple[Sections, NDArray[np.bool_]]:
    """Join the segments in some blocks to curves, choose one for each plane, and measure it.

    Also, whether the one chosen runs on nowhere outside of the blocks; such curves go first.
    """
    segments = _segments(mesh, points, normals, is_met)
    k, plane = len(points), segments.plane
    keys, ends = numbered((plane[:, None] * len(mesh.edges) + segments.edges).ravel())
    ends = ends.reshape(-1, 2)
    graph = coo_array((np.ones(len(ends), dtype=np.int8), (ends[:, 0], ends[:, 1])), shape=(len(keys), len(keys)))
    n_curves, curve_of_end = connected_components(graph, directed=False)
    curve = curve_of_end[ends[:, 0]] if len(ends) else np.empty(0, dtype=np.int64)
    plane_of_curve = np.zeros(n_curves, dtype=np.int64)
    plane_of_curve[curve] = plane
    is_whole = np.ones(n_curves, dtype=bool)
    is_whole[curve_of_end[np.bincount(ends.ravel()) < mesh.faces_per_edge[keys % len(mesh.edges)]]] = False

    def total(values: NDArray) -> NDArray[np.float64]:
        return np.asarray(np.bincount(curve, weights=values, minlength=n_curves), dtype=np.float64)

    frames = _frames(normals)
    offsets = (segments.points - points[plane][:, None, :]).transpose(1, 2, 0)
    a, b = (np.stack([(frames[plane, axis].T * ends).sum(axis=0) for axis in (0, 1)], axis=1) for ends in offsets)
    cross, dot = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
    pieces = np.hypot(b[:, 0] - a[:, 0], b[:, 1] - a[:, 1])
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
    order = np.lexsort((np.where(surrounds, np.abs(area), nearest), ~surrounds, ~is_whole, plane_of_curve))
    is_first = np.ones(n_curves, dtype=bool)
    is_first[1:] = np.diff(plane_of_curve[order]) > 0
    chosen = order[is_first]
    at = plane_of_curve[chosen]

    def per_plane(values: NDArray, otherwise: float = 0.0) -> NDArray:
        result = np.full(k, otherwise, dtype=values.dtype)
        result[at] = values[chosen]
        return result

    x, y = ((a + b) / 2 - centroid[curve]).T
    radius = total(pieces * np.hypot(x, y)) / np.where(length > 0, length, 1)
    is_own = np.ones(len(plane), dtype=bool)
    if face_labels is not None and labels is not None:
        label = face_labels[segments.face]
        is_own = (label == labels[plane]) | (label < 0)
    moved = np.zeros((k, 2))
    moved[at] = centroid[chosen]
    sections = Sections(
        is_cut=per_plane(np.ones(n_curves, dtype=bool)),
        surrounds=per_plane(surrounds),
        centroids=points + np.einsum("ki,kij->kj", moved, frames),
        areas=per_plane(np.abs(area)),
        lengths=per_plane(length),
        radii=per_plane(radius),
        own=per_plane(total(pieces * is_own) / np.where(length > 0, length, 1)),
    )
    return sections, per_plane(is_whole)


def _distance_to_origin(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each planar segment from the origin."""
    along = b - a
    (x, y), (p, q) = a.T, along.T
    squared = p * p + q * q
    share = np.clip(-(x * p + y * q) / np.where(squared > 0, squared, 1), 0, 1)
    return np.hypot(x + share * p, y + share * q)
