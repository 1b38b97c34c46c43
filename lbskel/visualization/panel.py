"""What one drawing of a picture shows: finished values, checked, nothing drawn yet."""

from __future__ import annotations

__all__ = ["Panel"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import Shape


@dataclass(frozen=True, eq=False)
class Panel:
    """One drawing of a picture: a surface or points, a skeleton in it, or both.

    Parameters
    ----------
    mesh : Mesh or PointCloud, optional
    skeleton : Skeleton, optional
    title : str
    field : (n,) array_like of float, optional
        A number for each vertex of the mesh, shown by color. NaN and infinity are shown gray.
    field_name : str
        What the field is. Fields of the same name in one picture have the same colors for the same numbers.

    Raises
    ------
    MeshError
        If there is nothing to draw, or the field is not one number for each vertex of a mesh.
    """

    mesh: Mesh | PointCloud | None = None
    skeleton: Skeleton | None = None
    title: str = ""
    field: NDArray[np.float64] | None = None
    field_name: str = ""

    def __post_init__(self) -> None:
        if self.mesh is None and self.skeleton is None:
            raise MeshError("a panel needs a mesh, a point cloud or a skeleton to draw")
        if self.field is not None:
            field = np.array(self.field, dtype=np.float64)
            wanted = (len(self.mesh.vertices),) if isinstance(self.mesh, Mesh) else ()
            if field.shape != wanted:
                raise MeshError(f"the field must be one number for each vertex of a mesh, {wanted}, not {field.shape}")
            field[~np.isfinite(field)] = np.nan
            field.setflags(write=False)
            object.__setattr__(self, "field", field)

    @property
    def shape(self) -> Shape:
        """What the direction of view is taken from: the mesh if there is one."""
        shape = self.mesh if self.mesh is not None else self.skeleton
        assert shape is not None  # see __post_init__
        return shape

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3) points that must fit into the drawing."""
        points = [self.skeleton.nodes] if self.skeleton is not None else []
        if isinstance(self.mesh, Mesh):
            points.append(
                self.mesh.vertices[np.bincount(self.mesh.faces.ravel(), minlength=len(self.mesh.vertices)) > 0]
            )
        elif self.mesh is not None:
            points.append(self.mesh.points)
        return np.concatenate(points)
