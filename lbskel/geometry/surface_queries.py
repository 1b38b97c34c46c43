"""Surface queries: closest point, ray distance, inside test.

Search trees are built when first needed: bounding boxes for distances, rays, and the inside test of closed manifolds;
those of :mod:`lbskel.geometry.winding` for the inside test of other meshes.

Trees and recent results are cached in the ``__dict__`` of the mesh. The cache only holds values that follow from the
mesh, so the mesh stays the same value; meshes of ``with_vertices`` start with an empty cache.
"""

from __future__ import annotations

__all__ = ["Proxy", "Surface"]

import atexit
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar
from weakref import WeakSet

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.arrays import read_only
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.geometry.winding import WindingNumbers, winding_numbers_of

MAX_CACHED_RESULTS = 16  # recent results of each query that a mesh keeps; a guess that bounds the memory

VERTEX_OFFSET = 1e-6  # distance under the surface, relative to the diameter bound, at which inward rays start; a guess


Result = TypeVar("Result")


_meshes_with_winding_tree: WeakSet[Mesh] = WeakSet()


@atexit.register
def _drop_winding_trees() -> None:
    """Free libigl's trees at exit: of those that a daemon thread still holds, nanobind would report a leak."""
    for mesh in list(_meshes_with_winding_tree):
        mesh.__dict__.get("_searches", {}).pop("winding tree", None)


@dataclass(frozen=True, eq=False)
class Proxy:
    """A simplified copy of a mesh, used where the result need not be exact.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : VertexMap
        From the vertices of the full mesh to those of the proxy; every vertex has a target.
    source_vertices : (k,) array of int
        For each vertex of the proxy one vertex of the full mesh.
    deviation : float
        Upper bound on the distance of the two surfaces, in the units of the mesh.
    """

    mesh: Mesh
    vertex_map: VertexMap
    source_vertices: NDArray[np.int64]
    deviation: float


