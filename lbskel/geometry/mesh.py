"""Triangle meshes and point clouds as frozen values, validated once at the door.

A ``Mesh`` holds only what the caller gave; what follows from it (edges, components, genus) is computed when asked for
and kept. Nothing here changes a vertex or drops a face: repairs belong to :mod:`lbskel.preprocess`.
"""

from __future__ import annotations

__all__ = ["Mesh", "PointCloud", "as_mesh", "first_few", "read_only"]

import math
from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel._kernels.connectivity import component_roots, count_umbrellas
from lbskel._kernels.triangles import integrals
from lbskel.errors import MeshError, first_few
from lbskel.geometry.bvh import AABBTree, build_aabb_tree
from lbskel.geometry.conversion import arrays_of, triangulate
from lbskel.geometry.polygon_triangulation import unfold
from lbskel.geometry.sorting import numbered


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, which nobody can write to from now on."""
    array.setflags(write=False)
    return array


def _coordinates(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """A read-only (n, 3) float64 copy, or a MeshError that says what is wrong with the values."""
    try:
        points = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise MeshError(f"{what} must be an (n, 3) array of numbers: {error}") from None
    if points.size == 0:
        raise MeshError(f"the mesh is empty: there are no {what}")
    if points.ndim != 2 or points.shape[1] != 3:
        hint = "; for a planar shape add a column of zeros" if points.ndim == 2 and points.shape[1] == 2 else ""
        raise MeshError(f"{what} must have shape (n, 3), not {points.shape}{hint}")
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise MeshError(f"{what} {first_few(bad)} have NaN or infinite coordinates; remove them with their faces")
    return read_only(points)


def _triangles(values: ArrayLike, n_vertices: int) -> NDArray[np.int64]:
    """A read-only (m, 3) int64 copy with every index in range, or a MeshError that names the faces."""
    given = np.asarray(values)
    if given.size == 0:
        raise MeshError("the mesh is empty: it has no faces; a set of points is a PointCloud")
    if given.ndim != 2 or given.shape[1] != 3:
        raise MeshError(f"faces must have shape (m, 3), not {given.shape}; as_mesh() triangulates quads")
    if given.dtype.kind not in "iu" and not (given.dtype.kind == "f" and np.all(given == np.floor(given))):
        raise MeshError(f"faces must be whole numbers, not {given.dtype}")
    faces = np.array(given, dtype=np.int64, order="C")
    if faces.min() < 0 or faces.max() >= n_vertices:
        bad = np.flatnonzero(((faces < 0) | (faces >= n_vertices)).any(axis=1))
        raise MeshError(
            f"faces {first_few(bad)} use a vertex index outside 0..{n_vertices - 1}; "
            "indices are 0-based, subtract 1 from those of a 1-based file"
        )
    return read_only(faces)


_OF_CONNECTIVITY = (
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
class Mesh:
    """A triangle mesh: what the caller gave, checked, read-only.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Positions, in the caller's units.
    faces : (m, 3) array_like of int
        0-based vertex indices of each triangle.
    notes : tuple of str
        What was done to the input on its way in (quads triangulated, vertices merged), a sentence each.
    polygon_of_face : (m,) array of int, optional
        The polygon of the input that each triangle was cut from, where any was cut.

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
        object.__setattr__(self, "vertices", _coordinates(self.vertices, "vertices"))
        object.__setattr__(self, "faces", _triangles(self.faces, len(self.vertices)))

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces)"

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """The same faces on other positions; what is known of the connectivity is kept."""
        moved = Mesh(np.asarray(vertices), self.faces, self.notes, self.polygon_of_face)
        if len(moved.vertices) == len(self.vertices):
            moved.__dict__.update({name: self.__dict__[name] for name in _OF_CONNECTIVITY if name in self.__dict__})
        return moved

    @cached_property
    def _edge_table(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Unique undirected edges, and for each of the 3m half-edges the row of its edge."""
        n = len(self.vertices)
        start, end = self.half_edges.T
        key = np.minimum(start, end) * n + np.maximum(start, end)
        unique, row = numbered(key)
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

    @property
    def edge_of_half_edge(self) -> NDArray[np.int64]:
        """(3m,) row of :attr:`edges` of each half-edge."""
        return self._edge_table[1]

    @cached_property
    def faces_per_edge(self) -> NDArray[np.int64]:
        """(k,) number of faces at each edge: 2 inside a surface, 1 on its boundary."""
        return read_only(np.bincount(self.edge_of_half_edge, minlength=len(self.edges)))

    @cached_property
    def _integrals(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """The area of each face, the center of mass of all, and the volume."""
        return integrals(self.vertices, self.faces)

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """(m,) area of each triangle."""
        return read_only(self._integrals[0])

    @cached_property
    def boxes(self) -> AABBTree:
        """The faces in a tree of boxes, for searches."""
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
        """Signed volume, positive where the faces are oriented outwards; of use for closed meshes only."""
        return self._integrals[2]

    @cached_property
    def diagonal(self) -> float:
        """Length of the diagonal of the bounding box of the vertices that faces use."""
        columns = self.vertices[self.used_vertices].T.copy()  # long rows take numpy a tenth of the time of short ones
        return math.hypot(*np.ptp(columns, axis=1))

    @cached_property
    def centroid(self) -> NDArray[np.float64]:
        """(3,) center of mass of the surface."""
        if not self.area > 0:
            return read_only(self.vertices[self.faces].mean(axis=(0, 1)))
        return read_only(self._integrals[1])

    @cached_property
    def diameter_bound(self) -> float:
        """Twice the distance from the centroid to the farthest vertex in use: a size that turning does not change."""
        offsets = self.vertices[self.used_vertices] - self.centroid
        largest = float(np.abs(offsets).max())
        if not largest > 0:
            return 0.0
        offsets /= largest
        return 2 * largest * math.sqrt(np.einsum("ni,ni->n", offsets, offsets).max())

    @cached_property
    def component_of_vertex(self) -> NDArray[np.int64]:
        """(n,) number of the connected component of each vertex; components without a face come last."""
        least = component_roots(self.edges, np.zeros(len(self.vertices), dtype=np.int64))
        labels = (np.cumsum(least == np.arange(len(least))) - 1)[least]
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
        """Whether no edge has exactly one face."""
        return bool((self.faces_per_edge != 1).all())

    @cached_property
    def is_closed_manifold(self) -> bool:
        """Whether the mesh is a closed, consistently oriented surface without pinched vertices."""
        if not (self.is_edge_manifold and self.is_closed):
            return False
        return count_umbrellas(self.faces, self.edge_of_half_edge, len(self.edges)) == len(self.used_vertices)

    @cached_property
    def euler_characteristic(self) -> int:
        """Vertices in use, less edges, plus faces."""
        return len(self.used_vertices) - len(self.edges) + len(self.faces)

    @property
    def genus(self) -> int | None:
        """Number of handles, summed over the components; None unless the mesh is a closed manifold."""
        return self.n_components - self.euler_characteristic // 2 if self.is_closed_manifold else None


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points sampled from a surface: (n, 3) positions in the caller's units, checked, read-only.

    Raises
    ------
    MeshError
        If there is no point or a coordinate is not finite.
    """

    points: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _coordinates(self.points, "points"))

    def __repr__(self) -> str:
        return f"PointCloud({len(self.points)} points)"


@singledispatch
def as_mesh(data: Any) -> Mesh:
    """Convert what users have to a Mesh: (vertices, faces), a path, a trimesh, pyvista or meshio mesh, or a Mesh.

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
        If the data is not a mesh, or Mesh rejects it.
    """
    vertices, faces = arrays_of(data)
    triangles, polygon = triangulate(faces)
    mesh = Mesh(vertices, triangles)
    n_cut = int((np.bincount(polygon) > 1).sum())
    if not n_cut:
        return mesh
    note = f"{n_cut} polygons were cut into triangles"
    return Mesh(mesh.vertices, unfold(mesh.vertices, mesh.faces, polygon), (note,), polygon)


@as_mesh.register(Mesh)
def _unchanged(mesh: Mesh) -> Mesh:
    return mesh
