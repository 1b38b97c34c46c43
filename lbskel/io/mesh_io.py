"""Reading and writing meshes; paths for :func:`lbskel.as_mesh`.

All vertices of a file are kept in their order, also those that no face uses, so that results per vertex fit the file;
STL has no shared vertices, so equal corners are merged. Only glTF and 3MF are read through trimesh. In the other
formats trimesh 5.2 accepts truncated OFF and PLY files silently and, in OBJ, drops unused vertices, splits by material,
reads index 0 as 1 and miscounts relative indices.
"""

from __future__ import annotations

__all__ = ["MESH_READERS", "MESH_WRITERS", "read_mesh", "write_mesh"]

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.io.atomic_write import write_safely
from lbskel.io.gltf import read_gltf
from lbskel.io.obj import encode_obj, read_obj
from lbskel.io.off import encode_off, read_off
from lbskel.io.ply_mesh import encode_ply, read_ply
from lbskel.io.polygon_soup import PolygonSoup, mesh_from_polygons
from lbskel.io.stl import encode_stl, read_stl
from lbskel.io.text import convert_errors, known_extension, prefix_errors
from lbskel.io.threemf import read_3mf
from lbskel.io.vtk_legacy import read_vtk
from lbskel.io.vtk_polydata import read_vtp_mesh

MESH_READERS: dict[str, Callable[[Path], PolygonSoup]] = {
    "obj": read_obj,
    "off": read_off,
    "ply": read_ply,
    "stl": read_stl,
    "glb": read_gltf,
    "gltf": read_gltf,
    "3mf": read_3mf,
    "vtp": read_vtp_mesh,
    "vtk": read_vtk,
}

MESH_WRITERS: dict[str, Callable[[Mesh], str | bytes]] = {
    "obj": encode_obj,
    "off": encode_off,
    "ply": encode_ply,
    "stl": encode_stl,
}


@as_mesh.register(str)
@as_mesh.register(os.PathLike)
def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    r"""Read a triangle mesh; ``notes`` says what was changed on reading.

    Parameters
    ----------
    path : path-like
        With an extension in MESH_READERS.

    Raises
    ------
    FormatError
        If there is no such file or it is not in the format of its extension.
    MeshError
        If a coordinate is not finite, a face uses a vertex that does not exist, or there are no faces.
    MissingDependency
        If the format needs a package that is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "square.obj"
    ...     _ = path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    ...     mesh = read_mesh(path)
    >>> mesh, mesh.notes
    (Mesh(4 vertices, 2 faces), ('1 polygon was cut into triangles',))
    """
    read = MESH_READERS[known_extension(path, MESH_READERS, "meshes")]
    with convert_errors(path):
        return mesh_from_polygons(read(Path(path)))


def write_mesh(path: str | os.PathLike[str], mesh: Any, *, force: bool = False) -> None:
    """Write a mesh; all formats except STL keep the float64 coordinates bit for bit.

    Parameters
    ----------
    path : path-like
        With an extension in MESH_WRITERS.
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    FormatError
        If the extension is unknown, the format cannot store the mesh, or the file exists or cannot be written.
    MeshError
        If ``mesh`` is not a mesh.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lbskel.write_mesh(Path(folder) / "ring.ply", torus(1.0, 0.2, 16, 8))
    ...     lbskel.read_mesh(Path(folder) / "ring.ply")
    Mesh(128 vertices, 256 faces)
    """
    encode = MESH_WRITERS[known_extension(path, MESH_WRITERS, "meshes")]
    given = as_mesh(mesh)
    with prefix_errors(path):
        data = encode(given)
    write_safely(path, data, force)
