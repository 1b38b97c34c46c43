"""Skeletons into files and from files: one table of formats, with what each cannot hold."""

from __future__ import annotations

__all__ = ["FORMATS", "Format", "read_skeleton", "write_skeleton"]

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lbskel.errors import FormatError, MeshError
from lbskel.geometry.mesh import first_few
from lbskel.io.atomic_write import Content, write_all_safely
from lbskel.io.csv import read_csv, skeleton_csv
from lbskel.io.graphml import read_graphml, skeleton_graphml
from lbskel.io.json_npz import read_json, read_npz, skeleton_json, skeleton_npz
from lbskel.io.obj import read_obj_skeleton, skeleton_obj
from lbskel.io.ply_mesh import read_ply_skeleton, skeleton_ply
from lbskel.io.swc import read_swc, skeleton_swc
from lbskel.io.text import naming, reading, suffix_in
from lbskel.io.vtp import read_vtp, skeleton_vtp
from lbskel.skeleton.skeleton import Skeleton


class Format(NamedTuple):
    """A file format of skeletons.

    Parameters
    ----------
    read : callable
        From a path to a Skeleton.
    contents : callable
        From a Skeleton and a path to the content of each file to be written.
    loses : tuple of str
        What does not come back: ``radii``, ``order`` (of the nodes), ``node_of_vertex``, ``radius_kind``, ``extras``
        (mean radii and anchors), ``report``.
    only_trees : bool
        Whether cycles must be cut; ``contents`` then takes ``cut_cycles`` and ``root``.
    """

    read: Callable[[Path], Skeleton]
    contents: Callable[..., Mapping[Path, Content]]
    loses: tuple[str, ...] = ()
    only_trees: bool = False


FORMATS: dict[str, Format] = {
    "swc": Format(read_swc, skeleton_swc, ("order", "node_of_vertex", "extras", "report"), only_trees=True),
    "json": Format(read_json, skeleton_json),
    "npz": Format(read_npz, skeleton_npz),
    "ply": Format(read_ply_skeleton, skeleton_ply, ("extras", "report")),
    "vtp": Format(read_vtp, skeleton_vtp, ("extras", "report")),
    "graphml": Format(read_graphml, skeleton_graphml, ("node_of_vertex", "extras", "report")),
    "csv": Format(read_csv, skeleton_csv, ("node_of_vertex", "radius_kind", "extras", "report")),
    "obj": Format(read_obj_skeleton, skeleton_obj, ("radii", "node_of_vertex", "radius_kind", "extras", "report")),
}


def write_skeleton(
    path: str | os.PathLike[str],
    skeleton: Skeleton,
    *,
    force: bool = False,
    cut_cycles: bool = False,
    root: int | None = None,
) -> None:
    """Write a skeleton in the format that the extension tells; numbers come back the same to the last bit.

    Parameters
    ----------
    path : path-like
        With an extension in FORMATS. A csv gets a second file beside it, ``hand.csv`` and ``hand_edges.csv``.
    skeleton : Skeleton
    force : bool
        Whether files that exist may be replaced.
    cut_cycles : bool
        For a format that holds trees only (swc): whether each cycle may be cut at its longest edge. The cuts are
        noted in the file and undone by :func:`read_skeleton`.
    root : int, optional
        For such a format: the node that is the root of its component; by default the first node of each is.

    Raises
    ------
    FormatError
        If the extension is unknown, the format cannot hold the skeleton, or a file must not or cannot be written.
    MissingDependency
        If the format needs a package that is not installed.
    """
    entry = FORMATS[suffix_in(path, FORMATS, "skeletons")]
    options: dict[str, Any] = {"cut_cycles": cut_cycles, "root": root} if entry.only_trees else {}
    with naming(path):
        _check(skeleton)
        contents = entry.contents(skeleton, Path(path), **options)
    write_all_safely(contents, force)


def read_skeleton(path: str | os.PathLike[str]) -> Skeleton:
    """The skeleton in a file; what the format does not hold is empty, and radii NaN.

    Parameters
    ----------
    path : path-like
        With an extension in FORMATS.

    Raises
    ------
    FormatError
        If there is no such file or it holds no skeleton of the format that its extension tells.
    MissingDependency
        If the format needs a package that is not installed.

    Examples
    --------
    >>> import lbskel, pathlib, tempfile
    >>> triangle = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1], [1, 2], [0, 2]], [0.1, 0.2, 0.3])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "triangle.swc"
    ...     write_skeleton(path, triangle, cut_cycles=True)
    ...     print(path.read_text(), read_skeleton(path))
    # radius_kind inscribed
    # id type x y z radius parent
    1 0 0.0 0.0 0.0 0.1 -1
    2 0 1.0 0.0 0.0 0.2 1
    3 0 0.0 2.0 0.0 0.3 1
    # cut edge 2 3
     Skeleton(3 nodes, 3 edges, 0 tips, 0 junctions, 1 cycles)
    """
    entry = FORMATS[suffix_in(path, FORMATS, "skeletons")]
    with reading(path):
        try:
            skeleton = entry.read(Path(path))
        except MeshError as error:  # of Skeleton: indices of the file that name no node
            raise FormatError(str(error)) from None
        _check(skeleton)
        return skeleton


def _check(skeleton: Skeleton) -> None:
    """Raise a FormatError for a skeleton without nodes or with one that is nowhere."""
    if not len(skeleton.nodes):
        raise FormatError("the skeleton has no nodes")
    bad = np.flatnonzero(~np.isfinite(skeleton.nodes).all(axis=1))
    if len(bad):
        raise FormatError(f"nodes {first_few(bad)} of the skeleton have NaN or infinite coordinates")
