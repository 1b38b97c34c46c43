"""Scenes that trimesh has read, as one mesh: every instance where the scene places it, in the order of the file."""

from __future__ import annotations

__all__ = ["polygons_of_scene"]

from typing import Any

import numpy as np

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import Polygons


def polygons_of_scene(scene: Any) -> Polygons:
    """The triangles of all meshes in a trimesh scene."""
    import trimesh

    meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    if not meshes:
        raise FormatError("the scene holds no triangles")
    order = {name: index for index, name in enumerate(scene.geometry)}  # of the file; dump() has that of the nodes
    meshes.sort(key=lambda mesh: order[mesh.metadata["name"]])
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    corners = np.concatenate([_corners(mesh) + offset for mesh, offset in zip(meshes, offsets, strict=False)])
    notes = (f"{len(meshes)} meshes of the scene were joined into one",) if len(meshes) > 1 else ()
    points = np.concatenate([mesh.vertices for mesh in meshes])
    return Polygons(points, corners, np.full(len(corners) // 3, 3), notes)


def _corners(mesh: Any) -> np.ndarray:
    """The flat vertex indices of a trimesh, refused where they would reach into the mesh that follows."""
    corners = np.asarray(mesh.faces, dtype=np.int64).reshape(-1)
    if corners.size and (corners.min() < 0 or corners.max() >= len(mesh.vertices)):
        raise FormatError(f"indices of a mesh name vertices outside of its {len(mesh.vertices)}")
    return corners
