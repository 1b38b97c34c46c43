"""Triangle meshes as frozen values, validated when they are made; point clouds are in ``point_cloud``.

A ``Mesh`` holds only what the caller gave. What can be derived (edges, components, genus) is computed at first use and
cached in its ``__dict__``, also by :mod:`lbskel.geometry.surface_queries`. Nothing here moves a vertex or removes a
face: repairs belong to :mod:`lbskel.preprocess`.
"""

from __future__ import annotations

__all__ = ["Mesh", "PointCloud", "as_mesh"]

import math
from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel._kernels.connectivity import component_roots, count_umbrellas
from lbskel._kernels.triangles import integrals
from lbskel.errors import counted, were
from lbskel.geometry.arrays import checked_points, checked_triangles, read_only
from lbskel.geometry.bvh import AABBTree, build_aabb_tree
from lbskel.geometry.conversion import arrays_of, triangulate
from lbskel.geometry.exchange import MeshExchange
from lbskel.geometry.normals import normalized, triangle_normals, vector_lengths
from lbskel.geometry.point_cloud import PointCloud
from lbskel.geometry.polygon_triangulation import retriangulate_nonconvex
from lbskel.geometry.scaling import unit_vertices
from lbskel.geometry.sorting import unique_inverse

# Cached properties that depend on the faces alone
_CONNECTIVITY_PROPERTIES = (
    "_edge_table",
    "used_vertices",
    "half_edges",
    "faces_per_edge",
    "component_of_vertex",
    "n_components",
    "is_edge_manifold",
    "is_closed",
    "is_closed_manifold",
    "euler_characteristic",
)


