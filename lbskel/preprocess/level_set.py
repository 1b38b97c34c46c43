"""The level set of a function as triangles, by marching cubes in the cells around some points and those that it enters.

Lorensen, Cline 1987, "Marching cubes", https://doi.org/10.1145/37402.37422. The function is evaluated only at the
corners of cells that contain a given point, and then of every neighbor into which the level set continues, so that the
surface is closed although nothing is known of its extent.
"""

from __future__ import annotations

__all__ = ["level_set", "level_sets"]

from collections.abc import Callable, Sequence

import igl
import numpy as np
from numpy.typing import NDArray

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
# The four corners of the faces of a cell, and the step to the neighbor beyond each.
FACES = [([0, 3, 4, 7], [-1, 0, 0]), ([1, 2, 5, 6], [1, 0, 0]), ([0, 1, 4, 5], [0, -1, 0])]
FACES += [([2, 3, 6, 7], [0, 1, 0]), ([0, 1, 2, 3], [0, 0, -1]), ([4, 5, 6, 7], [0, 0, 1])]
BITS = 21  # of each coordinate of a cell in its key
MAX_ROUNDS = 400  # rings of cells added to close holes: more than the surface has cells across; a guess


def level_set(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]], points: NDArray[np.float64], size: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Compute the (v, 3) vertices and (f, 3) faces of the set where a function is zero; it is positive inside.

    Parameters
    ----------
    function : callable
        From (q, 3) positions to (q,) values.
    points : (n, 3) array of float
        Near the set; each connected part of it has one.
    size : float
        Side of a cell.
    """
    return level_sets(function, points, size, [0.0])[0]


def level_sets(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    points: NDArray[np.float64],
    size: float,
    levels: Sequence[float],
) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Compute the sets where a function has some values, each as vertices and faces, with one evaluation for all.

    Parameters
    ----------
    function, points, size
        As for :func:`level_set`.
    levels : sequence of float
    """
    origin = points.min(axis=0) - (0.5 + 2 ** (BITS - 1)) * size
    keys = _unique(_keys(((points - origin) / size).astype(np.int64)))
    start = _unique(np.concatenate([keys, *(_shifted(keys, step) for _, step in FACES)]))
    known = np.empty(0, dtype=np.int64), np.empty(0)
    surfaces = []
    for level in levels:
        surface, known = _one_level(function, origin, size, level, start, known)
        surfaces.append(surface)
    return surfaces


def _one_level(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    origin: NDArray[np.float64],
    size: float,
    level: float,
    cells: NDArray[np.int64],
    known: tuple[NDArray[np.int64], NDArray[np.float64]],
) -> tuple[tuple[NDArray[np.float64], NDArray[np.int64]], tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Vertices and faces of one set, which may leave the first cells, and the corners with values, before and new."""
    corner_keys, values = known
    new = cells
    for _ in range(MAX_ROUNDS):
        missing = np.setdiff1d(_corners(new), corner_keys)
        if len(missing):
            found = function(origin + _coordinates(missing) * size)
            corner_keys, values = np.concatenate([corner_keys, missing]), np.concatenate([values, found])
            order = np.argsort(corner_keys)
            corner_keys, values = corner_keys[order], values[order]
        inside = values[np.searchsorted(corner_keys, _corner_table(new))] > level
        entered = [
            _shifted(new[inside[:, face].any(axis=1) & ~inside[:, face].all(axis=1)], step) for face, step in FACES
        ]
        new = np.setdiff1d(np.concatenate(entered), cells)
        if not len(new):
            break
        cells = np.union1d(cells, new)
    table = np.searchsorted(corner_keys, _corner_table(cells))
    inside = values[table] > level
    table = table[inside.any(axis=1) & ~inside.all(axis=1)]
    used, table = np.unique(table, return_inverse=True)
    V, F, _ = igl.marching_cubes(
        level - values[used],
        origin + _coordinates(corner_keys[used]) * size,
        np.ascontiguousarray(table.reshape(-1, 8)),
        0.0,
    )
    return (V, F.astype(np.int64)), (corner_keys, values)


def _unique(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.unique(keys)


def _keys(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """(c,) one number for each cell."""
    keys: NDArray[np.int64] = (cells[:, 0] << 2 * BITS) | (cells[:, 1] << BITS) | cells[:, 2]
    return keys


def _shifted(keys: NDArray[np.int64], step: list[int]) -> NDArray[np.int64]:
    """(c,) keys of the neighbors of cells."""
    offset = (step[0] << 2 * BITS) + (step[1] << BITS) + step[2]
    return keys + offset


def _coordinates(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(c, 3) integer coordinates."""
    mask = (1 << BITS) - 1
    return np.stack([keys >> 2 * BITS, (keys >> BITS) & mask, keys & mask], axis=1)


def _corner_table(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(c, 8) keys of the grid points at the corners of cells, in igl's order."""
    return np.stack([_shifted(keys, step) for step in CORNERS.tolist()], axis=1)


def _corners(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """(q,) keys of the grid points at the corners of cells, each once."""
    return np.unique(_corner_table(keys))
