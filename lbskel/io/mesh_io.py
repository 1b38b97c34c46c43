"""Meshes and point clouds from files and into files; what users have, a path included, as a Mesh.

The vertices of a file keep their number and order, also those that no face uses, so that what is computed on them
can be handed back. All but glTF and 3MF is read here and not through trimesh, which (5.2) is silent about a truncated
OFF or PLY file and, in OBJ, drops unused vertices, splits by material, takes index 0 for 1 and miscounts relative ones.
"""

from __future__ import annotations

__all__ = ["MESH_READERS", "MESH_WRITERS", "POINT_READERS", "read_mesh", "read_points", "write_mesh"]

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
from lbskel.io.atomic_write import write_safely
from lbskel.io.gltf import read_gltf
from lbskel.io.obj import obj_text, read_obj
from lbskel.io.off import off_text, read_off
from lbskel.io.ply_mesh import mesh_ply, read_ply
from lbskel.io.polygon_soup import Polygons, mesh_of
from lbskel.io.stl import mesh_stl, read_stl
from lbskel.io.text import naming, reading, suffix_in
from lbskel.io.threemf import read_3mf
from lbskel.io.xyz import read_xyz

MESH_READERS: dict[str, Callable[[Path], Polygons]] = {
    "obj": read_obj,
    "off": read_off,
    "ply": read_ply,
    "stl": read_stl,
    "glb": read_gltf,
    "gltf": read_gltf,
    "3mf": read_3mf,
}

MESH_WRITERS: dict[str, Callable[[Mesh], str | bytes]] = {
    "obj": obj_text,
    "off": off_text,
    "ply": mesh_ply,
    "stl": mesh_stl,
}

POINT_READERS: dict[str, Callable[[Path], Polygons]] = {"xyz": read_xyz, "ply": read_ply, "off": read_off}


@as_mesh.register(str)
@as_mesh.register(os.PathLike)
def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The triangle mesh in a file; ``notes`` says what was done to it on the way in.

    Parameters
    ----------
    path : path-like
        With an extension in MESH_READERS.

    Raises
    ------
    FormatError
        If there is no such file or it is not of the format that its extension tells.
    MeshError
        If it is, but a coordinate is not finite, a face names a vertex that does not exist, or there is no face.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "square.obj"
    ...     _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 1 1 0\\nv 0 1 0\\nf 1 2 3 4\\n")
    ...     mesh = read_mesh(path)
    >>> mesh, mesh.notes
    (Mesh(4 vertices, 2 faces), ('1 polygons were cut into triangles',))
    """
    read = MESH_READERS[suffix_in(path, MESH_READERS, "meshes")]
    with reading(path):
        return mesh_of(read(Path(path)))


def read_points(path: str | os.PathLike[str]) -> PointCloud:
    """The points in a file; faces, normals and colors are passed over.

    Parameters
    ----------
    path : path-like
        With an extension in POINT_READERS.

    Raises
    ------
    FormatError
        If there is no such file or it is not of the format that its extension tells.
    MeshError
        If it is, but holds no point or a coordinate is not finite.
    """
    read = POINT_READERS[suffix_in(path, POINT_READERS, "point clouds")]
    with reading(path):
        return PointCloud(read(Path(path)).points)


def write_mesh(path: str | os.PathLike[str], mesh: Any, *, force: bool = False) -> None:
    """Write a mesh; all formats but STL give back the same float64 coordinates.

    Parameters
    ----------
    path : path-like
        With an extension in MESH_WRITERS.
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    FormatError
        If the extension is unknown, the format cannot hold the mesh, or the file must not or cannot be written.
    """
    encode = MESH_WRITERS[suffix_in(path, MESH_WRITERS, "meshes")]
    given = as_mesh(mesh)
    with naming(path):
        data = encode(given)
    write_safely(path, data, force)
