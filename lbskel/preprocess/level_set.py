"""Level sets of a function as triangles, by marching cubes in the cells of some points and those that the sets enter.

Lorensen, Cline 1987, "Marching cubes", https://doi.org/10.1145/37402.37422. The function is evaluated only at the
corners of the cells that contain a given point, and then of every neighboring cell into which a level set continues. So
the surface is closed although its extent is not known.
"""

from __future__ import annotations

__all__ = ["LevelSet", "level_set", "level_sets"]

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.sorting import distinct

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
# The four corners of the faces of a cell, and the step to the neighbor beyond each.
FACES = [([0, 3, 4, 7], [-1, 0, 0]), ([1, 2, 5, 6], [1, 0, 0]), ([0, 1, 4, 5], [0, -1, 0])]
FACES += [([2, 3, 6, 7], [0, 1, 0]), ([0, 1, 2, 3], [0, 0, -1]), ([4, 5, 6, 7], [0, 0, 1])]
BITS = 21  # of each coordinate of a cell in its key
MAX_ROUNDS = 400  # rings of cells added to close holes: more than the surface has cells across; a guess
# Upper bound on the number of cells between points. It follows from the bits of a key: added cells need keys, too
MAX_ACROSS = (1 << BITS - 1) - MAX_ROUNDS


@dataclass(frozen=True, eq=False)
class LevelSet:
    """The set where a function has a value, in the cells of a grid.

    Parameters
    ----------
    positions : (g, 3) array of float
        Corners of the cells.
    heights : (g,) array of float
        How far the values of the function there are below that of the set.
    cells : (c, 8) array of int
        The corners of each cell that the set enters.
    """

    positions: NDArray[np.float64]
    heights: NDArray[np.float64]
    cells: NDArray[np.int64]

    @property
    def least_handles(self) -> float:
        """Number of handles if the set is closed and connected, else a lower bound; infinite for an empty set."""
        if len(self.cells) == 0:
            return np.inf
        kinds = (self.heights > 0)[self.cells] @ (1 << np.arange(8))
        return float(1 - _characteristics()[kinds].sum() / 2)

    def triangles(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(v, 3) vertices and (f, 3) faces."""
        V, F, _ = igl.marching_cubes(self.heights, self.positions, self.cells, 0.0)
        return V, F.astype(np.int64)


@cache
def _characteristics() -> NDArray[np.float64]:
    """(256,) share of a cell in the Euler characteristic of a closed level set, by which of its corners are high.

    A vertex belongs to the four cells at an edge of the grid, and a triangle has a half of three edges: vertices minus
    edges plus faces are a quarter of the vertices of a cell minus half of its triangles.
    """
    shares = np.zeros(256)
    for kind in range(1, 255):
        heights = np.where(kind >> np.arange(8) & 1, 1.0, -1.0)
        V, F, _ = igl.marching_cubes(heights, CORNERS.astype(np.float64), np.arange(8)[None], 0.0)
        shares[kind] = len(V) / 4 - len(F) / 2
    return shares


def level_set(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]], points: NDArray[np.float64], size: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Compute the (v, 3) vertices and (f, 3) faces of the set where a function is zero; it is positive inside.

    Parameters
    ----------
    function : callable
        From (q, 3) positions to (q,) values.
    points : (n, 3) array of float
        On the set or near it; only connected parts of the set that enter the cell of a point are found.
    size : float
        Side of a cell.
    """
    return next(level_sets(function, points, size, [0.0])).triangles()


def level_sets(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    points: NDArray[np.float64],
    size: float,
    levels: Sequence[float],
) -> Iterator[LevelSet]:
    """Yield the sets where a function has each of some values, with one evaluation for all.

    Parameters
    ----------
    function, points, size
        As for :func:`level_set`.
    levels : sequence of float

    Raises
    ------
    MeshError
        If the points are so far apart that the cells between them cannot be numbered.
    """
    across = np.ptp(points, axis=0).max() / size
    if across >= MAX_ACROSS:
        raise MeshError(
            f"the points are {across:.2g} cells of a grid apart, and at most {MAX_ACROSS:,} are possible: leave stray "
            "points out, as preprocess='auto' does"
        )
    origin = points.min(axis=0) - (0.5 + 2 ** (BITS - 1)) * size
    sorted_levels = np.sort(levels)
    cells = new = distinct(_keys(((points - origin) / size).astype(np.int64)))
    corners, values = np.empty(0, dtype=np.int64), np.empty(0)
    crossed = []
    for _ in range(MAX_ROUNDS):
        missing = _missing(distinct(_corner_table(new).ravel()), corners)
        if len(missing):
            found = function(origin + _coordinates(missing) * size)
            order = np.argsort(np.concatenate([corners, missing]), kind="stable")
            corners, values = np.concatenate([corners, missing])[order], np.concatenate([values, found])[order]
        at_corners = values[np.searchsorted(corners, _corner_table(new))]
        is_crossed = _are_between(at_corners, sorted_levels)
        new, at_corners = new[is_crossed], at_corners[is_crossed]
        crossed.append(new)
        entered = [_shifted(new[_are_between(at_corners[:, face], sorted_levels)], step) for face, step in FACES]
        new = _missing(distinct(np.concatenate(entered)), cells)
        if not len(new):
            break
        cells = distinct(np.concatenate([cells, new]))
    table = np.searchsorted(corners, _corner_table(np.sort(np.concatenate(crossed))))
    positions, at_corners = origin + _coordinates(corners) * size, values[table]
    low, high = at_corners.min(axis=1), at_corners.max(axis=1)
    for level in levels:
        yield LevelSet(positions, level - values, np.ascontiguousarray(table[(low <= level) & (level < high)]))


def _are_between(values: NDArray[np.float64], levels: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(r,) whether one of some increasing levels is at least the smallest value of a row and below the largest."""
    low, high = np.searchsorted(levels, values.min(axis=1)), np.searchsorted(levels, values.max(axis=1))
    answer: NDArray[np.bool_] = low < high
    return answer


def _missing(keys: NDArray[np.int64], known: NDArray[np.int64]) -> NDArray[np.int64]:
    """Select the keys that are not among the known ones; both are in ascending order."""
    if len(known) == 0:
        return keys
    place = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    missing: NDArray[np.int64] = keys[known[place] != keys]
    return missing


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
