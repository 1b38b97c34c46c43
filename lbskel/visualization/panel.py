"""The content of one drawing of a picture, checked when it is made."""

from __future__ import annotations

__all__ = ["Panel"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import Drawable


@dataclass(frozen=True, eq=False)
class Panel:
    """One drawing of a picture: a mesh or point cloud, a skeleton, or both.

    Parameters
    ----------
    mesh : Mesh or PointCloud, optional
    skeleton : Skeleton, optional
        In the coordinates of the mesh.
    title : str
        Text above the drawing.
    field : (n,) array_like of float, optional
        A number for each vertex of the mesh, shown as color; gray for NaN and infinity.
    field_name : str
        Label of the field's color bar. Fields of the same name share one color scale in a picture.

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
            expected = (len(self.mesh.vertices),) if isinstance(self.mesh, Mesh) else ()
            if field.shape != expected:
                raise MeshError(
                    f"the field must be one number for each vertex of a mesh, shape {expected}, not {field.shape}"
                )
            field[~np.isfinite(field)] = np.nan
            field.setflags(write=False)
            object.__setattr__(self, "field", field)

    @property
    def subject(self) -> Drawable:
        """The object that determines the direction of view: the mesh if there is one, else the skeleton."""
        subject = self.mesh if self.mesh is not None else self.skeleton
        assert subject is not None  # see __post_init__
        return subject

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3) points that must fit into the drawing: skeleton nodes, vertices of faces, points of a cloud."""
        points = [self.skeleton.nodes] if self.skeleton is not None else []
        if isinstance(self.mesh, Mesh):
            points.append(
                self.mesh.vertices[np.bincount(self.mesh.faces.ravel(), minlength=len(self.mesh.vertices)) > 0]
            )
        elif self.mesh is not None:
            points.append(self.mesh.points)
        return np.concatenate(points)