@dataclass(frozen=True, eq=False)
class Surface:
    """Queries on a mesh; all surfaces of one mesh share its search trees and cached results.

    Parameters
    ----------
    mesh : Mesh
    simplified : Proxy, optional
        A simplified copy of the mesh, for ``proxy``, ``on_proxy``, ``from_proxy`` and ``clearance``.
    deadline : Deadline
        Queries raise OutOfTime after it.
    """

    mesh: Mesh
    simplified: Proxy | None = None
    deadline: Deadline = NEVER

    @property
    def proxy(self) -> Surface:
        """The simplified mesh as a surface, or this surface if there is none."""
        return self if self.simplified is None else Surface(self.simplified.mesh, deadline=self.deadline)

    def on_proxy(self, values: NDArray[np.int64]) -> NDArray[np.int64]:
        """Transfer values from the vertices of the mesh to those of the proxy.

        Parameters
        ----------
        values : (n,) array of int
        """
        return values if self.simplified is None else values[self.simplified.source_vertices]

    def from_proxy(self, values: NDArray[Any]) -> NDArray[Any]:
        """Transfer values from the vertices of the proxy to those of the mesh.

        Parameters
        ----------
        values : (k,) array
        """
        return values if self.simplified is None else self.simplified.vertex_map.pull_back(values)

    def memoize(self, name: str, make: Callable[[], Any]) -> Any:
        """Return a value that follows from the mesh, computed at the first call and cached in the mesh.

        Parameters
        ----------
        name : str
            Key in the cache.
        make : callable
            Computes the value.
        """
        cache = self.mesh.__dict__.setdefault("_searches", {})
        if name not in cache:
            cache[name] = make()
        return cache[name]

    def has(self, name: str) -> bool:
        """Whether a value is cached in the mesh.

        Parameters
        ----------
        name : str
            Key in the cache.
        """
        return name in self.mesh.__dict__.get("_searches", {})

    def recall(self, name: str, query: Callable[[], Result], *arrays: NDArray[Any]) -> Result:
        """Return the result of a recent query for the same arrays: several stages query the same skeleton.

        Parameters
        ----------
        name : str
            Of the query, which has a cache of its own.
        query : callable
            Computes the result.
        arrays : arrays
            All that the result depends on but the mesh.
        """
        results: dict[tuple[bytes, ...], Result] = self.memoize(f"results of {name}", dict)
        key = tuple(array.tobytes() for array in arrays)
        if (found := results.get(key)) is None:
            found = results[key] = query()
            for oldest in [*results][:-MAX_CACHED_RESULTS]:  # other threads may do the same
                results.pop(oldest, None)
        return found

    def _winding_numbers(self) -> WindingNumbers:
        """Build the trees for winding numbers, and note that the mesh keeps one of libigl."""
        _meshes_with_winding_tree.add(self.mesh)
        return winding_numbers_of(self.mesh)

    def inner_offset(
        self, vertices: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """(k, 3) points just inside some vertices, (k, 3) unit directions inwards, (k,) distances to the opposite side.

        A ray that hits nothing has distance 0.

        Parameters
        ----------
        vertices : (k,) array of int
            Numbers of vertices.
        """
        entry, inward, thickness = self.inward_rays
        unknown = vertices[np.isnan(thickness[vertices])]
        if len(unknown):
            distance = self.ray_distance(entry[unknown], inward[unknown])
            thickness[unknown] = np.where(np.isfinite(distance), distance, 0.0)
        return entry[vertices], inward[vertices], thickness[vertices]

    @property
    def vertex_tree(self) -> cKDTree:
        """Search tree of the vertices."""
        return self.memoize("vertex tree", lambda: cKDTree(self.mesh.vertices))

    @property
    def inward_rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The result of ``inner_offset`` for all vertices; distances are NaN where they have not been measured."""
        rays: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
        rays = self.memoize("inward", self._inward_rays)
        return rays

    def _inward_rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Compute the ray of every vertex, and an array of NaN that caches the thickness measured so far."""
        V, F = self.mesh.vertices, self.mesh.faces
        outward = igl.per_vertex_normals(V, F, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE)
        inward = -np.nan_to_num(outward)  # zero where all faces of a vertex are degenerate
        inward = -inward if self.mesh.volume < 0 else inward
        return V + VERTEX_OFFSET * self.mesh.diameter_bound * inward, inward, np.full(len(V), np.nan)

    def closest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(k,) distance to the surface, and (k, 3) closest point on it.

        Parameters
        ----------
        points : (k, 3) array of float
        """
        points = np.ascontiguousarray(points)
        return self.recall("closest", lambda: self._closest(points), points)

    def _closest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        distance, nearest = self.mesh.aabb_tree.nearest(points, deadline=self.deadline)
        return read_only(distance), read_only(nearest)

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) distance to the surface.

        Parameters
        ----------
        points : (k, 3) array of float
        """
        return self.closest(points)[0]

    def clearance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) lower bound on the distance to the surface, exact if there is no proxy.

        Parameters
        ----------
        points : (k, 3) array of float
        """
        if self.simplified is None:
            return self.distance(points)
        return np.maximum(self.proxy.distance(points) - self.simplified.deviation, 0.0)

    def ray_distance(self, points: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) distance to the surface along a direction; infinite where the ray hits nothing.

        Parameters
        ----------
        points, directions : (k, 3) array of float
            Directions of length 1.
        """
        return self.mesh.aabb_tree.first_hits(points, directions, deadline=self.deadline)[1]

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether a point lies inside: whether the absolute winding number is above 1/2.

        Parameters
        ----------
        points : (k, 3) array of float
        """
        points = np.ascontiguousarray(points)
        return self.recall("contains", lambda: read_only(self._contains(points)), points)

    def _contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        is_inside: NDArray[np.bool_]
        if self.mesh.is_closed_manifold:
            is_inside = self.mesh.aabb_tree.winding_numbers(points, deadline=self.deadline) != 0
        else:
            numbers: WindingNumbers = self.memoize("winding tree", self._winding_numbers)
            is_inside = numbers.contain(points, deadline=self.deadline)
        return is_inside
