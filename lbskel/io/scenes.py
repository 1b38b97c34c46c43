"""Scenes loaded by trimesh as one mesh: all instances with their transforms applied, in the order of the file."""

from __future__ import annotations

__all__ = ["polygons_from_scene"]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import PolygonSoup


def polygons_from_scene(scene: Any) -> PolygonSoup:
    """Join the triangles of all meshes in a trimesh scene."""
    import trimesh

    meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    if not meshes:
        raise FormatError("the scene has no triangles")
    order = {name: index for index, name in enumerate(scene.geometry)}  # file order; dump() has the order of the nodes
    meshes.sort(key=lambda mesh: order[mesh.metadata["name"]])
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    corners = np.concatenate([_corners(mesh) + offset for mesh, offset in zip(meshes, offsets, strict=False)])
    notes = (f"{len(meshes)} meshes of the scene were joined into one",) if len(meshes) > 1 else ()
    points = np.concatenate([mesh.vertices for mesh in meshes])
    return PolygonSoup(points, corners, np.full(len(corners) // 3, 3), notes)


def _corners(mesh: Any) -> NDArray[np.int64]:
    """Return the flat vertex indices of a trimesh; a FormatError if one would point into another mesh."""
    corners = np.asarray(mesh.faces, dtype=np.int64).reshape(-1)
    if corners.size and (corners.min() < 0 or corners.max() >= len(mesh.vertices)):
        raise FormatError(f"a mesh of the scene has vertex indices outside 0..{len(mesh.vertices) - 1}")
    return corners
