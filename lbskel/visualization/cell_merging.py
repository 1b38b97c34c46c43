"""Simplification for display: the vertices of each cell of a grid are merged, whatever the topology of the surface.

Rossignac, Borrel 1993, "Multi-resolution 3D approximations for rendering complex scenes",
https://doi.org/10.1007/978-3-642-78114-8_29.
"""

from __future__ import annotations

__all__ = ["merged_by_cells"]

import numpy as np
from numpy.typing import NDArray


def merged_by_cells(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], max_faces: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Merge the vertices of each cell of a grid, so coarse that at most ``max_faces`` faces are left.

    Parameters
    ----------
    vertices : (n, 3) array of float
    faces : (m, 3) array of int
    max_faces : int

    Returns
    -------
    kept : (k,) array of int
        The vertex that stands for each cell: the one nearest to the mean of the cell's vertices.
    merged : (f, 3) array of int
        Faces, with indices into ``kept``; at most ``max_faces``.
    rows : (f,) array of int
        Index of the given face that each comes from.

    If every face lies within a cell, each is so small that any of them show as much: evenly chosen ones are left.
    """
    if len(faces) <= max_faces:
        return np.arange(len(vertices)), faces, np.arange(len(faces))
    is_used = np.bincount(faces.ravel(), minlength=len(vertices)) > 0
    if not is_used.all():  # the others may be anywhere, and would enlarge the grid
        numbers = np.cumsum(is_used) - 1
        kept, merged, rows = merged_by_cells(vertices[is_used], numbers[faces], max_faces)
        return np.flatnonzero(is_used)[kept], merged, rows
    low, extent = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0
    n_cells = np.sqrt(max_faces)  # along the longest side; a sphere of diameter n crosses 1.5 pi n^2 cells
    while True:
        cells = ((vertices - low) * (n_cells / extent)).astype(np.int64)
        width = int(n_cells) + 2
        _, cell_of = np.unique(cells @ [width * width, width, 1], return_inverse=True)
        corners = np.sort(cell_of[faces], axis=1)
        is_face = (corners[:, 0] < corners[:, 1]) & (corners[:, 1] < corners[:, 2])
        width = len(vertices)
        _, first = np.unique(corners[is_face] @ [width * width, width, 1], return_index=True)
        rows = np.flatnonzero(is_face)[np.sort(first)]
        if len(rows) <= max_faces:
            break
        n_cells *= 0.85
    if not len(rows):
        rows = np.linspace(0, len(faces) - 1, max_faces).astype(np.int64)
        used, numbers = np.unique(faces[rows], return_inverse=True)
        return used, numbers.reshape(-1, 3), rows
    count = np.maximum(np.bincount(cell_of), 1)[:, None]
    mean = np.stack([np.bincount(cell_of, axis) for axis in vertices.T], axis=1) / count
    order = np.argsort(((vertices - mean[cell_of]) ** 2).sum(axis=1), kind="stable")
    cells_in_order, first = np.unique(cell_of[order], return_index=True)
    kept = order[first]
    used, numbers = np.unique(cell_of[faces[rows]], return_inverse=True)
    return kept[np.searchsorted(cells_in_order, used)], numbers.reshape(-1, 3), rows
