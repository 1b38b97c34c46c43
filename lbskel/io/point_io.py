"""Reading of point clouds, and conversion of what a user has to a mesh or a point cloud."""

from __future__ import annotations

__all__ = ["POINT_READERS", "POINT_WRITERS", "as_shape", "read_points"]

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
from lbskel.io.las import read_las
from lbskel.io.mesh_io import MESH_READERS
from lbskel.io.npy import encode_npy, read_npy, read_npz
from lbskel.io.obj import read_obj
from lbskel.io.off import read_off
from lbskel.io.pcd import read_pcd
from lbskel.io.ply_mesh import encode_ply_cloud, read_ply
from lbskel.io.polygon_soup import PolygonSoup, mesh_from_polygons
from lbskel.io.text import convert_errors, format_rows, known_extension
from lbskel.io.xyz import read_xyz

POINT_READERS: dict[str, Callable[[Path], PolygonSoup]] = {
    "xyz": read_xyz,
    "txt": read_xyz,
    "csv": read_xyz,
    "ply": read_ply,
    "off": read_off,
    "obj": read_obj,
    "npy": read_npy,
    "npz": read_npz,
    "pcd": read_pcd,
    "las": read_las,
    "laz": read_las,
}

POINT_WRITERS: dict[str, Callable[[PointCloud], bytes]] = {
    "ply": encode_ply_cloud,
    "xyz": lambda cloud: format_rows("", cloud.points).encode(),
    "npy": lambda cloud: encode_npy(cloud.points),
}


def read_points(path: str | os.PathLike[str]) -> PointCloud:
    """Read a point cloud; faces, normals and colors are ignored.

    Parameters
    ----------
    path : path-like
        With an extension in POINT_READERS.

    Raises
    ------
    FormatError
        If there is no such file or it is not in the format of its extension.
    MeshError
        If there are no points or a coordinate is not finite.
    MissingDependency
        If it is a LAZ file and laspy is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "cloud.xyz"
    ...     _ = path.write_text("0 0 0; 1 2 3".replace("; ", chr(10)))
    ...     lbskel.read_points(path)
    PointCloud(2 points)
    """
    read = POINT_READERS[known_extension(path, POINT_READERS, "point clouds")]
    with convert_errors(path):
        return PointCloud(read(Path(path)).points)


def as_shape(data: Any) -> Mesh | PointCloud:
    """Convert what users have to a Mesh or, where it has points and no faces, to a PointCloud.

    Parameters
    ----------
    data : Mesh, PointCloud, path-like, (n, 3) array, pair of array_like, or mesh or cloud object
        A file with faces is a mesh, one without is a cloud. Objects of other packages with ``points`` or ``vertices``
        and without faces, such as those of Open3D and trimesh, are clouds. Everything else goes to
        :func:`lbskel.as_mesh`.

    Raises
    ------
    FormatError
        If the data is a path and neither a mesh nor a cloud can be read from it.
    MeshError
        If the data is neither a mesh nor a cloud, or Mesh or PointCloud rejects it.
    MissingDependency
        If the format of a file needs a package that is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> from lbskel.io import as_shape
    >>> as_shape(np.zeros((4, 3)))
    PointCloud(4 points)
    """
    if isinstance(data, Mesh | PointCloud):
        return data
    if isinstance(data, str | os.PathLike):
        readers = POINT_READERS | MESH_READERS
        extension = known_extension(data, readers, "meshes and point clouds")
        with convert_errors(data):
            polygons = readers[extension](Path(data))
            has_faces = extension in MESH_READERS and (len(polygons.sizes) or extension not in POINT_READERS)
            return mesh_from_polygons(polygons) if has_faces else PointCloud(polygons.points)
    if isinstance(data, np.ndarray) and data.ndim == 2 and data.shape[1] == 3:
        return PointCloud(data)
    has_points_alone = getattr(data, "n_verts", None) == getattr(data, "n_cells", 0)  # of pyvista, with an empty list
    if has_points_alone or not any(hasattr(data, name) for name in ("faces", "cells_dict")):
        for name in ("points", "vertices"):
            if hasattr(data, name):
                return PointCloud(np.asarray(getattr(data, name)))
    return as_mesh(data)
