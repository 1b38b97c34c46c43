"""Reading and writing skeletons: the table of formats, with what each of them loses."""

from __future__ import annotations

__all__ = ["FORMATS", "Format", "read_skeleton", "require_writable", "write_skeleton"]

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lbskel.errors import FormatError, MeshError
from lbskel.io.atomic_write import Content, write_all_safely
from lbskel.io.csv import encode_csv, read_csv
from lbskel.io.graphml import encode_graphml, read_graphml
from lbskel.io.json_npz import encode_json, encode_npz, read_json, read_npz
from lbskel.io.obj import encode_obj_skeleton, read_obj_skeleton
from lbskel.io.ply_mesh import encode_ply_skeleton, read_ply_skeleton
from lbskel.io.swc import encode_swc, read_swc
from lbskel.io.text import convert_errors, known_extension, prefix_errors
from lbskel.io.vtp import encode_vtp, read_vtp
from lbskel.skeleton.skeleton import Skeleton


class Format(NamedTuple):
    """A file format of skeletons.

    Parameters
    ----------
    read : callable
        Takes a path, returns a Skeleton.
    encode : callable
        Takes a Skeleton and a path, returns the content of each file to be written.
    loses : tuple of str
        What the format does not store: ``radii``, ``order`` (of the nodes), ``node_of_vertex``, ``radius_kind``,
        ``extras`` (mean radii and anchors), ``report``.
    only_trees : bool
        Whether other programs read a tree from the format, and cycles are cut; ``encode`` then takes
        ``root``, ``scale`` and ``units`` as well.
    """

    read: Callable[[Path], Skeleton]
    encode: Callable[..., Mapping[Path, Content]]
    loses: tuple[str, ...] = ()
    only_trees: bool = False


FORMATS: dict[str, Format] = {
    "swc": Format(read_swc, encode_swc, ("order", "node_of_vertex", "extras", "report"), only_trees=True),
    "json": Format(read_json, encode_json),
    "npz": Format(read_npz, encode_npz),
    "ply": Format(read_ply_skeleton, encode_ply_skeleton, ("extras", "report")),
    "vtp": Format(read_vtp, encode_vtp, ("extras", "report")),
    "graphml": Format(read_graphml, encode_graphml, ("node_of_vertex", "extras", "report")),
    "csv": Format(read_csv, encode_csv, ("node_of_vertex", "radius_kind", "extras", "report")),
    "obj": Format(
        read_obj_skeleton, encode_obj_skeleton, ("radii", "node_of_vertex", "radius_kind", "extras", "report")
    ),
}


def write_skeleton(
    path: str | os.PathLike[str],
    skeleton: Skeleton,
    *,
    force: bool = False,
    root: int | None = None,
    scale: float = 1.0,
    units: str | None = None,
) -> None:
    """Write a skeleton in the format of the extension; numbers are read back bit for bit.

    SWC is a format of trees: cycles are cut as :func:`lbskel.to_tree` cuts them, and the edges that were cut are stored
    as comments, from which :func:`read_skeleton` restores them. Unknown radii are written as 0 there, and with a scale
    numbers are read back up to rounding.

    Parameters
    ----------
    path : path-like
        With an extension in FORMATS. For csv a second file is written, ``hand_edges.csv`` next to ``hand.csv``.
    skeleton : Skeleton
    force : bool
        Whether existing files may be replaced.
    root : int, optional
        For swc: the node that is the root of its component; by default the first node, which
        :func:`lbskel.skeletonize` makes the soma or the thickest tip.
    scale : float
        For swc: factor of the positions and radii in the file, such as 0.001 from nanometers to micrometers. It is
        stored as a comment, and :func:`read_skeleton` divides by it.
    units : str, optional
        For swc: name of the units in the file, such as ``um``, stored as a comment.

    Raises
    ------
    FormatError
        If the extension is unknown, the format cannot store the skeleton, a scale or units, the root is not a node, the
        scale is not a positive number, or a file exists or cannot be written.
    MissingDependency
        If the format needs a package that is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> stick = lbskel.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [0.1, 0.2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lbskel.write_skeleton(Path(folder) / "stick.swc", stick)
    ...     lbskel.read_skeleton(Path(folder) / "stick.swc")
    Skeleton(2 nodes, 1 edge, 2 tips, 0 junctions, 0 cycles)
    """
    entry = FORMATS[known_extension(path, FORMATS, "skeletons")]
    with prefix_errors(path):
        _require_nodes(skeleton)
        options = _tree_options(entry, root, scale, units)
        contents = entry.encode(skeleton, Path(path), **options)
    write_all_safely(contents, force)


def read_skeleton(path: str | os.PathLike[str]) -> Skeleton:
    """Read a skeleton; fields that the format does not store are empty, radii are NaN.

    Parameters
    ----------
    path : path-like
        With an extension in FORMATS.

    Raises
    ------
    FormatError
        If there is no such file or it is not a skeleton in the format of its extension.
    MissingDependency
        If the format needs a package that is not installed.

    Examples
    --------
    >>> import lbskel, pathlib, tempfile
    >>> triangle = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1], [1, 2], [0, 2]], [0.1, 0.2, 0.3])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "triangle.swc"
    ...     write_skeleton(path, triangle)
    ...     print(path.read_text(), read_skeleton(path))
    # radius_kind inscribed
    # cycles are cut at their thinnest edges, which lbskel restores:
    # cut edge 1 3
    # id type x y z radius parent
    1 0 0.0 0.0 0.0 0.1 -1
    2 0 1.0 0.0 0.0 0.2 1
    3 0 0.0 2.0 0.0 0.3 2
     Skeleton(3 nodes, 3 edges, 0 tips, 0 junctions, 1 cycle)
    """
    entry = FORMATS[known_extension(path, FORMATS, "skeletons")]
    with convert_errors(path):
        try:
            skeleton = entry.read(Path(path))
        except MeshError as error:  # raised by Skeleton for indices that are not nodes
            raise FormatError(str(error)) from None
        _require_nodes(skeleton)
        return skeleton


def require_writable(name: str, *, scale: float = 1.0, units: str | None = None) -> None:
    """Raise the error that writing a format would raise, before a skeleton is made for it.

    Parameters
    ----------
    name : str
        A format in FORMATS.
    scale, units
        As for :func:`write_skeleton`.

    Raises
    ------
    FormatError, MissingDependency
        As :func:`write_skeleton`.
    """
    one_node = Skeleton(np.zeros((1, 3)), np.empty((0, 2), np.int64), np.ones(1))
    FORMATS[name].encode(one_node, Path(f"a.{name}"), **_tree_options(FORMATS[name], None, scale, units))


def _tree_options(entry: Format, root: int | None, scale: float, units: str | None) -> dict[str, Any]:
    """Return the options of a format of trees; a root, a scale and units are an error with any other."""
    if entry.only_trees:
        return {"root": root, "scale": scale, "units": units}
    if root is not None:
        raise FormatError("a root is for swc; other formats keep the order of the nodes: give it to skeletonize")
    if scale != 1 or units is not None:
        trees = ", ".join(name for name, other in FORMATS.items() if other.only_trees)
        raise FormatError(
            f"a scale and units are stored by {trees} only; other formats keep the coordinates of the mesh: write "
            f"{trees}, in a batch by --format {trees}"
        )
    return {}


def _require_nodes(skeleton: Skeleton) -> None:
    """Raise a FormatError for a skeleton without nodes."""
    if not len(skeleton.nodes):
        raise FormatError("the skeleton has no nodes")
