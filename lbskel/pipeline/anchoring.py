"""Anchors of the caller, converted to vertices and points of a prepared mesh and of its bodies."""

from __future__ import annotations

__all__ = ["Anchors", "resolve_anchors"]

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.preparation import Body, PreparedMesh
from lbskel.refinement.anchors import resolve_anchor


@dataclass(frozen=True, eq=False)
class Anchors:
    """Points at which a skeleton must have a node.

    Parameters
    ----------
    vertices : (a,) array of int
        The vertex at or nearest to each point.
    points : (a, 3) array of float
        In the unit coordinates of the prepared mesh.
    """

    vertices: NDArray[np.int64]
    points: NDArray[np.float64]

    def within(self, body: Body) -> Anchors:
        """Select the anchors of one body of the prepared mesh, by the body's own vertices."""
        is_within = np.isin(self.vertices, body.vertices)
        return Anchors(np.searchsorted(body.vertices, self.vertices[is_within]), self.points[is_within])


def resolve_anchors(anchors: Iterable[Any], prepared: PreparedMesh) -> Anchors:
    """Convert anchors of the source mesh to vertices and points of the prepared mesh.

    Parameters
    ----------
    anchors : iterable of int or (3,) array_like
        Vertices of the source, or points in the caller's coordinates.
    prepared : PreparedMesh

    Raises
    ------
    MeshError
        If the anchors are not a list, or one is neither a vertex of the source nor a point.
    """
    if isinstance(anchors, str) or not isinstance(anchors, Iterable):
        raise MeshError(f"anchors must be a list of vertices or points, such as [0] or [(x, y, z)], not {anchors!r}")
    resolved = [resolve_anchor(anchor, prepared.source) for anchor in anchors]
    points = prepared.to_unit(np.array([point for _, point in resolved]).reshape(-1, 3))
    targets = prepared.vertex_map.indices[np.array([vertex for vertex, _ in resolved], dtype=np.int64)]
    return Anchors(VertexMap(targets).complete(points, prepared.mesh.vertices).indices, points)
