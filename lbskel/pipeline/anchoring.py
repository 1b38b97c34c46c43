"""Anchors of the caller, converted to vertices and points of a prepared mesh and of its bodies."""

from __future__ import annotations

__all__ = ["Anchors", "index_of_point", "listed_anchors", "resolve_anchors"]

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.normals import vector_lengths
from lbskel.pipeline.preparation import Body, PreparedMesh
from lbskel.refinement.anchors import as_place, resolve_anchor


@dataclass(frozen=True, eq=False)
class Anchors:
    """Points at which a skeleton must have a node.

    Parameters
    ----------
    vertices : (a,) array of int
        The vertex at each point, or the nearest one of the bodies that the point lies inside.
    points : (a, 3) array of float
        In the unit coordinates of the prepared mesh.
    numbers : (a,) array of int
        Place of each in the caller's list.
    """

    vertices: NDArray[np.int64]
    points: NDArray[np.float64]
    numbers: NDArray[np.int64]

    def within(self, body: Body) -> Anchors:
        """Select the anchors of one body of the prepared mesh, by the body's own vertices."""
        is_within = np.isin(self.vertices, body.vertices)
        vertices = np.searchsorted(body.vertices, self.vertices[is_within])
        return Anchors(vertices, self.points[is_within], self.numbers[is_within])


def listed_anchors(anchors: Any) -> list[Any]:
    """List the anchors that a caller gave; raises MeshError where they are no list.

    Parameters
    ----------
    anchors : iterable of int or (3,) array_like
    """
    if isinstance(anchors, str) or not np.iterable(anchors):
        raise MeshError(f"anchors must be a list of vertices or points, such as [0] or [(x, y, z)], not {anchors!r}")
    return list(anchors)


def index_of_point(place: Any, n_points: int) -> int | None:
    """Return the index of a point of a cloud; None if a place is no index. Raises MeshError if there is no such point.

    Parameters
    ----------
    place : int or (3,) array_like
    n_points : int
        Number of points of the cloud.
    """
    given = as_place(place)
    if given.ndim or not np.issubdtype(given.dtype, np.integer):
        return None
    if not 0 <= given < n_points:
        raise MeshError(f"there is no point {given}: the cloud has points 0..{n_points - 1}")
    return int(given)


def resolve_anchors(anchors: Iterable[Any], prepared: PreparedMesh) -> Anchors:
    """Convert anchors of the source mesh to vertices and points of the prepared mesh.

    Parameters
    ----------
    anchors : iterable of int or (3,) array_like
        Vertices of the source, or points in the caller's coordinates.
    prepared : PreparedMesh

    Returns
    -------
    Anchors
        One of those that are at the same point. A vertex that preprocessing has moved, as smoothing does, or joined to
        others, is at its place on the preprocessed surface: where the caller has it may be outside of that.

    Raises
    ------
    MeshError
        If the anchors are not a list, or one is neither a vertex of the source nor a point.
    """
    resolved = [resolve_anchor(anchor, prepared.source) for anchor in listed_anchors(anchors)]
    points = prepared.frame.to_unit(np.array([point for _, point in resolved]).reshape(-1, 3))
    vertices = np.array([vertex for vertex, _ in resolved], dtype=np.int64)
    targets = prepared.vertex_map.indices[vertices]
    is_vertex = (points == prepared.frame.to_unit(prepared.source.vertices[vertices])).all(axis=1) & (targets >= 0)
    points[is_vertex] = prepared.mesh.vertices[targets[is_vertex]]
    first = np.sort(np.unique(points, axis=0, return_index=True)[1])
    points, is_vertex, targets = points[first], is_vertex[first], targets[first]
    in_bodies = np.concatenate([body.vertices for body in prepared.bodies])
    for row in np.flatnonzero(~is_vertex | ~np.isin(targets, in_bodies)).tolist():
        targets[row] = _vertex_of_point(points[row], prepared)
    return Anchors(targets, points, first)


def _vertex_of_point(point: NDArray[np.float64], prepared: PreparedMesh) -> int:
    """Find the vertex nearest to a point, of the bodies that it lies inside, or of all bodies if it lies in none."""
    holding = [body for body in prepared.bodies if body.mesh.is_closed and body.surface.contains(point[None])[0]]
    vertices = np.concatenate([body.vertices for body in holding or prepared.bodies])
    with np.errstate(over="ignore"):  # a point so far away is refused where it is attached
        distances = vector_lengths(prepared.mesh.vertices[vertices] - point)
    return int(vertices[np.argmin(distances)])
