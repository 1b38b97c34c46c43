"""Maps from the vertices of one mesh to those of another, which transfer labels and node maps between them."""

from __future__ import annotations

__all__ = ["VertexMap", "is_in_largest_piece"]

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel._kernels.connectivity import component_roots
from lbskel.errors import MeshError
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class VertexMap:
    """A map from n source vertices to target vertices.

    Parameters
    ----------
    indices : (n,) array of int
        Target vertex of each source vertex; -1 where it has none.

    Examples
    --------
    >>> import lbskel
    >>> import numpy as np
    >>> merged = lbskel.VertexMap([0, 0, 1])  # the first two of three vertices were merged
    >>> merged.pull_back(np.array([7, 8])).tolist()
    [7, 7, 8]
    """

    indices: NDArray[np.int64]

    def __post_init__(self) -> None:
        with np.errstate(invalid="ignore"):  # of NaN, which is no whole number
            indices = np.array(self.indices, dtype=np.int64).reshape(-1)
        if not np.array_equal(indices, np.ravel(self.indices)):
            raise MeshError("indices of a vertex map must be whole numbers")
        object.__setattr__(self, "indices", read_only(indices))

    def __len__(self) -> int:
        return len(self.indices)

    @classmethod
    def identity(cls, n_vertices: int) -> VertexMap:
        """Make the map of n vertices to themselves.

        Parameters
        ----------
        n_vertices : int
        """
        return cls(np.arange(n_vertices))

    @property
    def is_mapped(self) -> NDArray[np.bool_]:
        """(n,) whether a source vertex has a target."""
        return self.indices >= 0

    @property
    def is_identity(self) -> bool:
        """Whether every source vertex is its own target."""
        return bool(np.array_equal(self.indices, np.arange(len(self.indices))))

    def compose(self, following: VertexMap) -> VertexMap:
        """Return the map that applies this map and then another.

        Parameters
        ----------
        following : VertexMap
            Its sources are the targets of this map.
        """
        return VertexMap(self.pull_back(following.indices))

    def pull_back(self, values: NDArray[Any]) -> NDArray[Any]:
        """(n,) values at the sources, each that of its target; -1 at sources without a target.

        Parameters
        ----------
        values : (n_targets,) array
        """
        return np.where(self.is_mapped, values[self.indices], -1)

    def push_forward(self, values: NDArray[np.int64], n_targets: int) -> NDArray[np.int64]:
        """(n_targets,) integers at the targets, each that of its first source; -1 at targets without a source.

        Parameters
        ----------
        values : (n,) array of int
        n_targets : int
        """
        result = np.full(n_targets, -1)
        mapped = np.flatnonzero(self.is_mapped)[::-1]
        result[self.indices[mapped]] = values[mapped]
        return result

    def one_source_per_target(self, n_targets: int) -> NDArray[np.int64]:
        """(n_targets,) last source vertex of each target; -1 where it has none.

        Parameters
        ----------
        n_targets : int
        """
        result = np.full(n_targets, -1)
        mapped = np.flatnonzero(self.is_mapped)
        result[self.indices[mapped]] = mapped
        return result

    def complete(self, sources: NDArray[np.float64], targets: NDArray[np.float64]) -> VertexMap:
        """Return the map in which every source without a target is mapped to the nearest target.

        Parameters
        ----------
        sources : (n, 3) array of float
        targets : (k, 3) array of float
            In the same coordinates.
        """
        if self.is_mapped.all():
            return self
        indices, missing = np.array(self.indices), ~self.is_mapped
        indices[missing] = cKDTree(targets).query(sources[missing])[1]
        return VertexMap(indices)


def is_in_largest_piece(
    targets: NDArray[np.int64], mesh: Mesh, tested: NDArray[np.int64] | None = None
) -> NDArray[np.bool_]:
    """(n,) whether a vertex belongs to the largest connected piece of the vertices that have its target.

    Of pieces with as many vertices, the one with the smallest vertex index counts. Vertices of target -1 always belong.

    Parameters
    ----------
    targets : (n,) array of int
    mesh : Mesh
        Whose edges connect the vertices.
    tested : array of int, optional
        The targets to test; the vertices of each other target are taken to be connected. All by default.

    Raises
    ------
    ValueError
        If there is not one target for each vertex.
    """
    if len(targets) != len(mesh.vertices):
        raise ValueError("there must be a target for each vertex")
    labels = targets if tested is None else np.where(np.isin(targets, tested), targets, -1)
    piece = component_roots(mesh.edges, labels)
    size = np.bincount(piece)
    first = np.flatnonzero(size)
    order = np.lexsort((first, -size[first], targets[first]))
    is_largest = np.zeros(len(size), dtype=bool)
    is_largest[first[order[np.diff(targets[first[order]], prepend=-1) > 0]]] = True
    result: NDArray[np.bool_] = is_largest[piece] | (labels < 0)
    return result
