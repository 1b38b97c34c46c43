"""A mesh as a surface to ask of: how far is it, what lies ahead, is a point inside.

Trees are libigl's and are built when first needed: bounding boxes for distances and rays; for the inside, the fast
winding number of Barill, Dickson, Schmidt, Levin, Jacobson 2018, https://doi.org/10.1145/3197517.3201337.
"""

from __future__ import annotations

__all__ = ["Surface"]

from dataclasses import dataclass
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Surface:
    """Queries on a mesh; all surfaces of one mesh share its search trees."""

    mesh: Mesh

    def _tree(self, kind: type) -> Any:
        """The mesh's tree of this kind, which the mesh keeps as it keeps all that follows from it."""
        kept = self.mesh.__dict__.setdefault("_trees", {})
        if kind not in kept:
            kept[kind] = kind()
            kept[kind].init(self.mesh.vertices, self.mesh.faces)
        return kept[kind]

    @property
    def _boxes(self) -> igl.AABB:
        return self._tree(igl.AABB)

    @property
    def _windings(self) -> igl.FastWindingNumberBVH:
        return self._tree(igl.FastWindingNumberBVH)

    def closest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(k,) distance to the surface and (k, 3) the point on it that is nearest."""
        points = np.ascontiguousarray(points)
        squared, _, nearest = self._boxes.squared_distance(self.mesh.vertices, self.mesh.faces, points)
        return np.sqrt(squared), nearest

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) distance to the surface."""
        return self.closest(points)[0]

    def ahead(self, points: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) how far the surface lies in a unit direction; infinite where it is never met."""
        points, directions = np.ascontiguousarray(points), np.ascontiguousarray(directions)
        face, far, _ = self._boxes.intersect_ray_first(self.mesh.vertices, self.mesh.faces, points, directions)
        return np.where(face >= 0, far, np.inf)

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether the surface winds round a point more than half a turn."""
        return np.abs(self._windings.winding_number(np.ascontiguousarray(points))) > 0.5
