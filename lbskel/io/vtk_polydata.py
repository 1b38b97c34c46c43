"""Meshes in VTK's polygonal data: polygons and triangle strips, from XML files (.vtp).

meshio 5.3 reads no polygonal data, and vtk itself, of 100 MB, ends the process on a damaged file. The arrays are those
that :mod:`lbskel.io.vtk_xml` decodes. Lines and vertices are not part of the surface and are left out.
Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

__all__ = ["Cells", "join_cells", "read_vtp_mesh", "triangles_of_strips", "wrong_data_set"]

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, were
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.text import as_integers, read_bytes
from lbskel.io.vtk_xml import VtkFile, find_array, parse_vtk

Cells: TypeAlias = tuple[NDArray[np.int64], NDArray[np.int64]]  # points of all cells, concatenated; number of each

NO_CELLS: Cells = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


def read_vtp_mesh(path: Path) -> PolygonSoup:
    """Read the polygons and triangle strips of a VTP file; the pieces are joined."""
    file = parse_vtk(read_bytes(path))
    kind = file.root.get("type", "an unknown type")
    if file.root.tag != "VTKFile" or kind != "PolyData":
        raise wrong_data_set(kind)
    points, polygons, strips = [], [], []
    first = 0
    for piece in file.root.findall("PolyData/Piece"):
        positions = find_array(file, piece.find("Points"), None)
        if positions is None or positions.size % 3:
            raise FormatError("the points do not have three coordinates each")
        points.append(positions.reshape(-1, 3))
        polygons.append(_read_cells(file, piece.find("Polys"), first))
        strips.append(_read_cells(file, piece.find("Strips"), first))
        first += len(points[-1])
    return join_cells(points, polygons, strips)


def join_cells(
    points: Sequence[NDArray[np.float64]], polygons: Sequence[Cells], strips: Sequence[Cells]
) -> PolygonSoup:
    """Join the points and cells of all pieces: first the polygons, then the triangles of the strips.

    Raises
    ------
    FormatError
        If there are neither polygons nor strips.
    """
    cells = [*polygons, *map(triangles_of_strips, strips)]
    corners, sizes = (np.concatenate([NO_CELLS[part], *(cell[part] for cell in cells)]) for part in (0, 1))
    if not len(sizes):
        raise FormatError("there are no polygons and no triangle strips: lines and points are no surface")
    n_strips = sum(len(lengths) for _, lengths in strips)
    notes = (f"{were(n_strips, 'triangle strip')} cut into triangles",) if n_strips else ()
    return PolygonSoup(np.concatenate(points), corners, sizes, notes)


def triangles_of_strips(strips: Cells) -> Cells:
    """Cut triangle strips into triangles; every second one is turned, so that all have the orientation of the first.

    Raises
    ------
    FormatError
        If a strip has fewer than three points.
    """
    points, lengths = strips
    if (lengths < 3).any():
        raise FormatError(f"triangle strip {int(np.argmax(lengths < 3))} (0-based) has fewer than three points")
    sizes = lengths - 2
    place = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)  # of each triangle in its strip
    start = np.repeat(np.cumsum(lengths) - lengths, sizes) + place
    is_odd = place % 2
    triangles = points[np.stack([start + is_odd, start + 1 - is_odd, start + 2], axis=1)]
    return triangles.ravel(), np.full(len(triangles), 3)


def wrong_data_set(kind: str) -> FormatError:
    """Return the error of a file with a data set that is no surface."""
    return FormatError(
        f"a VTK data set of {kind}, not of PolyData; take its surface first, in ParaView with Filters > Extract Surface"
    )


def _read_cells(file: VtkFile, section: Element | None, first: int) -> Cells:
    """Read the cells of a section; ``first`` is the number of points of the pieces before."""
    connectivity, offsets = (find_array(file, section, name) for name in ("connectivity", "offsets"))
    if connectivity is None or offsets is None:
        return NO_CELLS
    points, ends = as_integers(connectivity, "connectivity of cells"), as_integers(offsets, "offsets of cells")
    sizes = np.diff(ends, prepend=0)
    if (sizes < 0).any() or sizes.sum() != len(points):
        raise FormatError("the offsets of the cells do not match their connectivity")
    return points + first, sizes