@dataclass(frozen=True, eq=False)
class Mesh(MeshExchange):
    """A triangle mesh: validated, read-only vertices and faces.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Positions, in the caller's units.
    faces : (m, 3) array_like of int
        0-based vertex indices of each triangle.
    notes : tuple of str
        What was done to the input (quads triangulated, vertices merged), a sentence each.
    polygon_of_face : (m,) array of int, optional
        The polygon of the input that each triangle was cut from, if any polygon was.

    Raises
    ------
    MeshError
        If a coordinate is not finite, an index is out of range, or there is no vertex or face.

    Examples
    --------
    >>> import lbskel
    >>> tetrahedron = lbskel.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ...                           [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> tetrahedron.is_closed_manifold, tetrahedron.genus
    (True, 0)
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    polygon_of_face: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", checked_points(self.vertices, "vertices"))
        object.__setattr__(self, "faces", checked_triangles(self.faces, len(self.vertices)))

    def __repr__(self) -> str:
        return f"Mesh({counted(len(self.vertices), 'vertex')}, {counted(len(self.faces), 'face')})"

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """Make a mesh with the same faces and other positions; cached properties of the connectivity are kept.

        Parameters
        ----------
        vertices : (n, 3) array_like of float
        """
        moved = Mesh(np.asarray(vertices), self.faces, self.notes, self.polygon_of_face)
        if len(moved.vertices) == len(self.vertices):
            moved.__dict__.update(
                {name: self.__dict__[name] for name in _CONNECTIVITY_PROPERTIES if name in self.__dict__}
            )
        return moved

    @cached_property
    def _edge_table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Unique undirected edges, and for each of the 3m half-edges the row of its edge."""
        n = len(self.vertices)
        start, end = self.half_edges.T
        key = np.minimum(start, end) * n + np.maximum(start, end)
        unique, row = unique_inverse(key)
        edges = np.stack([unique // n, unique % n], axis=1)
        return read_only(edges), read_only(row)

    @cached_property
    def half_edges(self) -> NDArray[np.int64]:
        """(3m, 2) directed edges; half-edge ``k`` lies opposite corner ``k // m`` of face ``k % m``."""
        F = self.faces
        return read_only(np.concatenate([F[:, [1, 2]], F[:, [2, 0]], F[:, [0, 1]]]))

    @property
    def edges(self) -> NDArray[np.int64]:
        """(k, 2) unique undirected edges, smaller index first, in lexicographic order."""
        return self._edge_table[0]

    @cached_property
    def edge_lengths(self) -> NDArray[np.float64]:
        """(k,) length of each edge."""
        start, end = self.edges.T
        return read_only(vector_lengths(self.vertices.take(end, axis=0) - self.vertices.take(start, axis=0)))

    @property
    def longest_edges(self) -> NDArray[np.float64]:
        """(n,) length of the longest edge at each vertex, 0 without an edge."""
        longest = np.zeros(len(self.vertices))
        np.maximum.at(longest, self.edges, self.edge_lengths[:, None])
        return read_only(longest)

    @property
    def edge_of_half_edge(self) -> NDArray[np.int64]:
        """(3m,) row of :attr:`edges` of each half-edge."""
        return self._edge_table[1]

    @cached_property
    def faces_per_edge(self) -> NDArray[np.int64]:
        """(k,) number of faces at each edge: 2 in the interior of a surface, 1 on its boundary."""
        return read_only(np.bincount(self.edge_of_half_edge, minlength=len(self.edges)))

    @cached_property
    def _integrals(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """Area of each face, centroid of the surface, and volume."""
        unit, k = unit_vertices(self)  # squared areas overflow above 1e76, vanish below 1e-80
        areas, centroid, volume = integrals(unit, self.faces)
        with np.errstate(over="ignore", under="ignore"):
            return np.ldexp(areas, 2 * k), np.ldexp(centroid, k), float(np.ldexp(volume, 3 * k))

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """(m,) area of each triangle."""
        return read_only(self._integrals[0])

    @cached_property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(n,) a third of the area of the faces at each vertex."""
        thirds = np.repeat(self.face_areas / 3, 3)
        return read_only(np.bincount(self.faces.ravel(), thirds, minlength=len(self.vertices)).astype(np.float64))

    @cached_property
    def face_normals(self) -> NDArray[np.float64]:
        """(m, 3) unit normal of each triangle, outwards where the faces are oriented so; zero for degenerate ones."""
        return read_only(normalized(triangle_normals(*self.vertices.take(self.faces.T, axis=0))))

    @cached_property
    def aabb_tree(self) -> AABBTree:
        """The faces in a tree of bounding boxes, for searches."""
        return build_aabb_tree(self.vertices, self.faces)

    @cached_property
    def used_vertices(self) -> NDArray[np.int64]:
        """(u,) vertices that belong to a face, in ascending order."""
        return read_only(np.flatnonzero(np.bincount(self.faces.ravel(), minlength=len(self.vertices))))

    @cached_property
    def area(self) -> float:
        """Total area."""
        return float(self.face_areas.sum())

    @property
    def volume(self) -> float:
        """Signed volume, positive where the faces are oriented outwards; meaningful only for closed meshes."""
        return self._integrals[2]

    @cached_property
    def diagonal(self) -> float:
        """Length of the diagonal of the bounding box of the vertices that faces use."""
        # numpy reduces long rows in a tenth of the time of short ones
        columns = self.vertices[self.used_vertices].T.copy()
        return math.hypot(*np.ptp(columns, axis=1))

    @cached_property
    def centroid(self) -> NDArray[np.float64]:
        """(3,) center of mass of the surface; of the corners of all faces, if it has no area."""
        if not self.area > 0:
            return read_only(self.vertices[self.faces].mean(axis=(0, 1)))
        return read_only(self._integrals[1])

    @cached_property
    def diameter_bound(self) -> float:
        """Twice the largest distance of a used vertex from the centroid: an upper bound on the diameter.

        Unlike the bounding box, it does not change when the mesh is rotated.
        """
        offsets = self.vertices.take(self.used_vertices, axis=0) - self.centroid
        largest = float(np.abs(offsets).max()) or 1.0
        offsets /= largest
        return 2 * largest * math.sqrt(np.einsum("ni,ni->n", offsets, offsets).max())

    @cached_property
    def component_of_vertex(self) -> NDArray[np.int64]:
        """(n,) number of the connected component of each vertex; components without a face come last."""
        first = component_roots(self.edges, np.zeros(len(self.vertices), dtype=np.int64))
        labels = (np.cumsum(first == np.arange(len(first))) - 1)[first]
        has_face = np.zeros(labels.max() + 1, dtype=bool)
        has_face[labels[self.faces[:, 0]]] = True
        rank = np.argsort(np.argsort(~has_face, kind="stable"), kind="stable")
        return read_only(rank[labels])

    @cached_property
    def n_components(self) -> int:
        """Number of connected components that have a face."""
        return int(self.component_of_vertex[self.faces[:, 0]].max()) + 1

    @cached_property
    def is_edge_manifold(self) -> bool:
        """Whether no edge has more than two faces and no face uses a vertex twice."""
        F = self.faces
        distinct = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
        return bool(distinct.all() and self.faces_per_edge.max() <= 2)

    @cached_property
    def is_closed(self) -> bool:
        """Whether no edge has exactly one face; edges of three or more faces are allowed."""
        return bool((self.faces_per_edge != 1).all())

    @cached_property
    def is_closed_manifold(self) -> bool:
        """Whether the mesh is a closed, consistently oriented surface without pinched vertices."""
        if not (self.is_edge_manifold and self.is_closed):
            return False
        n_umbrellas: int = count_umbrellas(self.faces, self.edge_of_half_edge, len(self.edges))
        return n_umbrellas == len(self.used_vertices)

    @cached_property
    def euler_characteristic(self) -> int:
        """Number of used vertices minus edges plus faces."""
        return len(self.used_vertices) - len(self.edges) + len(self.faces)

    @property
    def genus(self) -> int | None:
        """Number of handles, summed over the components; None unless the mesh is a closed manifold."""
        return self.n_components - self.euler_characteristic // 2 if self.is_closed_manifold else None


@singledispatch
def as_mesh(data: Any) -> Mesh:
    """Convert a pair (vertices, faces), a path, or a trimesh, pyvista or meshio mesh to a Mesh.

    Polygons are triangulated, and ``notes`` says so. A Mesh is returned unchanged. Paths are read by
    :func:`lbskel.read_mesh`, which :mod:`lbskel.io` registers for str and os.PathLike.

    Parameters
    ----------
    data : Mesh, path-like, pair of array_like, or mesh object
        A pair is (n, 3) vertices and faces, where a face is a sequence of 0-based vertex indices.

    Raises
    ------
    FormatError
        If the data is a path and no mesh can be read from it.
    MeshError
        If the data is not a mesh, or not a valid one: see :class:`Mesh`.

    Examples
    --------
    >>> import lbskel
    >>> lbskel.as_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    Mesh(4 vertices, 2 faces)
    """
    vertices, faces = arrays_of(data)
    triangles, polygon = triangulate(faces)
    mesh = Mesh(vertices, triangles)
    n_cut = int((np.bincount(polygon) > 1).sum())
    if not n_cut:
        return mesh
    note = f"{were(n_cut, 'polygon')} cut into triangles"
    triangles, notes = retriangulate_nonconvex(mesh.vertices, mesh.faces, polygon)
    return Mesh(mesh.vertices, triangles, (note, *notes), polygon)


@as_mesh.register(Mesh)
def _unchanged(mesh: Mesh) -> Mesh:
    return mesh
