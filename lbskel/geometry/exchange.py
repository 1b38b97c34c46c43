"""Meshes and point clouds as objects of other packages, and their interactive view."""

from __future__ import annotations

__all__ = ["CloudExchange", "CopiedByFields", "MeshExchange"]

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from lbskel.display import Displayed
from lbskel.errors import MissingDependency

if TYPE_CHECKING:
    from numpy.typing import NDArray


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise MissingDependency("pyvista", "pyvista", "to_pyvista()") from None
    return pyvista


class CopiedByFields:
    """A dataclass of which copies and pickles hold the fields alone.

    So arrays of a copy are constant too, and what is cached, such as search trees, is computed anew.
    """

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return type(self), tuple(getattr(self, each.name) for each in fields(self))  # type: ignore[arg-type]


class MeshExchange(CopiedByFields, Displayed):
    """Conversion of a mesh to objects of other packages, and its interactive view."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]

    def plot(self) -> Any:
        """Make an interactive view, which a notebook shows; ``plot().save("mesh.html")`` writes it.

        Raises
        ------
        MissingDependency
            If plotly is not installed.
        """
        return self._plot(mesh=self, title=repr(self))

    def to_trimesh(self) -> Any:
        """Convert to a ``trimesh.Trimesh`` with the same vertices and faces, in their order."""
        import trimesh

        return trimesh.Trimesh(self.vertices.copy(), self.faces.copy(), process=False)

    def to_pyvista(self) -> Any:
        """Convert to a ``pyvista.PolyData`` with the same vertices and faces, in their order.

        Raises
        ------
        MissingDependency
            If pyvista is not installed.
        """
        return _pyvista().PolyData.from_regular_faces(self.vertices.copy(), self.faces.copy())


class CloudExchange(CopiedByFields, Displayed):
    """Conversion of a point cloud to objects of other packages, and its interactive view."""

    points: NDArray[np.float64]

    def plot(self) -> Any:
        """Make an interactive view, which a notebook shows; ``plot().save("cloud.html")`` writes it.

        Raises
        ------
        MissingDependency
            If plotly is not installed.
        """
        return self._plot(mesh=self, title=repr(self))

    def to_trimesh(self) -> Any:
        """Convert to a ``trimesh.PointCloud``."""
        from trimesh import PointCloud

        make: Any = PointCloud  # without types
        return make(self.points.copy())

    def to_pyvista(self) -> Any:
        """Convert to a ``pyvista.PolyData`` of vertices.

        Raises
        ------
        MissingDependency
            If pyvista is not installed.
        """
        return _pyvista().PolyData(self.points.copy())
