"""A mesh as a surface to ask of: how far is it, what lies ahead, is a point inside.

Trees are built when first needed: boxes for distances and rays, and for the inside of what is closed; for that of other
meshes libigl's fast winding number of Barill, Dickson, Schmidt, Levin, Jacobson 2018,
https://doi.org/10.1145/3197517.3201337.
"""

from __future__ import annotations

__all__ = ["Proxy", "Surface"]

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh, read_only
from lbskel.geometry.vertex_map import VertexMap

REMEMBERED = 16  # answers at most


@dataclass(frozen=True, eq=False)
class Proxy:
    """About the same surface in fewer triangles, for what need not be exact.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : VertexMap
        From the vertices of the full mesh to those of this one; every vertex has a target.
    source_vertices : (k,) array of int
        For each vertex of this mesh one vertex of the full mesh that it stands for.
    deviation : float
        How far the two may be apart.
    """

    mesh: Mesh
    vertex_map: VertexMap
    source_vertices: NDArray[np.int64]
    deviation: float


@dataclass(frozen=True, eq=False)
class Surface:
    """Queries on a mesh; all surfaces of one mesh share its search trees.

    Parameters
    ----------
    mesh : Mesh
    simplified : Proxy, optional
    """

    mesh: Mesh
    simplified: Proxy | None = None

    @property
    def proxy(self) -> Surface:
        """The simplified mesh as a surface, or this one where there is none."""
        return self if self.simplified is None else Surface(self.simplified.mesh)

    def on_proxy(self, values: NDArray[np.int64]) -> NDArray[np.int64]:
        """Values at vertices of the mesh, at those of the rough one."""
        return values if self.simplified is None else values[self.simplified.source_vertices]

    def from_proxy(self, values: NDArray[np.int64]) -> NDArray[np.int64]:
        """Values at vertices of the rough mesh, at those of this one."""
        return values if self.simplified is None else self.simplified.vertex_map.pull_back(values)

    def memoize(self, name: str, make: Callable[[], Any]) -> Any:
        """What is made when first asked for, and kept by the mesh as it keeps all that follows from it."""
        kept = self.mesh.__dict__.setdefault("_searches", {})
        if name not in kept:
            kept[name] = make()
        return kept[name]

    def _remembered(self, name: str, points: NDArray[np.float64], answer: Callable[[], Any]) -> Any:
        """What was answered to the same question of late: the nodes of a skeleton are asked for by several stages."""
        answers = self.memoize("answers", dict)
        question = name, points.tobytes()
        if question not in answers:
            while len(answers) >= REMEMBERED:
                del answers[next(iter(answers))]
            answers[question] = answer()
        return answers[question]

    @property
    def _windings(self) -> igl.FastWindingNumberBVH:
        return self.memoize("windings", self._winding_tree)

    def _winding_tree(self) -> igl.FastWindingNumberBVH:
        tree = igl.FastWindingNumberBVH()
        tree.init(self.mesh.vertices, self.mesh.faces)
        return tree

    def inner_offset(
        self, vertices: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """(k, 3) places just under some vertices, (k, 3) unit directions in from there, (k,) the thickness there."""
        entry, inward, thickness = self.memoize("inward", self._inward)
        unknown = vertices[np.isnan(thickness[vertices])]
        if len(unknown):
            ahead = self.ray_distance(entry[unknown], inward[unknown])
            thickness[unknown] = np.where(np.isfinite(ahead), ahead, 0.0)
        return entry[vertices], inward[vertices], thickness[vertices]

    def _inward(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The places and directions at all vertices, and an array of NaN for what thickness comes to be known."""
        V, F = self.mesh.vertices, self.mesh.faces
        outward = igl.per_vertex_normals(V, F, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE)
        inward = -np.nan_to_num(outward)  # a vertex all of whose faces are degenerate has none
        inward = -inward if self.mesh.volume < 0 else inward
        return V + 1e-6 * self.mesh.diameter_bound * inward, inward, np.full(len(V), np.nan)

    def closest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(k,) distance to the surface and (k, 3) the point on it that is nearest."""
        points = np.ascontiguousarray(points)
        return self._remembered("closest", points, lambda: self._closest(points))

    def _closest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        distance, nearest = self.mesh.boxes.nearest(points)
        return read_only(distance), read_only(nearest)

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) distance to the surface."""
        return self.closest(points)[0]

    def clearance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) radii of balls that the surface does not cut: the distance to it, or less where a rough one is asked."""
        if self.simplified is None:
            return self.distance(points)
        return np.maximum(self.proxy.distance(points) - self.simplified.deviation, 0.0)

    def ray_distance(self, points: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) how far the surface lies in a unit direction; infinite where it is never met."""
        return self.mesh.boxes.first_hits(points, directions)[1]

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether the surface winds round a point more than half a turn."""
        points = np.ascontiguousarray(points)
        return self._remembered("contains", points, lambda: read_only(self._contains(points)))

    def _contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        if self.mesh.is_closed_manifold:
            return self.mesh.boxes.windings(points) != 0
        return np.abs(self._windings.winding_number(points)) > 0.5
